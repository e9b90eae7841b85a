//! The sums over arcs for a constant emission in double precision, with a bound on their errors that is derived, not run.
//!
//! To first order in the unit roundoff u = 2^-53; [`SECOND_ORDER`] pays for the rest. There is no bound where w or a crossing point
//! errs by more than 1e-6 relative, next to underflow of a moment, or where an arc of the horizon next to pi may have either sign.
//!
//! `docs/theory/constant-bound.md` has the symbols and the derivation.

pub(crate) mod past_occluders;
pub mod units;

use std::ops::{Add, Mul};

use radgrad_numbers::arithmetic::Doubles;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::horizon;
use crate::boundary::line::LEAST_MOMENT;
#[cfg(doc)]
use crate::boundary::line::Line;
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::constant_bound::units::{LARGEST_PSI, MOST_DISPLACED, PSI_TERM, SECOND_ORDER, SLOPE_OF_PSI};
use crate::forms::edge_lanes;
use crate::forms::edge_lanes::SureCase;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};

/// Bounds on the errors of the sums for a unit emission.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundedSum {
    /// Bound on the error of `n1.Phi`.
    pub(crate) irradiance: f64,
    /// Bound on the norm of the error of the gradient's sum.
    pub(crate) gradient: f64,
}

/// Relative displacement of a crossing point: along its edge, and otherwise.
#[derive(Debug, Clone, Copy)]
struct Moved {
    xi: f64,
    eta: f64,
}

impl Moved {
    /// The displacement of a point at one over a distance.
    #[inline(always)]
    fn at_inverse_distance(inverse: f64) -> Self {
        Self { xi: ROUNDOFF * (4.1 + 13.9 * inverse), eta: ROUNDOFF * (3.0 + 10.4 * inverse) }
    }
}

/// An arc of the horizon's part in the errors of the angles and of the gradient.
#[inline]
pub(super) fn of_horizon(arc: &Arc<f64>) -> (f64, f64) {
    const U: f64 = ROUNDOFF;
    let (q, p) = (arc.start.inverse, arc.end.inverse);
    let (first, last) = (Moved::at_inverse_distance(q), Moved::at_inverse_distance(p));
    let g = arc.angle.abs();
    let dg = first.eta + last.eta + 3.5 * U + 9.0 * U * g.min(1.0) + 4.0 * U * g;
    if first.xi.max(last.xi) > MOST_DISPLACED || g + dg * SECOND_ORDER >= std::f64::consts::PI {
        return (f64::INFINITY, f64::INFINITY);
    }
    // The term's `|n1.N|` is 1.
    (dg + 5.5 * U * g, 0.5 * (first.xi * first.xi * q + last.xi * last.xi * p))
}

impl BoundedSum {
    /// The sums over the arcs of a polygon that nothing hides, and the bounds.
    #[inline]
    pub(crate) fn of_polygon(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (IrradianceAndGradient<f64>, Self) {
        edge_lanes::constant::bounded(receiver, polygon, plan).unwrap_or_else(|| Self::one_by_one(receiver, polygon, plan))
    }

    /// The case of a polygon whose visible part is sure, with the sums where its size is more than `narrow` of the distance of
    /// its farthest vertex.
    #[inline]
    pub(crate) fn where_sure(receiver: &Receiver, polygon: &Polygon, narrow: f64) -> Option<SureCase<Self>> {
        edge_lanes::constant::bounded_where_sure(receiver, polygon, narrow)
    }

    #[inline(never)]
    pub(super) fn one_by_one(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (IrradianceAndGradient<f64>, Self) {
        let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(unit_normal(receiver)));
        let n1 = unit_normal(receiver);
        let mut errors = ArcErrors::new(n1, plan.horizon == Horizon::Crossing);
        horizon::visit_boundary(receiver, polygon, plan, |arc: &Arc<f64>| {
            angles.add(arc);
            edges.add(arc);
            errors.add(arc);
        });
        let terms = IrradianceAndGradient { irradiance: angles.phi(), gradient: edges.sum() };
        let bound = errors.bound(&terms);
        (terms, bound)
    }

    /// The bounds from the errors of the terms and their sums: those of the angles are twice those of the irradiance.
    #[inline(always)]
    pub(super) fn new(terms: &IrradianceAndGradient<f64>, angles: f64, edges: f64) -> Self {
        let products = 8.0 * ROUNDOFF;
        Self {
            irradiance: SECOND_ORDER * (0.5 * angles + products * terms.irradiance.norm()),
            gradient: SECOND_ORDER * (edges + products * terms.gradient.norm()),
        }
    }
}

/// Sums of the errors and sizes of the arcs' terms.
#[derive(Debug, Clone, Copy)]
struct ArcErrors {
    n1: Vec3<f64>,
    crossing: bool,
    arcs: f64,
    angles: f64,
    angle_errors: f64,
    edges: f64,
    /// Errors of the gradient's terms along their normals, by components, and across them.
    along: Vec3<f64>,
    across: f64,
}

impl ArcErrors {
    fn new(n1: Vec3<f64>, crossing: bool) -> Self {
        Self { n1, crossing, arcs: 0.0, angles: 0.0, angle_errors: 0.0, edges: 0.0, along: Vec3::zero(), across: 0.0 }
    }

    #[inline]
    fn add(&mut self, arc: &Arc<f64>) {
        let g = arc.angle.abs();
        self.arcs += 1.0;
        self.angles += g;
        let Some(line) = arc.line() else {
            let (angle, slope) = of_horizon(arc);
            self.angle_errors += angle;
            self.across += slope;
            return;
        };
        // That of a vertex is less.
        let moved = self.crossing.then(|| Moved::at_inverse_distance(arc.start.inverse.max(arc.end.inverse)).eta);
        let of_angle = AngleError::new(g, g.min(1.0), line.relative_error(), moved);
        let ew = of_angle.ew;
        self.angle_errors += of_angle.of_term(self.n1.dot(line.normal).abs());
        let (size, error) = if arc.is_within_a_quarter_turn() {
            of_angle.of_weight(&Weighed::new(arc, [arc.start.cosine(self.n1), arc.end.cosine(self.n1)]))
        } else {
            of_angle.of_wide_weight(line.nearness())
        };
        self.edges += size;
        self.along = self.along + line.normal.map(f64::abs) * error;
        self.across += size * ew;
        if ew.max(moved.unwrap_or(0.0)) > MOST_DISPLACED || line.moment < LEAST_MOMENT {
            (self.angle_errors, self.across) = (f64::INFINITY, f64::INFINITY);
        }
    }

    fn bound(self, terms: &IrradianceAndGradient<f64>) -> BoundedSum {
        let sums = (self.arcs - 1.0) * ROUNDOFF;
        BoundedSum::new(terms, self.angle_errors + sums * self.angles, self.along.norm() + self.across + sums * self.edges)
    }
}

/// The numbers that hold bounds: doubles, one arc at a time or several on lanes.
pub(super) trait Figure:
    Copy + Add<Output = Self> + Mul<Output = Self> + Add<f64, Output = Self> + Mul<f64, Output = Self>
{
}

impl<T: Copy + Add<Output = T> + Mul<Output = T> + Add<f64, Output = T> + Mul<f64, Output = T>> Figure for T {}

/// A sum with the relative displacement of an arc's ends, so many times; with nothing where no horizon cuts.
#[inline(always)]
pub(super) fn with_displacement<T: Figure>(sum: T, eta: Option<T>, times: f64) -> T {
    match eta {
        Some(eta) => sum + eta * times,
        None => sum,
    }
}

/// The same with that times a factor.
#[inline(always)]
pub(super) fn with_product<T: Figure>(sum: T, eta: Option<T>, times: f64, factor: T) -> T {
    match eta {
        Some(eta) => sum + factor * (eta * times),
        None => sum,
    }
}

/// An arc's angle, the errors of the angle, its sine and w, and the displacement of the arc's ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct AngleError<T> {
    g: T,
    dg: T,
    ds: T,
    ew: T,
    eta: Option<T>,
}

/// The factors of the weight of an arc up to a quarter turn: `Q`, `g + sin g`, `T`, `s` and `min(g, s)`, all as sizes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighed<T> {
    near: T,
    sum: T,
    turn: T,
    cosines: T,
    least: T,
}

impl<T: Doubles> Weighed<T> {
    /// Given n1 along the directions of the ends.
    #[inline(always)]
    pub(super) fn new(arc: &Arc<T>, [c1, c2]: [T; 2]) -> Self {
        let (sum, turn) = arc.angle_and_sine();
        let cosines = c1.abs() + c2.abs();
        Self { near: arc.start.inverse + arc.end.inverse, sum, turn, cosines, least: arc.angle.abs().min(cosines) }
    }
}

impl<T: Figure> AngleError<T> {
    /// The error of the angle g, given `min(g, 1)`; eta is that of an edge that may be cut.
    #[inline(always)]
    pub(super) fn new(g: T, least: T, ew: T, eta: Option<T>) -> Self {
        const U: f64 = ROUNDOFF;
        let fraction = if eta.is_some() { units::FRACTION * U } else { 0.0 };
        let dg = with_product(least * (ew + (units::ANGLE * U + fraction)) + g * (units::ARC_TANGENT * U), eta, 2.0, least);
        let ds = with_product(g * (ew + (units::SINE * U + fraction)), eta, 2.0, g);
        Self { g, dg, ds, ew, eta }
    }

    /// Error of `n1.(g N)`, given `|n1.N|`.
    #[inline(always)]
    pub(super) fn of_term(&self, facing: T) -> T {
        const U: f64 = ROUNDOFF;
        facing * (self.dg + self.g * (units::INVERSE_MOMENT * U)) + self.g * (self.ew + units::PRODUCTS * U)
    }

    /// A bound on the size of the weight, and the error of its product with N along N.
    #[inline(always)]
    pub(super) fn of_weight(&self, weighed: &Weighed<T>) -> (T, T) {
        const U: f64 = ROUNDOFF;
        let Self { g, dg, ds, eta, .. } = *self;
        let Weighed { near, sum, turn, cosines, least } = *weighed;
        let quarter = turn * 0.25;
        let dc = with_displacement(cosines * (units::COSINES[1] * U) + units::COSINES[0] * U, eta, 4.0);
        let of_cosines = with_product(cosines * (units::CHI_TERM * U) + dc, eta, 5.0, cosines);
        let first = quarter * (cosines * (dg + ds) + sum * of_cosines);
        let second = g * with_product(dg * SLOPE_OF_PSI + g * (PSI_TERM * U) + dc * LARGEST_PSI, eta, LARGEST_PSI, g);
        let size = near * (quarter * sum * cosines + g * least * LARGEST_PSI);
        (size, near * (first + second) + size * (units::WEIGHT * U))
    }

    /// The same past a quarter turn, from one over the distance of the line.
    #[inline(always)]
    pub(super) fn of_wide_weight(&self, nearness: T) -> (T, T) {
        const U: f64 = ROUNDOFF;
        let Self { g, dg, ds, ew, eta } = *self;
        let en = ew + 5.0 * U;
        let db = with_displacement(en * 2.0 + 54.0 * U, eta, 2.0) * 0.71;
        let column = dg * 0.5 + ds + g * db * 2.0 + g * (28.0 * U);
        (g * nearness, (column + g * (en * 2.0 + 32.0 * U)) * nearness)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::{LARGEST_PSI, SLOPE_OF_PSI};

    #[test]
    fn psi_is_within_its_constants_up_to_a_quarter_turn() {
        let psi = |g: f64| (g - g.sin()) / (4.0 * (1.0 - g.cos()));
        for k in 1..=1000 {
            let g = 0.01 + (FRAC_PI_2 - 0.01) * f64::from(k) / 1000.0;
            assert!(psi(g) <= LARGEST_PSI * g, "{g}");
            assert!((psi(g) - psi(g - 1e-6)) / 1e-6 <= SLOPE_OF_PSI, "{g}");
        }
    }
}
