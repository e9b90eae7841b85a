//! The sums of a constant emitter that is seen whole, four edges at a time, one a lane of a vector: the digits of the sums of
//! [`super`], where all is plain ([`crate::four`]) and, for the gradient, no edge is seen past a quarter turn.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};

use super::bounded::Weighed;
use crate::four::{Four, Weights, all, plus_first, power_seen_whole};
use crate::level::{LEVEL, on_level};
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Polygon, Receiver};

/// The sums for a unit emission and the power of two that normalised lengths, where all is plain.
#[inline]
pub(crate) fn whole<const VALUE: bool, const GRADIENT: bool>(
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(f64, Terms<f64>)> {
    on_level!(*LEVEL, simd => sums::<_, VALUE, GRADIENT>(simd, receiver, polygon))
}

#[inline(always)]
fn sums<S: Simd, const VALUE: bool, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(f64, Terms<f64>)> {
    let power = power_seen_whole(simd, receiver, polygon)?;
    let (x, n1) = (all(simd, receiver.position()), all(simd, receiver.normal()));
    let (mut angles, mut edges) = (Vec3::default(), Vec3::default());
    let mut rest = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let found = Four::new(simd, four, x, f64x4::splat(simd, power))?;
        let count = rest.min(4);
        rest -= count;
        if VALUE {
            angles = plus_first(angles, found.normal * found.angle, count);
        }
        if GRADIENT {
            edges = plus_first(edges, found.normal * -weigh(&found, simd, n1, fours.len() == 1)?.0, count);
        }
    }
    Some((power, Terms { irradiance: angles * -0.5, gradient: edges }))
}

/// As [`crate::arc::Arc::weight`], with what its bound follows from. Where all edges are here each one ends where the next one
/// starts.
#[inline(always)]
pub(super) fn weigh<S: Simd>(four: &Four<S>, simd: S, n1: Vec3<f64x4<S>>, closed: bool) -> Option<(f64x4<S>, Weighed<f64x4<S>>)> {
    let Four { start, end, start_square, inline, angle, .. } = *four;
    if !inline.simd_ge(f64x4::splat(simd, 0.0)).all_true() {
        return None;
    }
    let one = f64x4::splat(simd, 1.0);
    let q1 = one / start_square.sqrt();
    let c1 = n1.dot(start) * q1;
    let (q2, c2) = if closed {
        (q1.rotate_elements_left::<1>(), c1.rotate_elements_left::<1>())
    } else {
        let q2 = one / end.norm_squared().sqrt();
        (q2, n1.dot(end) * q2)
    };
    let weights = Weights::new(simd, four, [q1, q2]);
    let cosines = c1.abs() + c2.abs();
    let (sum, turn) = (weights.sum, one / weights.one_and_cos);
    let weighed = Weighed { near: q1 + q2, sum, turn, cosines, least: angle.min(cosines) };
    Some((weights.of([q1, q2], [c1, c2]), weighed))
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::constant::{EdgeSum, SolidAngleVector};
    use crate::four::random::polygon_and_receiver;
    use crate::horizon;
    use crate::level::levels;
    use crate::plan::{Horizon, Plan};

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let (mut found, mut wide) = (0, 0);
        for i in 0..4000 {
            let count = 3 + i % 7;
            let Some((polygon, receiver, _)) = polygon_and_receiver(&mut random, count, 4.0) else { continue };
            let (mut first, mut angles) = (None, SolidAngleVector::zero());
            for level in levels() {
                let found = on_level!(level, simd => sums::<_, true, true>(simd, &receiver, &polygon));
                let digits = found.map(|(power, terms)| (power, terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let value = whole::<true, false>(&receiver, &polygon);
            wide += usize::from(first.flatten().is_none() && value.is_some());
            let Some((power, irradiance, gradient)) = first.flatten() else { continue };
            found += 1;
            let plan = Plan::new(&receiver, &polygon).unwrap();
            let mut edges = EdgeSum::new(receiver.normal().into());
            horizon::visit_boundary::<f64>(&receiver, &polygon, &plan, |arc| {
                angles.add(arc);
                edges.add(arc);
            });
            assert_eq!((plan.power, plan.horizon), (power, Horizon::Above));
            assert_eq!((angles.phi(), edges.sum()), (irradiance, gradient), "{receiver:?} {polygon:?}");
            assert_eq!(value.unwrap().1.irradiance, irradiance);
            assert_eq!(whole::<false, true>(&receiver, &polygon).unwrap().1.gradient, gradient);
        }
        println!("{found} found, {wide} for their value alone");
        assert!(found > 1000 && wide > 20, "{found} {wide}");
    }
}
