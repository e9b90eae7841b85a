//! Bounds on the errors of the sums of a linear emitter that is fully visible or that the horizon cuts, derived, not run: four
//! edges at a time, one a lane.
//!
//! To first order in the unit roundoff u = 2^-53; [`SECOND_ORDER`] pays for the rest. There is no bound next to underflow, straight
//! below a vertex to 1e-10, or where a normal, a gradient or a height has few digits. The same bounds the sums in double-double, in
//! another unit ([`crate::forms::edge_lanes::precise`]).
//!
//! `docs/theory/linear-bound.md` has the symbols and the derivation.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8, mask64x4};
use radgrad_numbers::double_double::ROUNDOFF_OF_DOUBLE_DOUBLE;
use radgrad_numbers::double_double_on_lanes::ROUNDOFF_ON_LANES;
use radgrad_numbers::lanes::vectors::{plus_first, splat_vector};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::forms::constant_bound::units::{MOST_DISPLACED, WEIGHT};
use crate::forms::constant_bound::{with_displacement, with_product};
use crate::forms::edge_lanes::EdgeLanes;
use crate::forms::edge_lanes::linear::{Added, HorizonSegment, both, only};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{ContourTerm, LinearSum};
use crate::forms::segment::X1End;
use crate::problem::emission::Emitter;
use crate::problem::receiver::Receiver;

/// Bounds on the errors of radiosity and gradient but for the factor `rho/pi`, the second one on the norm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinearBound {
    pub(crate) radiosity: f64,
    pub(crate) gradient: f64,
}

/// Pays for terms of second order in the errors.
const SECOND_ORDER: f64 = 1.002;

/// Errors of the terms of an edge's weight, relative, in units of roundoff: of the first one for given p, `g + sin g` and `c +
/// c'`, of the second one for given p, g and `c' - c`.
pub const CHI_TERM: f64 = 14.0;
/// See [`CHI_TERM`].
pub const PSI_TERM: f64 = 6.0;

/// Relative errors that are small beside the rounding of doubles, of numbers that are rounded to doubles.
const NEGLIGIBLE: f64 = ROUNDOFF / 2048.0;

/// Largest relative error of the height with which anything is bounded.
const MOST_OF_HEIGHT: f64 = 1e10 * ROUNDOFF;

/// `pi/4` times the 5.6 of the quotient's logarithm, rounded up.
const OF_QUOTIENT: f64 = 4.4;

/// `pi (2 + 3)`, rounded up: a line may be 2 dd on the one side, and 3 dd on the other.
const OF_EITHER_SIDE: f64 = 16.0;

/// Past a right angle, `pi/2` times the factors in the error of the logarithm, rounded up: the 6 of s, the 2 of ew and the 12 of S.
const PAST_BY_RAY: f64 = 9.43;
const PAST_BY_MOMENT: f64 = 3.15;
const PAST_BY_DISTANCE: f64 = 19.0;

/// `pi/2`, rounded up.
const PAST_BY_END: f64 = 1.58;

/// The rest: 9, and `pi/2` times 7.5 and 5.5, rounded up.
const PAST: f64 = 30.0;

/// The same without the errors of s.
const PAST_ROUNDED: f64 = 17.7;

/// Relative error of the derivatives of an end, for `s >= LEAST_ALONG S`: that of h, up to [`MOST_OF_HEIGHT`], counts twice in `x
/// cot x`, which is 1 at most, and that of d over s once.
const DERIVATIVE_ERROR: f64 = 1e-5;
const LEAST_ALONG: f64 = 1e-8;

/// Up to this `-cot(phi + psi)` the derivatives are taken together.
const FAR_PAST: f64 = 4.0;

const _: () = assert!(
    OF_QUOTIENT >= 5.6 * FRAC_PI_4
        && OF_EITHER_SIDE >= 5.0 * PI
        && PAST_BY_RAY >= 6.0 * FRAC_PI_2
        && PAST_BY_MOMENT >= 2.0 * FRAC_PI_2
        && PAST_BY_DISTANCE >= 12.0 * FRAC_PI_2
        && PAST_BY_END >= FRAC_PI_2
        && PAST >= 9.0 + (7.5 + 5.5) * FRAC_PI_2
        && PAST_ROUNDED >= 9.0 + 5.5 * FRAC_PI_2
);

/// `ew`, and how far the ends of an edge that the horizon may cut are off.
type Moving<T> = (T, Option<T>);

/// Errors in units of roundoff: those of the input, and sums over the edges.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// The unit.
    unit: f64,
    /// `|gB|`.
    steepness: f64,
    beta: f64,
    height: f64,
    additions: f64,
    /// Twice those of `Phi.n1`, of `gB.Phi`, and X1.
    first: Vec3<f64>,
    /// Errors of the contour term along n1 and of the edges, and the sum of the sizes of fluxes.
    second: Vec3<f64>,
}

impl Errors {
    /// Where normal, gradient and height have their digits. In a unit of double-doubles, to which these are not rounded, they may err
    /// by its share of an operation.
    #[inline(always)]
    pub(crate) fn new(sum: &LinearSum<f64>, receiver: &Receiver, emitter: &Emitter, power: f64, unit: f64) -> Option<Self> {
        let negligible = if unit < ROUNDOFF { ROUNDOFF_ON_LANES } else { NEGLIGIBLE };
        let (polygon, emission, seen) = (emitter.polygon(), emitter.affine(), &sum.seen);
        let to_first = (Vec3::from(polygon.vertices()[0]) - Vec3::from(receiver.position())) * power;
        let steepness = seen.gradient.norm();
        let defect = polygon.planarity_defect() * power;
        let reach = to_first.x.abs() + to_first.y.abs() + to_first.z.abs();
        let unknown = reach * (polygon.normal_error() + 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE) + defect;
        let height = seen.height + unknown * (1.0 / unit);
        let lost = (2.0 * steepness * defect + emission.residual) * (1.0 / unit);
        let beta = 5.0 * steepness * to_first.norm() + seen.beta.abs() + lost;
        let gradient = 2.0 * emission.gradient_error() / power;
        let is_known = polygon.normal_error() <= negligible
            && gradient <= negligible * steepness
            && height * unit <= MOST_OF_HEIGHT * seen.height;
        let additions = (polygon.vertices().len() - 1) as f64;
        let none = Vec3::new(0.0, 0.0, 0.0);
        is_known.then_some(Self { unit, steepness, beta, height, additions, first: none, second: none })
    }

    /// Bound on the error of X1.
    #[inline(always)]
    pub(crate) fn of_x1(&self) -> f64 {
        SECOND_ORDER * self.unit * self.first.z
    }

    /// Counts one arc more than edges in the sums.
    pub(crate) fn add_arc(&mut self) {
        self.additions += 1.0;
    }

    /// Adds the first `count` lanes, of them those that are visible, where the horizon moves ends so far; unless `WIDE`, only
    /// where no edge is seen past a quarter turn.
    #[inline(always)]
    pub(crate) fn add_four<S: Simd, const WIDE: bool>(
        &mut self,
        simd: S,
        sum: &LinearSum<f64>,
        (four, added): (&EdgeLanes<S>, &Added<S>),
        cut: Option<(mask64x4<S>, f64x4<S>)>,
        count: usize,
    ) -> Option<()> {
        let EdgeLanes { arc, line, .. } = four;
        let narrow = arc.inline.simd_ge(f64x4::splat(simd, 0.0));
        let plain = arc.across.simd_ge(f64x4::splat(simd, 1e-100));
        if !(if WIDE { plain } else { plain & narrow }).all_true() {
            return None;
        }
        let (n1, gradient) = (splat_vector(simd, sum.seen.n1.into()), splat_vector(simd, sum.seen.gradient.into()));
        let (g, ew) = (arc.angle, four.relative_error());
        let least = g.min(f64x4::splat(simd, 1.0));
        let (visible, moved) = match cut {
            Some((visible, moved)) => (Some(visible), Some(moved)),
            None => (None, None),
        };
        if let Some(moved) = moved
            && !(moved * self.unit).simd_le(f64x4::splat(simd, MOST_DISPLACED)).all_true()
        {
            return None;
        }
        let turned = with_displacement(least * 8.0 + g * 4.0, moved, 2.0);
        let (dg, ds) = (turned + least * ew, with_displacement(g * (ew + 14.0), moved, 2.0));
        let (of_angle, across) = (turned + g * 3.5, g * (ew + (2.0 + self.additions)));
        let angles = n1.dot(line.normal).abs() * of_angle + across;
        let slopes = gradient.dot(line.normal).abs() * of_angle + across * self.steepness;
        let x1 = self.x1(simd, sum.seen.height, (ew, moved), (arc, added))?;
        self.first = plus_first(self.first, only(simd, visible, Vec3::new(angles, slopes, x1)), count);
        let flux = added.contour.flux.abs();
        let (facing, of_flux) = (n1.dot(added.contour.outward).abs(), self.flux((ew, moved), [g, turned], added));
        let contour = facing * (of_flux + flux * 4.5) + flux * (self.additions + 8.5);
        let mut edges = self.edges((ew, moved), [g, dg, ds], (arc, added));
        if WIDE && !narrow.all_true() {
            let beta = f64x4::splat(simd, sum.seen.beta.abs());
            edges = narrow.select(edges, self.wide_edges((ew, moved), [g, dg, ds], beta, line.nearness()));
        }
        self.second = plus_first(self.second, only(simd, visible, Vec3::new(contour, edges, flux)), count);
        Some(())
    }

    #[inline(always)]
    fn flux<S: Simd>(&self, (ew, moved): Moving<f64x4<S>>, [g, of_g]: [f64x4<S>; 2], added: &Added<S>) -> f64x4<S> {
        let ContourTerm { kappa, slope_outward, slope_along, flux, .. } = added.contour;
        let (kappa, outward, along) = (kappa.abs(), slope_outward.abs(), slope_along.abs());
        let [start, end] = added.logarithms;
        let difference = (end - start).abs();
        let of_difference = with_displacement((start.abs() + end.abs()) * 3.0 + 6.0 + difference, moved, 2.0);
        let turned = kappa * g;
        let first = outward * (g * (ew + 5.0) + kappa * of_g + turned * 10.0) + turned * (9.5 * self.steepness);
        first + along * (of_difference + difference * 5.5) + difference * (6.0 * self.steepness) + flux.abs()
    }

    #[inline(always)]
    fn x1<S: Simd>(
        &self,
        simd: S,
        height: f64,
        (ew, moved): Moving<f64x4<S>>,
        (arc, added): (&Arc<f64x4<S>>, &Added<S>),
    ) -> Option<f64x4<S>> {
        let (x1, inverse) = (&added.x1, both(simd, [arc.start.inverse, arc.end.inverse]));
        let square = both(simd, [arc.start.square, arc.end.square]);
        let (s, d, distance, r) = (x1.s, x1.d, x1.distance, square * inverse);
        let (psi, logarithm) = (x1.ends.psi, both(simd, added.logarithms).abs());
        let foot_square = d * d + s * s;
        if !foot_square.simd_ge(square * 1e-20).all_true() {
            return None;
        }
        let w = both(simd, [ew, ew]);
        let moved = moved.map(
            #[inline(always)]
            |moved| both(simd, [moved, moved]),
        );
        let of_phi = with_product(s * (d * 16.0 + distance * (w + 5.0)) + d * r * 6.0, moved, 1.0, d * r) / foot_square;
        let of_psi = with_displacement(psi * (w + 15.5) + 6.0, moved, 1.0);
        let of_logarithm = with_displacement(logarithm * 8.0 + (3.5 + self.height / height), moved, 1.0);
        let far = (s * s - d * distance) / foot_square * (w * PAST_BY_MOMENT + PAST_BY_DISTANCE) + (PAST + PAST_BY_RAY);
        let past = with_displacement(far, moved, PAST_BY_END);
        let of_end = of_x1_end(
            &x1.ends,
            logarithm,
            [s, d, distance],
            f64x8::splat(simd, 1.0 / height),
            [of_phi, of_psi, of_logarithm, past],
        );
        let (start, end) = simd.split_f64x8(of_end);
        let (d, distance) = (simd.split_f64x8(d).0, simd.split_f64x8(distance).0);
        let of_d = distance * (ew + 5.0) + d * 11.5;
        let either = (of_d * (2.0 * self.unit)).simd_ge(d).select(of_d * (OF_EITHER_SIDE / height), f64x4::splat(simd, 0.0));
        Some(start + end + x1.quotient.abs() * OF_QUOTIENT + x1.term.abs() * self.additions + either)
    }

    #[inline(always)]
    fn edges<S: Simd>(
        &self,
        (ew, moved): Moving<f64x4<S>>,
        [g, dg, ds]: [f64x4<S>; 3],
        (arc, added): (&Arc<f64x4<S>>, &Added<S>),
    ) -> f64x4<S> {
        let ([c1, c2], [p1, p2]) = (added.cosines, added.emissions);
        let (size, cosines) = (p1.abs() + p2.abs(), c1.abs() + c2.abs());
        let of_emission = (arc.start.inverse + arc.end.inverse) * self.beta + size * 6.5 + 10.0 * self.steepness;
        let of_emission = with_product(of_emission, moved, 1.0, size + 2.0 * self.steepness);
        let of_cosines = with_displacement(cosines * 6.5 + 10.0, moved, 2.0);
        let of_chi = with_product(cosines * CHI_TERM, moved, 4.0, cosines);
        let (sum, turn) = arc.angle_and_sine();
        let turn = turn * 0.25;
        let first = turn * (size * cosines * (dg + ds) + sum * (cosines * of_emission + size * (of_chi + of_cosines)));
        let second = g * (size * dg * 0.11 + (g * (of_emission + size * PSI_TERM) + size * of_cosines) * 0.091);
        let weight = size * (turn * sum * cosines + g * g.min(cosines) * 0.091);
        first + second + weight * (ew + (WEIGHT + self.additions))
    }

    /// The same past a quarter turn, from `|beta|` and one over the distances of the lines.
    #[inline(always)]
    fn wide_edges<S: Simd>(
        &self,
        (ew, moved): Moving<f64x4<S>>,
        [g, dg, ds]: [f64x4<S>; 3],
        beta: f64x4<S>,
        nearness: f64x4<S>,
    ) -> f64x4<S> {
        let turned = ew * 2.0 + 10.0;
        let column = dg * 0.5 + ds + g * (with_displacement(turned + 54.0, moved, 2.0) * (2.0 * 0.71) + 28.0);
        let first = (beta * (column + g * (turned + 36.0)) + g * self.beta) * nearness;
        let second = (column * 2.0 + g * (turned + (36.0 + 20.0))) * self.steepness;
        first + second + g * (beta * nearness + self.steepness) * (ew + (WEIGHT + self.additions))
    }

    /// Adds the horizon's segment, whose ends have these errors.
    #[inline(always)]
    pub(crate) fn add_horizon(&mut self, sum: &LinearSum<f64>, horizon: &HorizonSegment, moved: [f64; 2]) -> Option<()> {
        let HorizonSegment { arc, frame, logarithms, contour, s, d, ends, term, quotient } = horizon;
        let (height, steepness, g) = (sum.seen.height, self.steepness, arc.angle.abs());
        let inverse_sine = frame.distance / height;
        let of_along = 8.0 * inverse_sine + 6.0;
        let turned = moved[0] + moved[1] + 3.5 + 9.0 * g.min(1.0) + 4.0 * g;
        let is_known = [of_along, moved[0], moved[1]].iter().all(|error| error * self.unit <= MOST_DISPLACED);
        if !is_known || g + turned * self.unit * SECOND_ORDER >= PI {
            return None;
        }
        let ContourTerm { kappa, slope_outward, slope_along, flux, outward } = *contour;
        let difference = (logarithms[1] - logarithms[0]).abs();
        let of_difference = 3.0 * (logarithms[0].abs() + logarithms[1].abs()) + 6.0 + difference + moved[0] + moved[1];
        let of_flux = slope_outward.abs() * (8.0 * g + kappa.abs() * (turned + 3.0 * g))
            + kappa.abs() * g * steepness * (of_along + 8.0)
            + slope_along.abs() * (of_difference + 3.0 * difference)
            + difference * steepness * (of_along + 6.0)
            + flux.abs();
        let facing = sum.seen.n1.dot(outward).abs();
        let contour = facing * of_flux + flux.abs() * (of_along + 13.5 + self.additions);
        let of_height = self.height / height;
        let of_distance = frame.distance * (of_height + 8.0 * inverse_sine + 4.0);
        let of_d = 8.0 * frame.distance + d * (of_height + 8.0 * inverse_sine + 6.0);
        let mut x1 = quotient.abs() * OF_QUOTIENT + term.abs() * self.additions;
        if of_d * (2.0 * self.unit) >= *d {
            x1 += of_d * (OF_EITHER_SIDE / height);
        }
        for (i, end) in [&arc.start, &arc.end].into_iter().enumerate() {
            let (s, psi) = (s[i], ends[i].psi);
            let (foot_square, r, logarithm) = (d * d + s * s, end.square * end.inverse, logarithms[i].abs());
            let is_plain = foot_square >= end.square * 1e-20;
            if !is_plain {
                return None;
            }
            let of_s = r * (of_along + moved[i] + 4.0);
            let of_phi = (d * of_s + s * of_d) / foot_square;
            let of_psi = (frame.distance * of_s + s * of_distance) / end.square + 4.0 * psi;
            let of_logarithm = 8.0 * logarithm + 3.5 + of_height + moved[i];
            let far = (s * s - d * frame.distance) / ((frame.distance + d) * foot_square);
            let past = PAST + FRAC_PI_2 * (of_s * s / end.square + far * (of_distance + of_d));
            x1 += of_x1_end(&ends[i], logarithm, [s, *d, frame.distance], 1.0 / height, [of_phi, of_psi, of_logarithm, past]);
        }
        let angles = turned + g * (5.5 + self.additions);
        self.first = self.first + Vec3::new(angles, steepness * (turned + g * (8.0 + self.additions)), x1);
        self.second = self.second + Vec3::new(contour, 0.0, flux.abs());
        Some(())
    }

    /// The bounds of the sums' total.
    #[inline(always)]
    pub(crate) fn bound(&self, sum: &LinearSum<f64>, terms: &IrradianceAndGradient<f64>) -> LinearBound {
        let Self { steepness, .. } = *self;
        let case = &sum.seen;
        let (phi, q) = sum.phi_and_q();
        let (size, facing, slope, across) =
            (phi.norm(), phi.dot(case.n1).abs(), case.gradient.dot(phi).abs(), q.dot(case.n1).abs());
        let of_phi = 0.5 * self.first.x + 5.0 * size;
        let of_slope = 0.5 * self.first.y + 5.0 * steepness * size;
        let partial = 0.5 * (steepness * sum.x1.abs() + self.second.z) + slope;
        let of_x1 = case.gradient.dot(case.n1).abs() * self.first.z;
        let of_q = 0.5 * (of_x1 + self.second.x) + case.n1.dot(case.n2).abs() * of_slope + 9.0 * partial;
        let (beta, height) = (case.beta.abs(), case.height);
        let radiosity = beta * of_phi + facing * self.beta + height * of_q + self.height * across;
        let products = 4.0 * (beta * size + height * partial) + 3.0 * terms.irradiance.dot(case.n1).abs();
        let in_plane = steepness * of_phi;
        let gradient = (in_plane * in_plane + of_q * of_q).sqrt() + self.second.y;
        let sums = 5.0 * (steepness * facing + across) + 4.0 * terms.gradient.norm();
        let units = SECOND_ORDER * self.unit;
        LinearBound { radiosity: units * (radiosity + products), gradient: units * (gradient + sums) }
    }
}

/// The sizes of the derivatives of an end of a segment in X1 with respect to phi and psi, at most; where s is not next to 0. And half
/// of `-cot(phi + psi)`.
#[inline(always)]
fn derivatives<T: radgrad_numbers::arithmetic::Doubles>(
    X1End { phi, psi, .. }: &X1End<T>,
    logarithm: T,
    [s, d, distance]: [T; 3],
    inverse_height: T,
) -> ([T; 2], T) {
    let (square, product, reach) = (s * s, d * distance, distance + d);
    let (inverse, over_height) = (s.like(0.5) / (s * reach), reach * inverse_height);
    // Halves of cotangents, of phi - psi and with its sign turned of phi + psi.
    let cotangent = (product + square) * inverse * (over_height * over_height);
    let past = (square - product) * inverse;
    // Halves of x cot x, and that of phi.
    let (of_sum, of_difference) = ((*phi + *psi) * past, (*phi - *psi) * cotangent);
    let of_phi = *phi * (d / s);
    let error = s.like(DERIVATIVE_ERROR) + *phi * cotangent * s.like(32.0 * ROUNDOFF);
    let by_phi = (logarithm + (of_difference - of_sum) - of_phi).abs() + error;
    let by_psi = (of_sum + of_difference).abs() + error;
    ([by_phi, by_psi], past)
}

/// The error of an end of a segment in X1, given `ln(r/h)`, s, d and S, and 1/h; and the errors of phi before its own rounding,
/// of psi, of the logarithm, and past a right angle of the quotient's and the sums.
#[inline(always)]
fn of_x1_end<T: radgrad_numbers::arithmetic::Doubles>(
    end: &X1End<T>,
    logarithm: T,
    distances: [T; 3],
    inverse_height: T,
    [of_phi, of_psi, of_logarithm, past]: [T; 4],
) -> T {
    let X1End { phi, psi, is_obtuse, .. } = *end;
    let [s, _, distance] = distances;
    let (zero, four, product) = (s.like(0.0), s.like(4.0), phi * psi);
    let (by_phi, by_psi) = (logarithm + product.min(s.like(1.0)), product.min(s.like(0.5)));
    let ([along_phi, along_psi], half_cotangent) = derivatives(end, logarithm, distances, inverse_height);
    let together =
        along_phi * of_phi + along_psi * of_psi + by_psi * (psi * four) + T::choose(is_obtuse, s.like(PAST_ROUNDED), zero);
    let apart = by_phi * of_phi + by_psi * of_psi + T::choose(is_obtuse, past, zero);
    let least = T::choose(s.exceeds(distance * s.like(LEAST_ALONG)), together.min(apart), apart);
    let of_end = T::choose(half_cotangent.exceeds(s.like(FAR_PAST / 2.0)), apart, least);
    phi * (of_logarithm + by_phi * four + phi * phi * s.like(2.4) + psi * psi * s.like(3.5)) + of_end
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::derivatives;
    use crate::boundary::case::Case;
    use crate::boundary::plan::{Horizon, Plan};
    use crate::forms::edge_lanes::linear::bounded_in;
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
    use crate::forms::segment::X1End;
    use crate::problem::emission::{Emission, Emitter};
    use crate::problem::receiver::Receiver;
    use radgrad_numbers::ball::Ball;
    use radgrad_numbers::double_double::DoubleDouble;
    use radgrad_numbers::number::ROUNDOFF;
    use radgrad_numbers::real::Real;
    use radgrad_numbers::vec3::Vec3;

    #[test]
    fn bounds_hold_and_are_within_a_few_hundred_errors() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let (mut shares, mut worst, mut counts) = ([Vec::new(), Vec::new()], [0.0f64; 2], [0; 2]);
        for i in 0..6000 {
            let count = 3 + i % 7;
            let spread = [0.7, 1.5, 5.0][i % 3];
            let Some((polygon, mut receiver, size)) = polygon_and_receiver(&mut random, count, spread) else { continue };
            if i % 4 == 0 {
                receiver = Receiver::new(receiver.position(), receiver.direction() + vector(&mut random, 2.0), 1.0).unwrap();
            }
            let steep = if i % 2 == 0 { 1.0 / size } else { random.random_range(1e-3..30.0) / size };
            let emitter = Emitter::new(polygon, Emission::gradient(1.0, vector(&mut random, steep))).unwrap();
            let Some(plan) = Plan::new(&receiver, emitter.polygon()).filter(|plan| !plan.on_surface) else { continue };
            let Some((terms, bound)) = bounded_in(ROUNDOFF, &receiver, &emitter, &plan) else { continue };
            let kind = usize::from(plan.horizon == Horizon::Crossing);
            counts[kind] += 1;
            let case = Case { receiver: &receiver, emitter: &emitter, occluders: &[], plan: &plan };
            let truth = IrradianceAndGradient::<Ball<DoubleDouble>>::sum::<true, true>(&case).unwrap();
            let n1 = Vec3::from(receiver.normal());
            let precise = crate::problem::receiver::unit_normal::<Ball<DoubleDouble>>(&receiver).dot(truth.irradiance);
            let radiosity = (Ball::exact(n1.dot(terms.irradiance)) - precise).middle().hi.abs();
            let difference = |value: f64, truth: Ball<DoubleDouble>| (Ball::exact(value) - truth).middle().hi;
            let Vec3 { x, y, z } = truth.gradient;
            let gradient = terms.gradient;
            let gradient = Vec3::new(difference(gradient.x, x), difference(gradient.y, y), difference(gradient.z, z)).length();
            for (share, shares) in [radiosity / bound.radiosity, gradient / bound.gradient].into_iter().zip(&mut shares) {
                shares.push(share);
                worst[kind] = worst[kind].max(share);
            }
        }
        let medians = shares.map(|mut shares| {
            shares.sort_by(f64::total_cmp);
            shares[shares.len() / 2]
        });
        println!("{counts:?} found whole and cut, medians {medians:?}, worst {worst:?}");
        assert!(
            counts[0] > 1000
                && counts[1] > 100
                && worst.iter().all(|&worst| worst < 1.0 && worst > 1e-3)
                && medians.iter().all(|&m| m > 1.0 / 400.0),
            "{counts:?} {medians:?} {worst:?}"
        );
    }

    /// `J'`.
    fn slope(x: f64) -> f64 {
        if x.abs() < 1e-3 { x * x / 6.0 } else { 0.5 * (1.0 - x * libm::cos(x) / libm::sin(x)) }
    }

    #[test]
    fn derivatives_of_an_end_are_those_of_its_functions() {
        let mut ends = 0;
        for (i, j) in (1..400).flat_map(|i| (1..=i).map(move |j| (i, j))) {
            let [phi, psi] = [i, j].map(|k| f64::from(k) * (FRAC_PI_2 / 400.0));
            let (s, d, distance) = (1.0, libm::cos(phi) / libm::sin(phi), libm::cos(psi) / libm::sin(psi));
            let square = (distance - d) * (distance + d);
            if square <= 0.0 {
                continue;
            }
            let logarithm = 0.5 * libm::log((s + distance * distance) / square);
            let end = X1End::new(s, [d, distance, d + distance], logarithm);
            let ([by_phi, by_psi], _) = derivatives(&end, logarithm, [s, d, distance], 1.0 / square.sqrt());
            let of_phi = logarithm + 2.0 * slope(phi) - slope(phi - psi) - slope(phi + psi);
            let of_psi = slope(phi - psi) - slope(phi + psi);
            assert!(of_phi.abs() <= by_phi && of_psi.abs() <= by_psi, "{phi} {psi}: {of_phi} {by_phi}, {of_psi} {by_psi}");
            assert!(by_phi - of_phi.abs() < 2e-5 && by_psi - of_psi.abs() < 2e-5, "{phi} {psi}");
            ends += 1;
        }
        assert!(ends > 70_000, "{ends}");
    }

    #[test]
    fn derivatives_of_a_term_are_within_their_bounds() {
        for i in 1..=400 {
            let phi = f64::from(i) * (FRAC_PI_2 / 400.0);
            for j in 0..=i {
                let psi = f64::from(j) * (FRAC_PI_2 / 400.0);
                let sum = phi + psi;
                let (of_phi, of_psi) = if sum <= FRAC_PI_2 {
                    (2.0 * slope(phi) - slope(phi - psi) - slope(sum), slope(phi - psi) - slope(sum))
                } else {
                    let supplement = 2.0 * FRAC_PI_2 - sum;
                    (2.0 * slope(phi) - slope(phi - psi) - slope(supplement), slope(phi - psi) - slope(supplement))
                };
                let (most_of_phi, most_of_psi) = ((phi * psi).min(1.0) + 1e-12, (phi * psi).min(0.5) + 1e-12);
                assert!(of_phi.abs() <= most_of_phi && of_psi.abs() <= most_of_psi, "{phi} {psi} {of_phi} {of_psi}");
            }
        }
    }
}
