//! Emitters and occluders whose vertices are not in one plane, against their own triangles.
//!
//! Four such vertices are named as the polygon that they were before they were rounded. Its answer holds for every surface within
//! their hull, so for both pairs of triangles, each of which is flat and answered by itself. Rounding is coarse here, up to a
//! hundredth of the size, so that what a choice of surfaces decides is no rounding.

use glam::DVec3;
use radgrad_core::{Answer, Emission, Emitter, Error, Method, Polygon, Polynomial, Receiver, evaluate_to};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

/// Four vertices, and how far each coordinate is off.
struct Bent {
    vertices: [DVec3; 4],
    precision: f64,
}

impl Bent {
    fn polygon(&self) -> Option<Polygon> {
        Polygon::from_rounded(self.vertices.to_vec(), self.precision).ok()
    }

    /// Both ways to cut it into triangles.
    fn cuts(&self) -> Option<[[Polygon; 2]; 2]> {
        let [a, b, c, d] = self.vertices;
        let pair =
            |one: [DVec3; 3], other: [DVec3; 3]| Some([Polygon::new(one.to_vec()).ok()?, Polygon::new(other.to_vec()).ok()?]);
        Some([pair([a, b, c], [a, c, d])?, pair([a, b, d], [b, c, d])?])
    }

    /// A square about the origin across z, of a side about 1.
    fn square(sampler: &mut Sampler) -> [DVec3; 4] {
        let [u, v] = [sampler.between(0.4, 1.0), sampler.between(0.4, 1.0)];
        [[-u, -v], [u, -v], [u, v], [-u, v]].map(|[x, y]| DVec3::new(x, y, 0.0))
    }

    fn rounded(sampler: &mut Sampler, vertices: [DVec3; 4], precision: f64) -> Self {
        Self { vertices: vertices.map(|v| v + sampler.cube() * precision), precision }
    }
}

/// A receiver over a bent emitter, and a bent occluder anywhere about it.
fn drawn(sampler: &mut Sampler) -> Option<(Receiver, Bent, Bent)> {
    let precision = [1e-9, 1e-6, 1e-4, 1e-3][sampler.below(4) as usize];
    let square = Bent::square(sampler);
    let emitter =
        if sampler.one_in(3) { Bent { vertices: square, precision: 0.0 } } else { Bent::rounded(sampler, square, precision) };
    let x = sampler.cube() * DVec3::new(1.5, 1.5, 0.0) + DVec3::Z * sampler.between(0.3, 2.0);
    let receiver = Receiver::new(x, sampler.cube() * 0.4 - DVec3::Z, 1.0).ok()?;
    // Anywhere between; with a corner about in the emitter's plane; through it; on an edge of the emitter; about edge-on.
    let size = sampler.between(0.2, 0.6);
    let plain = Bent::square(sampler).map(|v| v * size);
    let [a, b] = [emitter.vertices[0], emitter.vertices[1]];
    let between = x * sampler.between(0.2, 0.8) + sampler.cube() * 0.3;
    let (lean, foot) = (sampler.cube().try_normalize()?, sampler.cube() * DVec3::new(0.5, 0.5, 0.0));
    let toward = (x - foot).try_normalize()?;
    let [first, second] = [lean.any_orthonormal_vector(), lean.cross(lean.any_orthonormal_vector())];
    let placed = |at: DVec3, [u, v]: [DVec3; 2]| plain.map(|p| at + u * p.x + v * p.y);
    let vertices = match sampler.below(5) {
        0 => placed(between, [first, second]),
        1 => {
            let whole = placed(DVec3::ZERO, [first, second]);
            let lowest = whole.iter().fold(0.0f64, |low, v| low.min(v.z));
            whole.map(|v| v + foot - DVec3::Z * (lowest + precision * 0.5))
        }
        2 => placed(foot, [first, second]),
        3 => {
            let up = DVec3::new(sampler.between(-0.5, 0.5), sampler.between(-0.5, 0.5), sampler.between(0.1, 0.5));
            [a, b, b + up, a + up]
        }
        _ => placed(foot + toward * sampler.between(0.1, 0.4), [toward, toward.cross(lean).try_normalize()?]),
    };
    let mut occluder = Bent::rounded(sampler, vertices, precision);
    if vertices[..2] == [a, b] {
        // What is shared is exactly so.
        occluder.vertices[0] = a;
        occluder.vertices[1] = b;
    }
    Some((receiver, emitter, occluder))
}

/// Contradictions of case `index`; none where a polygon is refused.
#[must_use]
pub fn wrong(index: u64) -> Option<Vec<String>> {
    let (receiver, emitter, occluder) = drawn(&mut Sampler::new(18, "hulls", index))?;
    let lamp = |polygon: &Polygon| Emitter::new(polygon.clone(), Emission::Constant(1.0)).ok();
    let (whole, screen) = (lamp(&emitter.polygon()?)?, [occluder.polygon()?]);
    let (lit, hiding) = (emitter.cuts()?, occluder.cuts()?);
    let mut findings = Vec::new();
    for tolerance in [1.0, 1e-9] {
        let answer = match evaluate_to(&receiver, &whole, &screen, tolerance) {
            Ok(answer) => answer,
            Err(error) => return Some(vec![error.to_string()]),
        };
        for (triangles, screens) in lit.iter().flat_map(|triangles| hiding.iter().map(move |screens| (triangles, screens))) {
            let parts = triangles.iter().map(|t| evaluate_to(&receiver, &lamp(t)?, screens, 1e-9).ok());
            let parts: Vec<_> = parts.collect::<Option<_>>()?;
            let sum = |of: fn(&Answer) -> f64| parts.iter().map(of).sum::<f64>();
            let (value, slope) = (sum(|p| p.radiosity), parts.iter().map(|p| p.gradient).sum::<DVec3>());
            let apart = [(answer.radiosity - value).abs(), (answer.gradient - slope).length()];
            let room = [
                answer.radiosity_error + sum(|p| p.radiosity_error) + 1e-15 * value,
                answer.gradient_error + sum(|p| p.gradient_error) + 1e-14 * slope.length(),
            ];
            for (what, (apart, room)) in ["radiosity", "gradient"].into_iter().zip(apart.into_iter().zip(room)) {
                if is_worse(apart, room) {
                    let than = "from that of triangles, the bounds are";
                    findings.push(format!("{what} to {tolerance:e} is {apart:e} {than} {room:e}"));
                }
            }
        }
    }
    Some(findings)
}

/// A case in which the receiver is within the hull of an occluder's vertices.
const SURROUNDED: u64 = 767;

/// By a rule a polynomial on a bent lamp is known no better than the bend allows.
fn bent_polynomial() -> Result<Vec<String>, Error> {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 8.0 + 1e-6 * x * y));
    let polygon = Polygon::from_rounded(corners.to_vec(), 1e-6)?;
    let defect = polygon.planarity_defect();
    let polynomial = Polynomial::new(DVec3::Z * 8.0, [(1.0, [6, 0, 0]), (0.125, [0, 0, 0])])?;
    let emitter = Emitter::new(polygon, Emission::Polynomial(polynomial))?;
    let answer = evaluate_to(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &emitter, &[], 1.0)?;
    // The slope is up to 6 on an emission of up to 1.125: the bend moves the light by ten times this.
    let least = defect * answer.radiosity;
    Ok((is_worse(least, answer.radiosity_error) || answer.method != Method::Quadrature)
        .then(|| format!("a bent polynomial lamp is known to {:e}: {answer:?}", answer.radiosity_error))
        .into_iter()
        .collect())
}

/// Contradictions in the first cases.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let indices: Vec<u64> = (0..count).chain([SURROUNDED]).collect();
    let told: Vec<_> = indices.into_par_iter().map(|index| (index, wrong(index))).collect();
    let few = (2 * told.iter().filter(|(_, told)| told.is_some()).count() < told.len())
        .then(|| "more than half of the polygons are refused".to_owned());
    let named =
        |(index, told): (u64, Option<Vec<String>>)| told.into_iter().flatten().map(move |what| format!("hulls:{index}: {what}"));
    let bent = bent_polynomial().unwrap_or_else(|error| vec![error.to_string()]);
    told.into_iter().flat_map(named).chain(few).chain(bent).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_occluder_that_may_surround_the_receiver_hides_what_it_may() {
        // There the receiver is within the hull of the occluder's vertices.
        assert_eq!(wrong(SURROUNDED), Some(Vec::new()));
    }

    #[test]
    fn both_cuts_have_the_area_of_the_square() {
        let vertices = Bent::square(&mut Sampler::new(1, "hulls", 0));
        let cuts = Bent { vertices, precision: 0.0 }.cuts().unwrap();
        let areas = cuts.map(|[one, other]| one.area() + other.area());
        assert!((areas[0] - areas[1]).abs() < 1e-12 && areas[0] > 0.6, "{areas:?}");
    }
}
