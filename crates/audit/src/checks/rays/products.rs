//! Products with factors by rays, also in blocks, against sums over rows and the errors that the counts make.

use radgrad_scene::{BlockOperator, Certified, FactorOperator, RayFactors, largest};

use super::model::{Counts, Model, ROUNDED, SAME};
use crate::measures::measure::is_worse;

/// The error that single precision and a few sums of it leave in numbers up to 1.
const SINGLE: f64 = 2e-6;

pub(super) fn wrong(asked: &Counts<'_>, factors: &RayFactors) -> Result<Vec<String>, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let rows = factors.rows(0..factors.faces().len());
    let model = Model::new(asked, &rows, 0.0)?;
    let operator = FactorOperator::new(factors.clone());
    let count = asked.scene.faces().len();
    let first: Vec<f64> = asked.scene.polygons().map(|polygon| polygon.vertices()[0].z - 0.7).collect();
    let second: Vec<f64> = (0..count).map(|face| (3.0 * face as f64).sin()).collect();
    let mut findings = Vec::new();
    let largest_of = |numbers: Vec<f64>| numbers.into_iter().fold(0.0, largest);
    let ones = vec![1.0; count];
    // One sign may be as far off as the other.
    let bound = 2.0 * (model.deviation(largest_of(model.plain(&ones)), 1.0) + largest_of(model.moved(&ones)))
        + largest_of(model.near_errors(&ones));
    if is_worse((operator.error() - bound).abs(), SAME * bound) {
        findings.push(format!("products are said to be off by {}, by the counts {bound}", operator.error()));
    }
    let [fine, rough] = [operator.blocks(&asked.factors.middles(), 1e-9), operator.blocks(&asked.factors.middles(), 0.8)];
    let (fine, rough) = (fine.map_err(said)?, rough.map_err(said)?);
    let singles = 3 * factors.stored();
    if fine.bytes() < singles / 2 || rough.bytes() >= fine.bytes() {
        findings.push(format!("blocks take {} and {} bytes, their pairs {singles}", fine.bytes(), rough.bytes()));
    }
    let (moved, near_errors) = (model.moved(&ones), model.near_errors(&ones));
    for q in [&first, &second, &ones] {
        let Certified { product, error } = operator.certified(q).map_err(said)?;
        let mut stated = model.near_errors(q);
        for sign in [1.0, -1.0] {
            let part: Vec<f64> = q.iter().map(|q| largest(sign * q, 0.0)).collect();
            let peak = largest_of(part.clone());
            if peak > 0.0 {
                let sums = model.plain(&part).into_iter().zip(model.moved(&part));
                stated.iter_mut().zip(sums).for_each(|(error, (sum, moved))| *error += model.deviation(sum, peak) + moved);
            }
        }
        for row in &rows {
            let face = row.face;
            let sum: f64 = row.entries.iter().map(|entry| entry.factor * q[entry.face]).sum();
            let truth: f64 = asked.truth.row(face).map(|entry| entry.factor * q[entry.face]).sum();
            if is_worse((product[face] - sum).abs(), 1e-12) {
                findings.push(format!("the product at {face} is {}, by the row {sum}", product[face]));
            }
            if is_worse((product[face] - truth).abs(), error[face] + 1e-4) {
                findings.push(format!("the product at {face} is {} to {}, the truth {truth}", product[face], error[face]));
            }
            if is_worse((error[face] - stated[face]).abs(), SAME * stated[face]) {
                findings.push(format!("the error at {face} is {}, by the counts {}", error[face], stated[face]));
            }
        }
        for (blocks, is_fine) in [(&fine, true), (&rough, false)] {
            let in_blocks = blocks.certified(q).map_err(said)?;
            for face in 0..count {
                let apart = (in_blocks.product[face] - product[face]).abs();
                let more = in_blocks.error[face] - error[face];
                let is_same = is_fine || *q == ones;
                if is_worse(apart, if is_same { SINGLE } else { more + SINGLE }) {
                    findings.push(format!("in blocks the product at {face} is off by {apart:e}, the error {more:e} more"));
                }
                // Far blocks know of a counted sum that it is no more than the product.
                let expected = if *q == ones {
                    let counted = model.deviation(product[face] + moved[face], 1.0) + moved[face];
                    counted + near_errors[face] - error[face]
                } else {
                    f64::INFINITY
                };
                if more < -ROUNDED || more.is_nan() || more > expected + SINGLE || *q == ones && more < expected - SINGLE {
                    findings.push(format!("in blocks the error at {face} is {more:e} more, by the counts {expected:e}"));
                }
            }
        }
    }
    let negative: Vec<f64> = first.iter().map(|q| -q).collect();
    let signs = [operator.certified(&first), operator.certified(&negative), rough.certified(&first), rough.certified(&negative)];
    let [one, other, in_blocks, in_blocks_other] = signs;
    for [one, other] in [[one, other], [in_blocks, in_blocks_other]] {
        let errors = [one.map_err(said)?.error, other.map_err(said)?.error];
        if errors[0].iter().zip(&errors[1]).any(|(one, other)| is_worse((one - other).abs(), 1e-13 * one)) {
            findings.push("with the other sign a product has other errors".to_owned());
        }
    }
    let longer = [&first[..], &[0.0]].concat();
    if operator.apply(&longer).is_ok() || operator.apply_many(&first, 2).is_ok() {
        findings.push("a list that is not one number for each face is taken".to_owned());
    }
    let unit = 1.0 / (1u64 << 40) as f64;
    let little: Vec<f64> = second.iter().map(|q| q * unit).collect();
    let [one, other] = [operator.certified(&second), operator.certified(&little)];
    let (one, other) = (one.map_err(said)?.error, other.map_err(said)?.error);
    if one.iter().zip(&other).any(|(one, other)| is_worse((one * unit - other).abs(), 1e-13 * unit * one)) {
        findings.push("in another unit a product has other errors".to_owned());
    }
    let both = [&first[..], &second];
    findings.extend(columns(|q, columns| operator.apply_many(q, columns), both).map_err(said)?);
    for blocks in [&fine, &rough] {
        findings.extend(columns(|q, columns| blocks.apply_many(q, columns), both).map_err(said)?);
        findings.extend(reciprocal(blocks, asked.truth.areas()).map_err(said)?);
        let bytes = blocks.to_bytes();
        if BlockOperator::from_bytes(&bytes).ok().as_ref() != Some(blocks) {
            findings.push("blocks that were kept are others".to_owned());
        }
        let longer = [&bytes[..], &[0]].concat();
        if [&bytes[..bytes.len() - 1], &bytes[1..], &longer[..]].into_iter().any(|part| BlockOperator::from_bytes(part).is_ok()) {
            findings.push("other bytes are taken for blocks".to_owned());
        }
        // The logarithm and the first area, and of each face's sums those that are no counts.
        let first = 64;
        let places = [(56, false), (first, false), (first + 8 * count, true), (first + 16 * count, true)];
        findings.extend(damaged(&bytes, 48, &places, |bytes| BlockOperator::from_bytes(bytes).is_ok()));
    }
    Ok(findings)
}

/// Lists at once are those one after the other.
fn columns(
    products: impl Fn(&[f64], usize) -> Result<Vec<f64>, radgrad_scene::Error>,
    [first, second]: [&[f64]; 2],
) -> Result<Vec<String>, radgrad_scene::Error> {
    const COLUMNS: usize = 10;
    let column = |k: usize| if k.is_multiple_of(3) { first } else { second };
    let together: Vec<f64> = (0..first.len()).flat_map(|face| (0..COLUMNS).map(move |k| column(k)[face])).collect();
    let several = products(&together, COLUMNS)?;
    let single = [products(first, 1)?, products(second, 1)?];
    let differs = |k: usize| {
        let expected = &single[usize::from(!k.is_multiple_of(3))];
        (0..first.len()).any(|face| is_worse((several[face * COLUMNS + k] - expected[face]).abs(), 1e-12))
    };
    Ok((0..COLUMNS).filter(|&k| differs(k)).map(|k| format!("list {k} of {COLUMNS} at once has another product")).collect())
}

/// Bytes that are taken though the number of rays is 0, or the number at one of these places is not above 0, or below it where it may be 0.
pub(super) fn damaged(bytes: &[u8], rays: usize, places: &[(usize, bool)], is_taken: impl Fn(&[u8]) -> bool) -> Vec<String> {
    let with = |at: usize, number: [u8; 8]| {
        let mut bytes = bytes.to_vec();
        bytes[at..at + 8].copy_from_slice(&number);
        is_taken(&bytes)
    };
    let wrong = [-1e-3_f64, f64::NAN, f64::INFINITY, 0.0];
    let none = with(rays, [0; 8]).then(|| "bytes of no rays are taken".to_owned());
    let number = |(at, may_be_none): &(usize, bool)| {
        let number = wrong[..if *may_be_none { 3 } else { 4 }].iter().find(|number| with(*at, number.to_le_bytes()))?;
        Some(format!("bytes are taken with {number} at {at}"))
    };
    none.into_iter().chain(places.iter().filter_map(number)).collect()
}

/// A face gets of another one as much as it gives.
fn reciprocal(blocks: &BlockOperator, areas: &[f64]) -> Result<Vec<String>, radgrad_scene::Error> {
    let unit = |face: usize| (0..areas.len()).map(|k| f64::from(u8::from(k == face))).collect::<Vec<f64>>();
    let got = (0..areas.len()).map(|face| blocks.apply(&unit(face))).collect::<Result<Vec<_>, _>>()?;
    let itself = (0..areas.len()).filter(|&face| got[face][face] != 0.0);
    let mut findings: Vec<String> = itself.map(|i| format!("in blocks {i} gets {:e} of itself", got[i][i])).collect();
    for (i, j) in (0..areas.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let [there, back] = [areas[i] * got[j][i], areas[j] * got[i][j]];
        if there < 0.0 || is_worse((there - back).abs(), 1e-12 * there) {
            findings.push(format!("in blocks {i} gets {there:e} of {j}, and that {back:e}"));
        }
    }
    Ok(findings)
}
