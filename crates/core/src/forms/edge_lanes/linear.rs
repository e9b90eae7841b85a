//! The sums of a linear emitter that is seen whole, four edges at a time, one a lane of a vector: the digits of the sums of
//! [`crate::forms::linear`], where double precision is sure of all decisions ([`crate::forms::edge_lanes`]).

use std::f64::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8, mask64x8};

use crate::boundary::plan::Horizon;
use crate::forms::edge_lanes::{EdgeLanes, SureCase, Weights, height_over_plane, plan, power_seen_whole};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{LinearSum, SeenLinear};
use crate::forms::linear_bound::{Errors, LinearBound};
use crate::lanes::functions::{logarithm, pair, x1_end};
use crate::lanes::instruction_set::{INSTRUCTION_SET, on_instruction_set};
use crate::lanes::vectors::{all, number_plus_first, plus_first};
use crate::problem::emission::Emitter;
use crate::problem::receiver::Receiver;
use crate::scalar::series::sine::DOUBLE_SERIES;
use crate::scalar::vec3::Vec3;

/// The sums and the power of two that normalised lengths, where double precision is sure of all decisions.
#[inline]
pub(crate) fn whole<const GRADIENT: bool>(receiver: &Receiver, emitter: &Emitter) -> Option<(f64, IrradianceAndGradient<f64>)> {
    on_instruction_set!(*INSTRUCTION_SET, simd => sums::<_, GRADIENT>(simd, receiver, emitter))
}

/// The same of a polygon that is seen whole, with lengths normalised by `power`, and a bound on their errors; where all is sure
/// and no edge is seen past a quarter turn.
#[inline]
pub(crate) fn bounded(receiver: &Receiver, emitter: &Emitter, power: f64) -> Option<(IrradianceAndGradient<f64>, LinearBound)> {
    on_instruction_set!(*INSTRUCTION_SET, simd => bounded_sums(simd, receiver, emitter, power))
}

/// The same of a polygon of which it is sure what is seen; the sums where that is all of it and its size is more than `narrow`
/// of the distance of its farthest vertex.
#[inline]
pub(crate) fn bounded_where_sure(receiver: &Receiver, emitter: &Emitter, narrow: f64) -> Option<SureCase<LinearBound>> {
    on_instruction_set!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, emitter.polygon())?;
        let is_asked = plan.horizon == Horizon::Above && emitter.polygon().size() * plan.power > narrow;
        Some(SureCase { plan, sums: if is_asked { bounded_sums(simd, receiver, emitter, plan.power) } else { None } })
    })
}

#[inline(always)]
fn bounded_sums<S: Simd>(
    simd: S,
    receiver: &Receiver,
    emitter: &Emitter,
    power: f64,
) -> Option<(IrradianceAndGradient<f64>, LinearBound)> {
    let polygon = emitter.polygon();
    let mut sum = LinearSum::new(SeenLinear::from(receiver, emitter, power, height_over_plane(simd, receiver, polygon, power)));
    let mut errors = Errors::new(&sum, receiver, emitter, power)?;
    let x = all(simd, receiver.position());
    let mut rest = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let four = EdgeLanes::new::<false>(simd, four, x, f64x4::splat(simd, power))?;
        let count = rest.min(4);
        let added = sum.add_four::<S, true>(simd, &four, (count, fours.len() == 1))?;
        errors.add_four(simd, &sum, (&four, &added), count)?;
        rest -= count;
    }
    let terms = sum.total();
    let bound = errors.bound(&sum, &terms);
    Some((terms, bound))
}

#[inline(always)]
fn sums<S: Simd, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    emitter: &Emitter,
) -> Option<(f64, IrradianceAndGradient<f64>)> {
    let polygon = emitter.polygon();
    let power = power_seen_whole(simd, receiver, polygon)?;
    let mut sum = LinearSum::new(SeenLinear::from(receiver, emitter, power, height_over_plane(simd, receiver, polygon, power)));
    let x = all(simd, receiver.position());
    let mut rest = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let four = EdgeLanes::new::<false>(simd, four, x, f64x4::splat(simd, power))?;
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
    fn new(simd: S, SeenLinear { n1, n2, height, beta, gradient }: SeenLinear<f64>) -> Self {
        Self {
            n1: all(simd, n1.into()),
            n2: all(simd, n2.into()),
            height: f64x4::splat(simd, height),
            beta: f64x4::splat(simd, beta),
            gradient: all(simd, gradient.into()),
        }
    }

    /// Of a point at r: `1/|r|`, and `n1.r` and the emission times that.
    #[inline(always)]
    fn at_end(&self, simd: S, r: Vec3<f64x4<S>>, square: f64x4<S>) -> [f64x4<S>; 3] {
        let inverse = f64x4::splat(simd, 1.0) / square.sqrt();
        [inverse, self.n1.dot(r) * inverse, (self.beta + self.gradient.dot(r)) * inverse]
    }
}

impl LinearSum<f64> {
    /// As [`LinearSum::add`] for the first `count` lanes.
    #[inline(always)]
    fn add_four<S: Simd, const GRADIENT: bool>(
        &mut self,
        simd: S,
        arcs: &EdgeLanes<S>,
        (count, closed): (usize, bool),
    ) -> Option<Added<S>> {
        let seen = Same::new(simd, self.seen);
        let ends = Ends::new(simd, arcs, seen.height, closed);
        let length = arcs.edge_square.sqrt();
        let along = arcs.e * (f64x4::splat(simd, 1.0) / length);
        let distance = arcs.across / length;
        let outward = along.cross(seen.n2);
        let kappa = seen.n2.dot(arcs.normal);
        let [start, end] = ends.logarithm;
        let (slope_outward, slope_along) = (seen.gradient.dot(outward), seen.gradient.dot(along));
        let flux = kappa * arcs.angle * slope_outward + (end - start) * slope_along;
        let x1 = x1_terms(simd, arcs, &ends, along, [distance, kappa])?;
        self.angles = plus_first(self.angles, arcs.normal * arcs.angle, count);
        self.contour = plus_first(self.contour, outward * flux, count);
        self.x1 = number_plus_first(self.x1, x1.term, count);
        let weighed = Weighed::new(simd, arcs, &ends, &seen, closed);
        if GRADIENT {
            let weight = weighed.weight(simd, arcs, &seen, (along, distance));
            self.edges = plus_first(self.edges, arcs.normal * -weight, count);
        }
        Some(Added { kappa, outward, slope_outward, slope_along, flux, ends, x1, weighed })
    }
}

/// What four arcs added, for the bound on its error.
pub(crate) struct Added<S: Simd> {
    pub(crate) kappa: f64x4<S>,
    pub(crate) outward: Vec3<f64x4<S>>,
    /// The emission's gradient along `outward` and along the edges.
    pub(crate) slope_outward: f64x4<S>,
    pub(crate) slope_along: f64x4<S>,
    pub(crate) flux: f64x4<S>,
    pub(crate) ends: Ends<S>,
    pub(crate) x1: X1<S>,
    pub(crate) weighed: Weighed<S>,
}

/// Of the ends of four arcs. Where all edges are here each one ends where the next one starts.
pub(crate) struct Ends<S: Simd> {
    /// `|r|^2`.
    pub(crate) square: [f64x4<S>; 2],
    /// `ln(r/h)`.
    pub(crate) logarithm: [f64x4<S>; 2],
}

/// What four segments add to X1, and what both their ends are made of, the starts before the ends.
pub(crate) struct X1<S: Simd> {
    pub(crate) term: f64x4<S>,
    pub(crate) s: f64x8<S>,
    pub(crate) d: f64x8<S>,
    pub(crate) distance: f64x8<S>,
    pub(crate) phi: f64x8<S>,
    pub(crate) psi: f64x8<S>,
    pub(crate) beyond: mask64x8<S>,
    /// The logarithm of the quotient.
    pub(crate) quotient: f64x4<S>,
}

/// What an edge's weight is made of: of its ends `1/|r|`, and n1 along r and the emission times that.
pub(crate) struct Weighed<S: Simd> {
    pub(crate) inverse: [f64x4<S>; 2],
    pub(crate) cosine: [f64x4<S>; 2],
    pub(crate) emission: [f64x4<S>; 2],
    pub(crate) weights: Weights<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn new(simd: S, arcs: &EdgeLanes<S>, height: f64x4<S>, closed: bool) -> Self {
        let (start, half, square) = (arcs.start_square, f64x4::splat(simd, 0.5), height * height);
        let first = logarithm(simd, start / square) * half;
        if closed {
            return Self { square: [start, next(start)], logarithm: [first, next(first)] };
        }
        let end = arcs.end.norm_squared();
        Self { square: [start, end], logarithm: [first, logarithm(simd, end / square) * half] }
    }
}

#[inline(always)]
fn next<S: Simd>(ends: f64x4<S>) -> f64x4<S> {
    ends.rotate_elements_left::<1>()
}

#[inline(always)]
pub(crate) fn both<S: Simd>(simd: S, [start, end]: [f64x4<S>; 2]) -> f64x8<S> {
    simd.combine_f64x4(start, end)
}

#[inline(always)]
pub(crate) fn twice<S: Simd>(simd: S, number: f64x4<S>) -> f64x8<S> {
    simd.combine_f64x4(number, number)
}

/// As [`crate::forms::segment::x1_term`], with both ends of the four segments side by side; where all is sure.
#[inline(always)]
fn x1_terms<S: Simd>(
    simd: S,
    arcs: &EdgeLanes<S>,
    ends: &Ends<S>,
    along: Vec3<f64x4<S>>,
    [distance, kappa]: [f64x4<S>; 2],
) -> Option<X1<S>> {
    let (signed, zero, one) = (distance * kappa, f64x4::splat(simd, 0.0), f64x8::splat(simd, 1.0));
    let d = signed.abs();
    let reach = distance + d;
    let s = simd.combine_f64x4(arcs.start.dot(along), arcs.end.dot(along));
    let (d, distance, reaches) = (twice(simd, d), twice(simd, distance), twice(simd, reach * reach));
    let square = s * s;
    let beyond = square.simd_gt(d * distance);
    let above = beyond.select(square * reaches * f64x8::splat(simd, 4.0), one);
    let below = beyond.select((d * d + square) * (distance * distance + square), one);
    let ([term, phi, psi], plain) = x1_end(simd, s.abs(), [d, distance], both(simd, ends.logarithm), beyond);
    if !plain.all_true() {
        return None;
    }
    let back = s.simd_lt(f64x8::splat(simd, 0.0));
    let (start, end) = simd.split_f64x8(back.select(-term, term));
    let ((start_above, end_above), (start_below, end_below)) =
        (simd.split_f64x8(back.select(below, above)), simd.split_f64x8(back.select(above, below)));
    let quotient = logarithm(simd, (end_above * start_below) / (end_below * start_above));
    let term = (end - start) + quotient * f64x4::splat(simd, PI * 0.25);
    let term = signed.simd_lt(zero).select(-term, term);
    let term = signed.simd_eq(zero).select(zero, term);
    Some(X1 { term, s, d, distance, phi, psi, beyond, quotient })
}

impl<S: Simd> Weighed<S> {
    #[inline(always)]
    fn new(simd: S, arcs: &EdgeLanes<S>, ends: &Ends<S>, seen: &Same<S>, closed: bool) -> Self {
        let [q1, c1, b1] = seen.at_end(simd, arcs.start, ends.square[0]);
        let [q2, c2, b2] = if closed { [next(q1), next(c1), next(b1)] } else { seen.at_end(simd, arcs.end, ends.square[1]) };
        Self { inverse: [q1, q2], cosine: [c1, c2], emission: [b1, b2], weights: Weights::new(simd, arcs, [q1, q2]) }
    }

    /// As `LinearSum::weight`.
    #[inline(always)]
    fn weight(&self, simd: S, arcs: &EdgeLanes<S>, seen: &Same<S>, frame: (Vec3<f64x4<S>>, f64x4<S>)) -> f64x4<S> {
        let weight = self.weights.of(self.emission, self.cosine);
        let near = arcs.inline.simd_ge(f64x4::splat(simd, 0.0));
        if near.all_true() { weight } else { near.select(weight, weights_in_frame(simd, arcs, seen, frame, self.inverse)) }
    }
}

/// The same with [`crate::boundary::arc::Arc::moments`].
#[inline(always)]
fn weights_in_frame<S: Simd>(
    simd: S,
    arcs: &EdgeLanes<S>,
    seen: &Same<S>,
    (along, distance): (Vec3<f64x4<S>>, f64x4<S>),
    [q1, q2]: [f64x4<S>; 2],
) -> f64x4<S> {
    let (zero, half, one, two) =
        (f64x4::splat(simd, 0.0), f64x4::splat(simd, 0.5), f64x4::splat(simd, 1.0), f64x4::splat(simd, 2.0));
    let toward = along.cross(arcs.normal);
    let (sin, cos) = (arcs.across * q1 * q2, arcs.inline * q1 * q2);
    let (c1, c2) = (arcs.start.dot(toward) * q1, arcs.end.dot(toward) * q2);
    let (s1, s2) = (arcs.start.dot(along) * q1, arcs.end.dot(along) * q2);
    let (wide, thin) = ((arcs.angle + sin) * half, half_angle_minus_sine(simd, arcs.angle, sin));
    let near = cos.simd_ge(zero);
    let (c, s) = (near.select(c1 + c2, c2 - c1), near.select(s1 + s2, s2 - s1));
    let (on, off, cross) = (near.select(wide, thin), near.select(thin, wide), near.select(sin, -sin));
    let (cc, ss) = (c * c, s * s);
    let scale = one / (two * (one + cos.abs()));
    let (cc, cs, ss) = ((on * cc + off * ss) * scale, cross * c * s * scale, (on * ss + off * cc) * scale);
    let (p1, p2) = (seen.n1.dot(toward), seen.n1.dot(along));
    let (g1, g2) = (seen.gradient.dot(toward), seen.gradient.dot(along));
    let mixed = g1 * p2 + g2 * p1;
    (seen.beta * (cc * p1 + cs * p2) + distance * (g1 * p1 * cc + mixed * cs + g2 * p2 * ss)) / distance
}

/// As that of [`crate::boundary::arc`].
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
    use crate::boundary::horizon;
    use crate::boundary::plan::Plan;
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use crate::lanes::instruction_set::instruction_sets;
    use crate::problem::emission::Emission;

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut found = 0;
        for i in 0..3000 {
            let count = 3 + i % 7;
            let Some((polygon, receiver, size)) = polygon_and_receiver(&mut random, count, 5.0) else { continue };
            let emitter = Emitter::new(polygon, Emission::gradient(1.0, vector(&mut random, 1.0 / size))).unwrap();
            let mut first = None;
            for level in instruction_sets() {
                let found = on_instruction_set!(level, simd => sums::<_, true>(simd, &receiver, &emitter));
                let digits = found.map(|(power, terms)| (power, terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((power, irradiance, gradient)) = first.flatten() else { continue };
            found += 1;
            let plan = Plan::new(&receiver, emitter.polygon()).unwrap();
            let mut sum = LinearSum::<f64>::new(SeenLinear::new(&receiver, &emitter, power));
            horizon::visit_boundary(&receiver, emitter.polygon(), &plan, |arc| sum.add::<true>(arc));
            let one_by_one = sum.total();
            assert_eq!((one_by_one.irradiance, one_by_one.gradient), (irradiance, gradient), "{receiver:?} {emitter:?}");
            assert_eq!(whole::<false>(&receiver, &emitter).unwrap().1.irradiance, irradiance);
        }
        println!("{found} found");
        assert!(found > 700, "{found}");
    }
}
