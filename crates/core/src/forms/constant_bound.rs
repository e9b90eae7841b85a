//! The sums over arcs for a constant emission in double precision, with a bound on their errors that is derived, not run.
//!
//! To first order in the unit roundoff u = 2^-53; [`SECOND_ORDER`] pays for the rest. There is no bound where w or a crossing point
//! errs by more than 1e-6 relative, next to underflow of a moment, or where an arc of the horizon next to pi may have either sign.
//!
//! # Symbols
//! | symbol | meaning | error |
//! |---|---|---|
//! | r, e | offset of an arc's end from the receiver, and its edge | u of each component of r |
//! | w, N | moment `r x e` and its direction | `ew` relative ([`Line::relative_error`]) |
//! | p, t | the point `r + t e` where the horizon crosses an edge | t by 4u relative |
//! | xi, eta | errors of p relative to its distance: along the edge, and otherwise; eta is 0 for a vertex | |
//! | g | angle of an arc, that of the point (inline, across) | `dg` |
//! | q, q' | one over the distances of the ends, and `Q = q + q'` | `4.5u + eta` relative |
//! | c, c' | `n1.r/r` of the ends, and s the sum of their sizes | `5u`, 5.5u of its size, and `2 eta` |
//! | T | `1/(1 + cos g)`, from 1/2 to 1 | |
//! | chi, psi | `T (g + sin g)/4` and `(g - sin g)/4(1 - cos g)` | |
//!
//! # Points and angles
//! - `|w|` errs by `ew + 2.5u`, 1/|w| by `ew + 3.5u`, relative. N errs by ew across and 3.5u along itself, and u for its product.
//! - p errs by `4u t|e|` along the edge, and beside that by `u (|r| + 2 t|e| + |p|)`. As `t|e| <= |p| + |r|`, these are at most
//!   `4u (|p| + |r|)` and `u (3|p| + 3|r|)`. With `|r| <= 12^(1/2) = 3.4642` in normalised lengths, over |p|:
//!   `xi = u (4.1 + 13.9/|p|)` and `eta = u (3 + 10.4/|p|)`.
//! - xi counts for nothing in first order: the edge's arc and the horizon's end at the same point. The light between p and the true
//!   horizon, from a region at most xi wide and high, is below `xi^3/2`. As `|n1.r| <= xi |p|` along that piece of the edge, the
//!   gradient changes by `xi^2/2|p|`.
//! - (inline, across) err by `5u + eta` of `|r||r'|` and by `ew + 2.5u`, u more for the fraction of a cut edge:
//!   `dg = min(g, 1) (ew + 8u + u + 2 eta) + 4ug`, the last from the arc tangent.
//! - An arc of the horizon has eta of its ends, 3.5u of the cross product, and 9u min(g, 1) of its product with n1 and of inline:
//!   `dg = eta + eta' + 3.5u + 9u min(g, 1) + 4ug`.
//! - Of a term `g N` only `n1.(g N)` matters: with `f = |n1.N|` it errs by `f (dg + 3.5ug)` along N, by `g ew` across, and by
//!   2ug in the products.
//!
//! # Weights up to a quarter turn
//! The gradient's weight ([`Arc::weight`]) is `chi Q (c + c') + psi (q' - q)(c' - c)`, `chi = T (g + sin g)/4`.
//! - The sine errs by `ds = g (ew + 14u + u + 2 eta)`, the cosine by at most `5u + 11u cos + 4 eta`: 1 + cos by `9u + 4 eta`
//!   relative.
//! - `c + c'` and their difference err by `dc = 10u + 6.5us + 4 eta`.
//! - The first term errs by `Q (T/4) [s (dg + ds) + (g + sin g) (s (19u + 5 eta) + dc)]`.
//! - `psi <= 0.091g`, `psi' <= 0.11`, and psi errs by 3u relative; `q' - q` errs by `(5.5u + eta) Q`, and `|c' - c| <= |v - u| <=
//!   g` for the directions u and v of the ends; `psi |c' - c| <= g^2/12`, as `2 psi sin(g/2)/g^2` decreases. So the second term errs by `Q g [0.11 dg + 0.9ug + 0.091 (eta g + dc)]`.
//! - The weight is at most `Q ((T/4) (g + sin g) s + 0.091g min(g, s))`. Its sum and its product with N err by that times ew across
//!   N and 6.5u along it.
//!
//! # Weights past a quarter turn
//! The weight is `(cc p1 + cs p2)/S` in the frame of the line at distance S, (p1, p2) being n1 there.
//! - 1/S errs by `ew + 8u`, `along` by 7u, `toward` by `en + 10u`, `en = ew + 5u`, and (p1, p2) by `en + 18u`.
//! - Cosine and sine of an end in the frame err by `en + 26u + eta` together, so the bisector by `db = 0.71 (2 en + 54u + 2 eta)`:
//!   the longer of sum and difference of two unit vectors has at least the length `1/0.71`.
//! - The column (cc, cs) of the symmetric matrix M errs by half of `dg + ds` and half of ds, by `2 g db`, and by 28ug of rounding.
//! - The term errs by that and `g (2 en + 32u)` along N, and by `g ew` across, over S.
//!
//! # Totals
//! Each sum of n vectors adds `(n - 1) u` of the sum of sizes. The products with emission, normal and reflectance add 8u of the
//! result.

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
    let light = first.xi * first.xi * first.xi + last.xi * last.xi * last.xi;
    // The term's `|n1.N|` is 1.
    (dg + 5.5 * U * g + light, 0.5 * (first.xi * first.xi * q + last.xi * last.xi * p))
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
