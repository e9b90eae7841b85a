//! Derivatives that are found on lanes, against those of the other rungs, which share no formula with them: triangles and quadrangles of constant
//! emission and of vertex values. Within the two bounds they are the same, and well away from edges lanes have ten digits.

use glam::DVec3;
use radgrad_core::{Derivative, Derivatives, Emission, Emitter, Error, Polygon, Receiver, derivatives};
use radgrad_scene::largest;

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

/// The share of the largest derivative of its kind that a bound is below.
const DIGITS: f64 = 1e-10;

fn drawn(sampler: &mut Sampler) -> Result<(Receiver, Emitter), Error> {
    let whole = |sampler: &mut Sampler| DVec3::from([(); 3].map(|()| sampler.integer(-4, 4) as f64));
    let (start, u, v) = (whole(sampler), whole(sampler) + DVec3::X * 9.0, whole(sampler) + DVec3::Y * 9.0);
    let corners = [[0.0, 0.0], [1.0, 0.125], [0.75, 1.25], [-0.125, 0.875]];
    let count = 3 + sampler.below(2) as usize;
    let corners: Vec<DVec3> = corners[..count].iter().map(|[s, t]| start + u * *s + v * *t).collect();
    let normal = u.cross(v).normalize();
    let x = start + (u + v) * sampler.between(-0.5, 1.0) + normal * sampler.between(4.0, 20.0);
    let facing = start + (u + v) * 0.4 - x + sampler.cube() * 2.0;
    let emission = if sampler.one_in(4) {
        Emission::Constant(sampler.between(0.5, 2.0))
    } else {
        let slope = whole(sampler);
        Emission::at_vertices(corners.iter().map(|corner| 50.0 + slope.dot(*corner)).collect())
    };
    Ok((Receiver::new(x, facing, 0.5)?, Emitter::new(Polygon::new(corners)?, emission)?))
}

/// All derivatives, by kind.
fn kinds(answer: &Derivatives) -> [Vec<Derivative<DVec3>>; 5] {
    let number = |derivative: &Derivative<f64>| Derivative { value: DVec3::X * derivative.value, error: derivative.error };
    [
        vec![number(&answer.radiosity)],
        vec![answer.gradient],
        answer.vertices.clone(),
        answer.emission.iter().map(number).collect(),
        vec![answer.normal],
    ]
}

fn wrong(index: u64) -> Result<Vec<String>, Error> {
    let (receiver, emitter) = drawn(&mut Sampler::new(65, "lane derivatives", index))?;
    let none: [&Polygon; 0] = [];
    let [on_lanes, one_by_one] = [1.0, 1e-15].map(|tolerance| derivatives(&receiver, &emitter, none, tolerance));
    let mut findings = Vec::new();
    for (kind, (of_lanes, others)) in kinds(&on_lanes?).into_iter().zip(kinds(&one_by_one?)).enumerate() {
        let size = others.iter().map(|other| other.value.length()).fold(0.0, largest);
        for (k, (one, other)) in of_lanes.iter().zip(&others).enumerate() {
            let (off, room) = ((one.value - other.value).length(), one.error + other.error);
            if is_worse(off, room * (1.0 + 1e-12) + f64::EPSILON * 1e-3 * size) {
                findings.push(format!("derivative {k} of kind {kind}: off by {off:e}, known to {room:e}: {one:?} and {other:?}"));
            }
            if is_worse(one.error, DIGITS * size) {
                findings.push(format!("derivative {k} of kind {kind} is known to {:e} of {size:e}", one.error));
            }
        }
    }
    Ok(findings)
}

/// Contradictions of so many draws.
pub(super) fn all_wrong(count: u64) -> Vec<String> {
    let told = |index: u64| {
        let findings = wrong(index).unwrap_or_else(|error| vec![error.to_string()]);
        findings.into_iter().map(move |what| format!("lane derivatives:65:{index}: {what}"))
    };
    (0..count).flat_map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_wrong() {
        assert_eq!(all_wrong(60), Vec::<String>::new());
    }
}
