//! Long batches, of more receivers than a tile has, beside their parts; and ceilings of many lamps, beside the one rectangle that they make.

use glam::DVec3;
use radgrad_core::batch::{Answers, EmitterTree, Emitters, Engine, Precision, ReadyEmitter, Receivers};
use radgrad_core::{Emission, Emitter, Error, Polygon, Receiver, evaluate_to};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::checks::batches::{Cast, DOUBLE, SINGLE, asked, case, entry, receivers};
use crate::measures::measure::is_worse;

/// More than eight tiles, and no multiple of one or of a vector.
const LENGTH: usize = 1077;

/// Lengths of parts: a tile, almost one, more than half of one, and one entry.
const PARTS: [usize; 4] = [128, 127, 67, 1];

/// Differences of batch `index` in one precision from its parts.
fn of_precision<F: Precision>(index: u64, cast: &Cast<F>, name: &str) -> Result<Vec<String>, Error> {
    // Families whose entries lanes answer.
    let Ok(problem) = case(55, [0, 2, 4, 9, 13][usize::try_from(index % 5).unwrap_or(0)]).problem() else {
        return Ok(Vec::new());
    };
    let s = &mut Sampler::new(55, "long", index);
    let round = |v: DVec3| v.map(|c| (cast.from)((cast.to)(c)));
    let drawn = receivers(s, &problem, 2 * LENGTH).into_iter().map(|place| place.map(round));
    let places: Vec<_> = drawn.filter(|[at, facing]| Receiver::new(*at, *facing, 1.0).is_ok()).take(LENGTH).collect();
    let ready = ReadyEmitter::<F>::new(problem.emitter.clone());
    let mut findings = Vec::new();
    // Value and gradient, without bounds and with them, and with occluders.
    for way in [0, 1, 3, 7] {
        let asking = |engine, of: &[[DVec3; 2]]| asked(engine, (&problem, &ready), of, cast, way);
        let Ok(whole) = asking(Engine::new(), &places) else { continue };
        let same = |k: usize, answers: &Answers<F>, at: usize| {
            format!("{:?}", entry(&whole, cast, k)) == format!("{:?}", entry(answers, cast, at))
        };
        if asking(Engine::new().threads(), &places).as_ref() != Ok(&whole) {
            findings.push(format!("long {index} of {name}, way {way}: other digits on threads"));
        }
        let (mut start, mut part) = (0, 0);
        // Reflectances go by the place, three of them.
        while start < places.len() {
            let length = PARTS[part % 4].min(places.len() - start);
            let padded = start % 3;
            let answers = asking(Engine::new(), &places[start - padded..start + length])?;
            if let Some(k) = (0..length).find(|k| !same(start + k, &answers, padded + k)) {
                findings.push(format!("long {index} of {name}, way {way}: entry {} is another one in a part", start + k));
            }
            (start, part) = (start + length, part + 1);
        }
        let counts = whole.counts;
        if counts.zero + counts.whole + counts.clipped + counts.single != places.len() {
            findings.push(format!("long {index} of {name}, way {way}: {counts:?} of {}", places.len()));
        }
    }
    Ok(findings)
}

/// A ceiling of so many lamps a side, as one tree, beside one rectangle: squares that shine evenly, or triangles by one linear function.
fn of_ceiling(side: u32, index: u64) -> Result<Vec<String>, Error> {
    let s = &mut Sampler::new(56, "ceilings", index);
    let slope = if index == 0 { DVec3::ZERO } else { DVec3::new(0.75, -0.5, 0.0) };
    let cell = |x: f64, y: f64, size: f64| {
        [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[u, v]| DVec3::new(x + u * size, y + v * size, 1.0))
    };
    let size = 1.0 / f64::from(side.next_power_of_two());
    let mut lamps = Vec::new();
    for k in 0..side * side {
        let corners = cell(f64::from(k % side) * size, f64::from(k / side) * size, size);
        if slope == DVec3::ZERO {
            lamps.push(Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?);
            continue;
        }
        for half in [[0, 1, 2], [2, 3, 0]] {
            let outline = half.map(|corner| corners[corner]).to_vec();
            let values = outline.iter().map(|corner| 1.0 + slope.dot(*corner)).collect();
            lamps.push(Emitter::new(Polygon::new(outline)?, Emission::at_vertices(values))?);
        }
    }
    let whole = Polygon::new(cell(0.0, 0.0, f64::from(side) * size).to_vec())?;
    let whole = Emitter::new(whole, if slope == DVec3::ZERO { Emission::Constant(1.0) } else { Emission::gradient(1.0, slope) })?;
    let tree = EmitterTree::new(&lamps);
    let mut findings = Vec::new();
    let mut answers = Answers::new();
    for far in [0.02, 0.4, 3.0, 300.0] {
        let x = DVec3::new(0.3, 0.4, 1.0 - far) + s.cube() * DVec3::new(far.min(1.0), far.min(1.0), 0.01 * far);
        let receiver = Receiver::new(x, DVec3::Z + s.cube() * 0.4, 1.0)?;
        let truth = evaluate_to(&receiver, &whole, &[], 1e-12)?;
        let (at, n) = (x.to_array().map(|c| [c]), receiver.direction().to_array().map(|c| [c]));
        let one = Receivers::new([&at[0], &at[1], &at[2]], [&n[0], &n[1], &n[2]], &[1.0])?;
        for share in [1e-2, 1e-5, 1e-9] {
            let tolerance = share * truth.radiosity;
            let tally = Engine::new().total(&one, &tree, tolerance, &mut answers)?;
            let gap = (answers.radiosity[0] - truth.radiosity).abs();
            let error = answers.radiosity_error[0];
            if is_worse(gap, error + truth.radiosity_error) || is_worse(error, tolerance + 1e-13 * f64::from(side)) {
                findings.push(format!("ceiling {side}, {far} below, to {tolerance:e}: off by {gap:e}, known to {error:e}"));
            }
            let counted = tally.below + tally.behind + tally.weak + tally.together + tally.alone;
            if counted != lamps.len() as u64 {
                findings.push(format!("ceiling {side}, {far} below: {tally:?} of {} lamps", lamps.len()));
            }
            // From far away the whole ceiling is one far field, of a dozen nodes a side at most.
            let is_one = tally.looked_at == 1 && tally.far_fields == 1 && tally.far_nodes <= 144;
            if far > 100.0 && share > 1e-6 && !is_one {
                findings.push(format!("ceiling {side}, {far} below, to {tolerance:e}: {tally:?}"));
            }
        }
    }
    Ok(findings)
}

/// Many emitters of one kind, each beside its own answer: more than a tile has, some so near to the receiver that lanes leave them.
fn of_many(index: u64) -> Result<Vec<String>, Error> {
    let s = &mut Sampler::new(57, "many", index);
    let receiver = Receiver::new(DVec3::ZERO, s.direction(), 1.0)?;
    let lamp = |s: &mut Sampler| {
        let place = s.direction() * s.spread(-20, 2);
        let (u, v) = (s.cube() - place.normalize()).any_orthonormal_pair();
        let emission =
            if index == 0 { Emission::Constant(s.between(0.5, 2.0)) } else { Emission::at_vertices(vec![1.0, 2.0, 0.5]) };
        Emitter::new(Polygon::new(vec![place, place + u, place + v])?, emission)
    };
    let lamps = (0..300).map(|_| lamp(s)).collect::<Result<Vec<_>, _>>()?;
    let (mut answers, mut findings) = (Answers::new(), Vec::new());
    for tolerance in [1.0, 1e-12] {
        Engine::new().each_to(&receiver, &Emitters::<f64>::new(&lamps), tolerance, &mut answers)?;
        for (k, lamp) in lamps.iter().enumerate() {
            let alone = evaluate_to(&receiver, lamp, &[], 1e-12)?;
            let (error, room) =
                ((answers.radiosity[k] - alone.radiosity).abs(), answers.radiosity_error[k] + alone.radiosity_error);
            if is_worse(error, room) {
                findings.push(format!("many {index}: emitter {k} is off by {error:e}, the bounds are {room:e}"));
            }
        }
    }
    Ok(findings)
}

/// Contradictions of so many batches, of three ceilings and of many emitters.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let said = |told: Result<Vec<String>, Error>| told.unwrap_or_else(|error| vec![format!("long: {error}")]);
    let of = |index: u64| match index {
        0 => said(of_ceiling(65, 0)),
        1 => [said(of_ceiling(20, 0)), said(of_ceiling(20, 1)), said(of_many(0)), said(of_many(1))].concat(),
        _ => [said(of_precision(index, &DOUBLE, "doubles")), said(of_precision(index, &SINGLE, "singles"))].concat(),
    };
    (0..count + 2).into_par_iter().flat_map_iter(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_batches_are_their_parts_and_many_lamps_one() {
        assert_eq!(all_wrong(5), Vec::<String>::new());
    }
}
