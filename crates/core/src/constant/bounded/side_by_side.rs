//! The sums and bounds of [`super`] for a polygon that is seen whole, four edges at a time, one a lane of a vector: the sums are
//! those of [`crate::constant::side_by_side`], and the bounds the same but for the order of their sums.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};

use super::{AngleError, BoundedSum, length};
use crate::constant::side_by_side::weigh;
use crate::four::{Four, Whole, all, plus_first, power_seen_whole};
use crate::level::{LEVEL, on_level};
use crate::number::ROUNDOFF;
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Polygon, Receiver};

/// The sums and their bounds, where all is plain, of a polygon that is seen whole; `power` normalises lengths.
#[inline]
pub(super) fn bounded(receiver: &Receiver, polygon: &Polygon, power: f64) -> Option<(Terms<f64>, BoundedSum)> {
    on_level!(*LEVEL, simd => sums(simd, receiver, polygon, power))
}

/// As [`BoundedSum::whole`].
#[inline]
pub(super) fn bounded_whole(receiver: &Receiver, polygon: &Polygon, narrow: f64) -> Option<Whole<BoundedSum>> {
    on_level!(*LEVEL, simd => {
        let power = power_seen_whole(simd, receiver, polygon)?;
        let is_near = polygon.size() * power > narrow;
        Some(Whole { power, sums: if is_near { sums(simd, receiver, polygon, power) } else { None } })
    })
}

#[inline(always)]
fn sums<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> Option<(Terms<f64>, BoundedSum)> {
    let fours = polygon.four_edges();
    let splat = |value: f64| f64x4::splat(simd, value);
    let (x, n1, power) = (all(simd, receiver.position()), all(simd, receiver.normal()), splat(power));
    let (mut angles, mut edges, mut along, mut others) = (Vec3::default(), Vec3::default(), Vec3::default(), Vec3::default());
    let mut rest = polygon.vertices().len();
    let additions = (rest - 1) as f64 * ROUNDOFF;
    for four in fours {
        let found = Four::new(simd, four, x, power)?;
        // Next to underflow nothing is bounded.
        if !found.across.simd_ge(splat(1e-100)).all_true() {
            return None;
        }
        let count = rest.min(4);
        rest -= count;
        let (weight, weighed) = weigh(&found, simd, n1, fours.len() == 1)?;
        angles = plus_first(angles, found.normal * found.angle, count);
        edges = plus_first(edges, found.normal * -weight, count);
        // As `Line::relative_error`: plain edges pass at a quarter of the distance at least.
        let ratio = (found.start_square * found.edge_square).sqrt() / found.across;
        let (g, ew) = (found.angle, (ratio * 3.5 + 1.0) * ROUNDOFF);
        let of_angle = AngleError::new(g, g.min(splat(1.0)), ew, 0.0, 0.0);
        let (size, error) = of_angle.of_weight(&weighed);
        along = plus_first(along, found.normal.map(|c| c.abs()) * error, count);
        let of_term = of_angle.of_term(n1.dot(found.normal).abs()) + g * additions;
        others = plus_first(others, Vec3::new(of_term, size * (ew + additions), splat(0.0)), count);
    }
    let terms = Terms { irradiance: angles * -0.5, gradient: edges };
    let bound = BoundedSum::new(&terms, others.x, length(along) + others.y);
    Some((terms, bound))
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::four::random::polygon_and_receiver;
    use crate::plan::{Horizon, Plan};

    #[test]
    fn bounds_side_by_side_are_those_of_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut found = 0;
        for i in 0..2000 {
            let count = 3 + i % 7;
            let Some((polygon, receiver, _)) = polygon_and_receiver(&mut random, count, 3.0) else { continue };
            let Some(plan) = Plan::new(&receiver, &polygon).filter(|plan| plan.horizon == Horizon::Above) else { continue };
            let Some((terms, bound)) = bounded(&receiver, &polygon, plan.power) else { continue };
            found += 1;
            let Whole { power, sums } = bounded_whole(&receiver, &polygon, 0.0).unwrap();
            let (whole, same_bound) = sums.unwrap();
            let of_bound = |bound: &BoundedSum| [bound.irradiance, bound.gradient];
            assert_eq!((power, whole.irradiance, whole.gradient), (plan.power, terms.irradiance, terms.gradient));
            assert_eq!(of_bound(&same_bound), of_bound(&bound));
            let (one_by_one, expected) = BoundedSum::one_by_one(&receiver, &polygon, &plan);
            assert_eq!((terms.irradiance, terms.gradient), (one_by_one.irradiance, one_by_one.gradient));
            for (bound, expected) in [(bound.irradiance, expected.irradiance), (bound.gradient, expected.gradient)] {
                assert!((bound / expected - 1.0).abs() < 1e-13, "{bound:e} {expected:e}");
            }
        }
        assert!(found > 500, "{found}");
    }
}
