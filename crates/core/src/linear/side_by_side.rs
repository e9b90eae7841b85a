//! The sums of a linear emitter that is seen whole, four edges at a time, one a lane of a vector: the digits of the sums of
//! [`super`], where all is plain ([`crate::four`]).

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8, mask64x8};

use super::{LinearSum, Seen};
use crate::arc::DOUBLE_SERIES;
use crate::four::{Four, all, height_over_plane, logarithm, pair, plus_first, power_seen_whole, x1_clausens};
use crate::level::{LEVEL, on_level};
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Emitter, Receiver};

/// The sums and the power of two that normalised lengths, where all is plain.
#[inline]
pub(crate) fn whole<const GRADIENT: bool>(receiver: &Receiver, emitter: &Emitter) -> Option<(f64, Terms<f64>)> {
    on_level!(*LEVEL, simd => sums::<_, GRADIENT>(simd, receiver, emitter))
}

#[inline(always)]
fn sums<S: Simd, const GRADIENT: bool>(simd: S, receiver: &Receiver, emitter: &Emitter) -> Option<(f64, Terms<f64>)> {
    let polygon = emitter.polygon();
    let power = power_seen_whole(simd, receiver, polygon)?;
    let mut sum = LinearSum::new(Seen::from(receiver, emitter, power, height_over_plane(simd, receiver, polygon, power)));
    let x = all(simd, receiver.position());
    let mut rest = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let four = Four::new(simd, four, x, f64x4::splat(simd, power))?;
        sum.add_four::<S, GRADIENT>(simd, &four, (rest.min(4), fours.len() == 1))?;
        rest -= rest.min(4);
    }
    Some((power, sum.total()))
}

/// The affine emission and the receiver, the same in all lanes.
struct Same<S: Simd> {
    n1: Vec3<f64x4<S>>,
    n2: Vec3<f64x4<S>>,
    height: f64x4<S>,
    beta: f64x4<S>,
    gradient: Vec3<f64x4<S>>,
}

impl<S: Simd> Same<S> {
    #[inline(always)]
    fn new(simd: S, Seen { n1, n2, height, beta, gradient }: Seen<f64>) -> Self {
        Self {
            n1: all(simd, n1.into()),
            n2: all(simd, n2.into()),
            height: f64x4::splat(simd, height),
            beta: f64x4::splat(simd, beta),
            gradient: all(simd, gradient.into()),
        }
    }
}

/// [`crate::line::Frame`] on lanes.
struct Frame<S: Simd> {
    toward: Vec3<f64x4<S>>,
    along: Vec3<f64x4<S>>,
    distance: f64x4<S>,
}

impl LinearSum<f64> {
    /// As [`LinearSum::add`] for the first `count` lanes.
    #[inline(always)]
    fn add_four<S: Simd, const GRADIENT: bool>(&mut self, simd: S, arcs: &Four<S>, (count, closed): (usize, bool)) -> Option<()> {
        let seen = Same::new(simd, self.seen);
        let length = arcs.edge_square.sqrt();
        let along = arcs.e * (f64x4::splat(simd, 1.0) / length);
        let frame = Frame { toward: along.cross(arcs.normal), along, distance: arcs.across / length };
        // Where all edges are here each one ends where the next one starts.
        let end_square = if closed { arcs.start_square.rotate_elements_left::<1>() } else { arcs.end.norm_squared() };
        let kappa = seen.n2.dot(arcs.normal);
        let signed = frame.distance * kappa;
        let reach = frame.distance + signed.abs();
        let ratios = simd.combine_f64x4(end_square, reach) / simd.combine_f64x4(arcs.start_square, seen.height);
        let (log_ratio, log_reach) = simd.split_f64x8(logarithm(simd, ratios));
        let log_ratio = log_ratio * f64x4::splat(simd, 0.5);
        let outward = frame.along.cross(seen.n2);
        let flux = kappa * arcs.angle * seen.gradient.dot(outward) + log_ratio * seen.gradient.dot(frame.along);
        let (x1, plain) = x1_terms(simd, arcs, &frame, [signed, reach, log_reach], self.seen.height);
        if !plain.all_true() {
            return None;
        }
        self.angles = plus_first(self.angles, arcs.normal * arcs.angle, count);
        self.contour = plus_first(self.contour, outward * flux, count);
        for term in &x1.as_array()[..count] {
            self.x1 += term;
        }
        if GRADIENT {
            let seen = edge_terms(simd, arcs, &frame, &seen, (end_square, closed));
            self.edges = plus_first(self.edges, arcs.normal * -(seen / frame.distance), count);
        }
        Some(())
    }
}

/// As [`super::x1_term`], with both ends of the four segments side by side.
#[inline(always)]
fn x1_terms<S: Simd>(
    simd: S,
    arcs: &Four<S>,
    frame: &Frame<S>,
    [signed, reach, log_reach]: [f64x4<S>; 3],
    height: f64,
) -> (f64x4<S>, mask64x8<S>) {
    let d = signed.abs();
    let (d_twice, reach_twice) = (simd.combine_f64x4(d, d), simd.combine_f64x4(reach, reach));
    let across = frame.distance * d;
    let s = simd.combine_f64x4(arcs.start.dot(frame.along), arcs.end.dot(frame.along));
    let height = f64x8::splat(simd, height);
    let turned = [s * height * height / reach_twice, simd.combine_f64x4(across, across) + s * s];
    let (clausens, plain) = x1_clausens(simd, [s, d_twice], turned);
    let (starts, ends) = simd.split_f64x8(clausens);
    let term = arcs.angle * log_reach - (ends - starts) * f64x4::splat(simd, 0.25);
    let zero = f64x4::splat(simd, 0.0);
    let term = signed.simd_lt(zero).select(-term, term);
    (signed.simd_eq(zero).select(zero, term), plain)
}

/// As `LinearSum::add_edge` with [`crate::arc::Arc::moments`]: `toward . V`.
#[inline(always)]
fn edge_terms<S: Simd>(
    simd: S,
    arcs: &Four<S>,
    frame: &Frame<S>,
    seen: &Same<S>,
    (end_square, closed): (f64x4<S>, bool),
) -> f64x4<S> {
    let (zero, half, one, two) =
        (f64x4::splat(simd, 0.0), f64x4::splat(simd, 0.5), f64x4::splat(simd, 1.0), f64x4::splat(simd, 2.0));
    let q1 = one / arcs.start_square.sqrt();
    let q2 = if closed { q1.rotate_elements_left::<1>() } else { one / end_square.sqrt() };
    let (sin, cos) = (arcs.across * q1 * q2, arcs.inline * q1 * q2);
    let (c1, c2) = (arcs.start.dot(frame.toward) * q1, arcs.end.dot(frame.toward) * q2);
    let (s1, s2) = (arcs.start.dot(frame.along) * q1, arcs.end.dot(frame.along) * q2);
    let (wide, thin) = ((arcs.angle + sin) * half, half_angle_minus_sine(simd, arcs.angle, sin));
    let near = cos.simd_ge(zero);
    let (c, s) = (near.select(c1 + c2, c2 - c1), near.select(s1 + s2, s2 - s1));
    let (on, off, cross) = (near.select(wide, thin), near.select(thin, wide), near.select(sin, -sin));
    let (cc, ss) = (c * c, s * s);
    let scale = one / (two * (one + cos.abs()));
    let (cc, cs, ss) = ((on * cc + off * ss) * scale, cross * c * s * scale, (on * ss + off * cc) * scale);
    let (p1, p2) = (seen.n1.dot(frame.toward), seen.n1.dot(frame.along));
    let (g1, g2) = (seen.gradient.dot(frame.toward), seen.gradient.dot(frame.along));
    let mixed = g1 * p2 + g2 * p1;
    seen.beta * (cc * p1 + cs * p2) + frame.distance * (g1 * p1 * cc + mixed * cs + g2 * p2 * ss)
}

/// As that of [`crate::arc`].
#[inline(always)]
fn half_angle_minus_sine<S: Simd>(simd: S, angle: f64x4<S>, sin: f64x4<S>) -> f64x4<S> {
    let z = angle * angle;
    let z2 = z * z;
    let [c0, c1, c2, c3, c4, c5, c6, c7] = DOUBLE_SERIES;
    let rest = (pair(simd, [c1, c2], z) + pair(simd, [c3, c4], z) * z2)
        + (pair(simd, [c5, c6], z) + f64x4::splat(simd, c7) * z2) * (z2 * z2);
    let small = angle * z * (f64x4::splat(simd, c0) + z * rest);
    let wide = angle.simd_gt(f64x4::splat(simd, 1.0));
    wide.select((angle - sin) * f64x4::splat(simd, 0.5), small)
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::four::random::{polygon_and_receiver, vector};
    use crate::level::levels;
    use crate::plan::Plan;
    use crate::{Emission, horizon};

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut found = 0;
        for i in 0..3000 {
            let count = 3 + i % 7;
            let Some((polygon, receiver, size)) = polygon_and_receiver(&mut random, count, 5.0) else { continue };
            let emitter = Emitter::new(polygon, Emission::gradient(1.0, vector(&mut random, 1.0 / size))).unwrap();
            let mut first = None;
            for level in levels() {
                let found = on_level!(level, simd => sums::<_, true>(simd, &receiver, &emitter));
                let digits = found.map(|(power, terms)| (power, terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((power, irradiance, gradient)) = first.flatten() else { continue };
            found += 1;
            let plan = Plan::new(&receiver, emitter.polygon()).unwrap();
            let mut sum = LinearSum::<f64>::new(Seen::new(&receiver, &emitter, power));
            horizon::visit_boundary(&receiver, emitter.polygon(), &plan, |arc| sum.add::<true>(arc));
            let one_by_one = sum.total();
            assert_eq!((one_by_one.irradiance, one_by_one.gradient), (irradiance, gradient), "{receiver:?} {emitter:?}");
            assert_eq!(whole::<false>(&receiver, &emitter).unwrap().1.irradiance, irradiance);
        }
        println!("{found} found");
        assert!(found > 700, "{found}");
    }
}
