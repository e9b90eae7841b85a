//! A few lamps of every kind together, by a tree and each on lanes beside others, against each of them alone.
//!
//! Trees of one lamp or a few press on the rule by which a node is left out: its whole contribution is then the error.

use glam::DVec3;
use radgrad_core::batch::{Answers, Counts, EmitterTree, Emitters, Engine, Precision, Receivers};
use radgrad_core::{Answer, Emission, Emitter, Error, Polygon, Receiver, evaluate_to};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::checks::batches::{Cast, DOUBLE, SINGLE, entry};
use crate::measures::measure::is_worse;

/// A lamp about a place, of a size, that faces about a way.
fn lamp(sampler: &mut Sampler, place: DVec3, size: f64, way: DVec3) -> Result<Emitter, Error> {
    let (u, v) = way.any_orthonormal_pair();
    let thin = if sampler.one_in(5) { sampler.spread(-40, -4) } else { sampler.between(0.3, 1.0) };
    let at = |[x, y]: [f64; 2]| place + (u * x + v * (y * thin)) * size;
    // A dart is not convex.
    let outlines: [&[[f64; 2]]; 5] = [
        &[[-0.5, -0.4], [0.6, -0.3], [0.1, 0.6]],
        &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        &[[-0.5, -0.5], [0.0, -0.1], [0.5, -0.5], [0.0, 0.6]],
        &[[0.0, -0.1], [0.5, -0.5], [0.0, 0.6], [-0.5, -0.5]],
        &[[-0.5, -0.5], [0.3, -0.6], [0.6, 0.0], [0.2, 0.5], [-0.5, 0.4]],
    ];
    let outline = outlines[sampler.below(5) as usize];
    let polygon = Polygon::from_rounded(outline.iter().copied().map(at).collect(), 4.0 * f64::EPSILON * (place.length() + size))?;
    let emission = match sampler.below(4) {
        0 if outline.len() == 3 => Emission::at_vertices([(); 3].map(|()| sampler.between(0.5, 2.0)).to_vec()),
        1 => {
            let steep = u * sampler.sign() * sampler.spread(-40, 0);
            Emission::gradient(sampler.between(0.5, 2.0), (steep - polygon.normal() * steep.dot(polygon.normal())) / size)
        }
        2 => Emission::Constant(-sampler.between(0.5, 2.0)),
        _ => Emission::Constant(sampler.between(0.5, 2.0)),
    };
    Emitter::new(polygon, emission)
}

/// A receiver, and lamps over it.
fn drawn(sampler: &mut Sampler) -> Result<(Receiver, Vec<Emitter>), Error> {
    let unit = [1.0, 1.0, libm::ldexp(1.0, 100), libm::ldexp(1.0, -500)][sampler.below(4) as usize];
    let count = 1 + sampler.below(4);
    let far = sampler.spread(-6, 12);
    let spread = if sampler.one_in(2) { 0.1 } else { 1.0 };
    let normal = sampler.direction();
    // Now and then level with a lamp, or behind it.
    let lean = if sampler.one_in(3) { 1.0 } else { 0.2 };
    let mut lamps = Vec::new();
    for _ in 0..count {
        let place = (normal * far + sampler.cube() * spread * (0.2 + far * 0.2)) * unit;
        let way = (sampler.cube() * lean - normal).normalize_or(DVec3::Z);
        let size = unit * sampler.between(0.5, 1.5);
        lamps.push(lamp(sampler, place, size, way)?);
    }
    let x = sampler.cube() * (0.1 * unit);
    Ok((Receiver::new(x, normal, 1.0)?, lamps))
}

/// All numbers of the totals of case `index` by a tree, and its work: to be remembered.
///
/// # Errors
/// If a lamp is refused or an answer overflows.
pub(crate) fn recorded(index: u64) -> Result<Vec<f64>, Error> {
    let sampler = &mut Sampler::new(53, "lamps", index);
    let (receiver, lamps) = drawn(sampler)?;
    let (x, n) = (receiver.position().to_array().map(|c| [c]), receiver.direction().to_array().map(|c| [c]));
    let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[1.0])?;
    let tree = EmitterTree::new(&lamps);
    let (mut answers, mut said) = (Answers::new(), Vec::new());
    for tolerance in [10.0, 1.0, 1e-1, 1e-3, 1e-6, 1e-10] {
        let tally = Engine::new().total(&receivers, &tree, tolerance, &mut answers)?;
        let counts = [
            tally.below,
            tally.behind,
            tally.weak,
            tally.together,
            tally.alone,
            tally.far_fields,
            tally.far_nodes,
            tally.looked_at,
        ];
        said.extend(counts.map(|count| count as f64));
        said.extend([answers.radiosity[0], answers.radiosity_error[0]]);
    }
    Ok(said)
}

/// Contradictions of case `index`.
///
/// # Errors
/// If a lamp is refused or an answer overflows.
pub fn wrong(index: u64) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(19, "lamps", index);
    let (receiver, lamps) = drawn(sampler)?;
    let alone = lamps.iter().map(|lamp| evaluate_to(&receiver, lamp, &[], 1e-10)).collect::<Result<Vec<_>, _>>()?;
    let mut findings = Vec::new();
    let mut hold = |what: &str, off: f64, room: f64| {
        if is_worse(off, room) {
            findings.push(format!("{what} is off by {off:e}, the bounds are {room:e}"));
        }
    };
    // By a tree.
    let (sum, sizes) = alone.iter().fold((0.0, 0.0), |(sum, sizes), a| (sum + a.radiosity, sizes + a.radiosity.abs()));
    let error: f64 = alone.iter().map(|a| a.radiosity_error).sum::<f64>() + 1e-15 * sizes;
    let (x, n) = (receiver.position().to_array().map(|c| [c]), receiver.direction().to_array().map(|c| [c]));
    let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[1.0])?;
    let tree = EmitterTree::new(&lamps);
    let mut answers = Answers::new();
    let largest = lamps.iter().map(Emitter::largest_emission).fold(0.0, f64::max);
    for tolerance in [4.0 * sizes, sizes * sampler.spread(-20, 1), largest, 3.0].into_iter().filter(|t| *t > 1e-300) {
        Engine::new().total(&receivers, &tree, tolerance, &mut answers)?;
        hold("a total", (answers.radiosity[0] - sum).abs(), answers.radiosity_error[0] + error);
        hold("a total's bound", answers.radiosity_error[0], tolerance * (1.0 + 1e-9) + error);
    }
    for tolerance in [1.0, 1e-9] {
        for (what, error, room) in beside_others(&receiver, &lamps, &alone, tolerance, &DOUBLE)? {
            hold(what, error, room);
        }
    }
    Ok(findings)
}

/// Each lamp on lanes beside the others, in one precision, against itself alone: the error of each figure, and the bounds on it.
fn beside_others<F: Precision>(
    receiver: &Receiver,
    lamps: &[Emitter],
    alone: &[Answer],
    tolerance: f64,
    cast: &Cast<F>,
) -> Result<Vec<(&'static str, f64, f64)>, Error> {
    let mut answers = Answers::<F>::default();
    Engine::new().each_to(receiver, &Emitters::<F>::new(lamps), tolerance, &mut answers)?;
    let mut told = vec![("a count of entries", entries(&answers.counts).abs_diff(lamps.len()) as f64, 0.0)];
    for (k, one) in alone.iter().enumerate() {
        let (value, slope, [of_value, of_slope]) = entry(&answers, cast, k);
        told.push(("one of many", (value - one.radiosity).abs(), of_value + one.radiosity_error));
        told.push(("the gradient of one of many", (slope - one.gradient).length(), of_slope + one.gradient_error));
    }
    Ok(told)
}

/// How many entries are answered: those whose lanes are done again in double precision are among the others.
pub(crate) const fn entries(counts: &Counts) -> usize {
    counts.zero + counts.whole + counts.clipped + counts.single
}

/// Lamps that face one way from several heights, or several ways from one place, and receivers among them: some lamps are behind, some below.
///
/// # Errors
/// If a lamp is refused or an answer overflows.
fn of_stack(index: u64) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(20, "stacks", index);
    // One that is narrow, flat and of many lamps has a far field.
    let (narrow, count) = if sampler.one_in(2) { (0.1, 40) } else { (1.0, 24) };
    let (way, depth) = (sampler.direction(), sampler.spread(-3, 1) * narrow);
    let (u, v) = way.any_orthonormal_pair();
    let turn = if sampler.one_in(2) { 0.0 } else { sampler.spread(-12, -1) };
    // Now and then far from the origin, where coordinates have few digits after the point.
    let origin = if sampler.one_in(2) { DVec3::ZERO } else { sampler.direction() * sampler.spread(0, 30) };
    let mut lamps = Vec::new();
    for _ in 0..count {
        let place = origin + way * (depth * sampler.uniform()) + (u * sampler.uniform() + v * (narrow * sampler.uniform())) * 0.5;
        let facing = way + sampler.cube() * turn;
        let (first, second) = facing.any_orthonormal_pair();
        let size = sampler.between(0.05, 0.1) * narrow;
        let corners = [place, place + first * size, place + second * size];
        lamps.push(Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(sampler.between(0.5, 2.0)))?);
    }
    let tree = EmitterTree::new(&lamps);
    let mut findings = Vec::new();
    for k in 0..6 {
        // Among them, or far off, before them or about level with them: then some face it, and others do not.
        let along = if k < 4 { depth * sampler.between(-0.5, 1.5) } else { sampler.spread(1, 6) };
        let place = origin
            + match k {
                5 => (u + way * (turn * sampler.between(-1.0, 1.0))) * along + way * (depth * 0.5),
                _ => way * along + u * sampler.between(-1.0, 3.0),
            };
        let toward = if k == 5 { -u } else { -way };
        let receiver = Receiver::new(place + v * 0.25, sampler.direction() + toward * 0.5, 1.0)?;
        findings.extend(contradictions(&receiver, &tree, &lamps, &[0.3, 1e-2, 1e-3, 1e-4, 1e-5, 1e-7, 1e-9])?);
    }
    Ok(findings)
}

/// Contradictions between the total by a tree and its lamps one by one.
fn contradictions(
    receiver: &Receiver,
    tree: &EmitterTree<'_>,
    lamps: &[Emitter],
    tolerances: &[f64],
) -> Result<Vec<String>, Error> {
    let alone = lamps.iter().map(|lamp| evaluate_to(receiver, lamp, &[], 1e-10)).collect::<Result<Vec<_>, _>>()?;
    let (sum, sizes) = alone.iter().fold((0.0, 0.0), |(sum, sizes), a| (sum + a.radiosity, sizes + a.radiosity.abs()));
    let room: f64 = alone.iter().map(|a| a.radiosity_error).sum::<f64>() + 1e-15 * sizes;
    let (x, n) = (receiver.position().to_array().map(|c| [c]), receiver.direction().to_array().map(|c| [c]));
    let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[1.0])?;
    let (mut findings, mut answers) = (Vec::new(), Answers::new());
    for tolerance in tolerances {
        Engine::new().total(&receivers, tree, *tolerance, &mut answers)?;
        let error = (answers.radiosity[0] - sum).abs();
        if is_worse(error, answers.radiosity_error[0] + room) {
            findings.push(format!("a total of {sum:e} is off by {error:e}, known to {:e}", answers.radiosity_error[0]));
        }
    }
    Ok(findings)
}

/// Lamps whose coordinates single precision holds, and a receiver whose coordinates it may not hold, beside or far from the origin.
///
/// # Errors
/// If a lamp is refused or an answer overflows.
fn of_singles(index: u64) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(22, "singles", index);
    let far = [0.0, 32.0, 1024.0][sampler.below(3) as usize];
    // Sums of few such numbers are exact.
    let grid = |v: DVec3| v.map(|c| libm::rint(c * 1024.0) / 1024.0);
    let origin = grid(sampler.cube() * far);
    let count = 1 + sampler.below(9);
    let mut lamps = Vec::new();
    for _ in 0..count {
        let place = origin + grid(sampler.cube() * 0.5 + DVec3::Z * 2.0);
        let sides = [sampler.cube(), sampler.cube()].map(grid);
        let corners = [place, place + sides[0], place + sides[0] + sides[1], place + sides[1]];
        let outline = if sampler.one_in(2) { &corners[..] } else { &corners[..3] };
        lamps.push(Emitter::new(Polygon::new(outline.to_vec())?, Emission::Constant(f64::from(1 + sampler.below(8))))?);
    }
    let held = sampler.one_in(2);
    let shift = sampler.cube() * 0.5;
    let receiver = Receiver::new(origin + if held { grid(shift) } else { shift }, DVec3::Z + sampler.cube(), 0.5)?;
    let alone = lamps.iter().map(|lamp| evaluate_to(&receiver, lamp, &[], 1e-10)).collect::<Result<Vec<_>, _>>()?;
    let mut findings = Vec::new();
    for tolerance in [1.0, 1e-4] {
        let told = beside_others(&receiver, &lamps, &alone, tolerance, &SINGLE)?.into_iter();
        let wrong = told.filter(|&(_, error, room)| is_worse(error, room));
        findings.extend(
            wrong.map(|(what, error, room)| format!("in single precision {what} is off by {error:e}, the bounds are {room:e}")),
        );
    }
    Ok(findings)
}

/// Lamps that rise from about a receiver on all sides, all but level with it: each gives what the angle between the two planes allows.
///
/// # Errors
/// If a lamp is refused or an answer overflows.
fn of_valley(index: u64) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(21, "valleys", index);
    let (up, rise, count) = (sampler.direction(), sampler.spread(-12, -1), 2 + sampler.below(3));
    let across = sampler.perpendicular(up);
    let mut lamps = Vec::new();
    for k in 0..count {
        let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * f64::from(k) / f64::from(count));
        let (out, along) = (across * cos + up.cross(across) * sin, up.cross(across) * cos - across * sin);
        // One of them may rise more, or not at all.
        let outward = out + up * (rise * sampler.between(0.0, 2.0));
        let [near, far] = [out * 0.1, outward * 40.0];
        let corners = [near - along * 0.1, far - along * 20.0, far + along * 20.0, near + along * 0.1];
        let polygon = Polygon::from_rounded(corners.to_vec(), 1e-13)?;
        lamps.push(Emitter::new(polygon, Emission::Constant(sampler.between(0.5, 2.0)))?);
    }
    let receiver = Receiver::new(DVec3::ZERO, up + sampler.cube() * (rise * sampler.between(0.0, 0.1)), 1.0)?;
    let largest = rise * rise;
    contradictions(&receiver, &EmitterTree::new(&lamps), &lamps, &[3.0, 64.0 * largest, 16.0 * largest, largest, 1e-2 * largest])
}

/// Lamps on a quarter of an arch, which face its middle: their tree has far fewer nodes than lamps.
fn of_arch() -> Result<Vec<String>, Error> {
    const COUNT: u32 = 300;
    let lamp = |k: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_2 * (f64::from(k) + 0.5) / f64::from(COUNT));
        let way = DVec3::new(cos, sin, 0.0);
        let (u, v) = way.any_orthonormal_pair();
        Emitter::new(Polygon::new(vec![-way, u * 1e-3 - way, v * 1e-3 - way])?, Emission::Constant(1.0))
    };
    let lamps = (0..COUNT).map(lamp).collect::<Result<Vec<_>, _>>()?;
    let one = Receivers::new([&[0.0]; 3], [&[-1.0], &[-1.0], &[0.0]], &[1.0])?;
    // To so small a tolerance each node is looked at.
    let tally = Engine::new().total(&one, &EmitterTree::new(&lamps), 1e-30, &mut Answers::new())?;
    let is_deep = tally.alone != u64::from(COUNT) || 2 * tally.looked_at > u64::from(COUNT);
    Ok(if is_deep { vec![format!("{COUNT} lamps on an arch: {tally:?}")] } else { Vec::new() })
}

/// Contradictions in the first cases.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let ask = |index: u64| {
        let others = index.is_multiple_of(6).then(|| [of_stack(index), of_valley(index), of_singles(index)]);
        let told = std::iter::once(wrong(index)).chain(others.into_iter().flatten());
        let findings = told.flat_map(|told| told.unwrap_or_else(|error| vec![error.to_string()]));
        findings.collect::<Vec<_>>().into_iter().map(move |what| format!("lamps:{index}: {what}"))
    };
    let arch = of_arch().unwrap_or_else(|error| vec![error.to_string()]);
    (0..count).into_par_iter().flat_map_iter(ask).chain(arch).collect()
}
