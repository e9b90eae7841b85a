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
//! - The sine errs by `ds = g (ew + 14u + u + 2 eta)`: |w| by `ew + 2.5u`, the two q by 4.5u each, two products by 2u; and u for
//!   a cut edge's fraction.
//! - The cosine errs by at most `5u + 11u cos + 4 eta`: inline by `5u + 2 eta`, the two q by `9u + 2 eta`, two products by 2u.
//! - So `1 + cos` errs by `9u + 4 eta` relative: `(5 + 11 cos)/(1 + cos)` is at most 8, and its rounding 1.
//! - `c + c'` and their difference err by `dc = 10u + 6.5us + 4 eta`: twice the table's, and the rounding of the sum.
//! - The first term errs by `Q (T/4) [s (dg + ds) + (g + sin g) (s (19u + 5 eta) + dc)]`. The 19u are 9 of `1 + cos`, 4.5 of Q, 5
//!   of two sums, a quotient and two products, and 0.5 to spare.
//! - `psi <= 0.091g` and `psi' <= 0.11`: `psi/g` and psi' rise up to a right angle, where they are 0.0909 and 0.1074.
//! - psi errs by 3u relative, `q' - q` by `(5.5u + eta) Q`, two products by 2u; and `|c' - c|` is at most s, and g, since it is
//!   at most `|v - u|` for the directions u and v of the ends. So the second term errs by
//!   `Q g [0.11 dg + 0.091 (eta g + dc)] + 10.5u psi Q min(g, s)`.
//! - Of the last, `0.8u g^2 Q` is counted there. The rest is less than the 0.5 to spare: `10.5 psi/g - 0.8 <= (T/8)(1 + sin g/g)`
//!   (a test looks).
//! - The weight is at most `Q ((T/4) (g + sin g) s + 0.091g min(g, s))`. Its sum and its product with N err by that times ew
//!   across N and 5.5u along it: 3.5u of N, and the rounding of the sum and of the product.
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

use std::ops::{Add, Mul};

use crate::boundary::arc::Arc;
use crate::boundary::horizon;
#[cfg(doc)]
use crate::boundary::line::Line;
use crate::boundary::line::Sighted;
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::edge_lanes;
use crate::forms::edge_lanes::SureCase;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};
use crate::scalar::arithmetic::Doubles;
use crate::scalar::number::ROUNDOFF;
use crate::scalar::vec3::Vec3;

/// Bounds on the errors of the sums for a unit emission.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundedSum {
    /// Bound on the error of `n1.Phi`.
    pub(crate) irradiance: f64,
    /// Bound on the norm of the error of the gradient's sum.
    pub(crate) gradient: f64,
}

/// Pays for terms of second order in the errors.
const SECOND_ORDER: f64 = 1.001;

/// The relative error that the fraction of a cut edge adds to its cross product.
const FRACTION: f64 = ROUNDOFF;

/// Errors of w and of crossing points above which nothing is bounded, and moments below which.
const MOST_DISPLACED: f64 = 1e-6;
pub(super) const LEAST_MOMENT: f64 = 1e-100;

/// Relative displacement of a crossing point: along its edge, and otherwise.
#[derive(Debug, Clone, Copy)]
struct Moved {
    xi: f64,
    eta: f64,
}

impl Moved {
    /// Of a point at one over a distance.
    #[inline(always)]
    fn at(inverse: f64) -> Self {
        Self {
            xi: mutant!("constant-bound.along-the-edge", ROUNDOFF * (4.1 + 13.9 * inverse), |xi| 0.1 * xi),
            eta: mutant!("constant-bound.across-the-edge", ROUNDOFF * (3.0 + 10.4 * inverse), |eta| 0.1 * eta),
        }
    }
}

/// An arc of the horizon's part in the errors of the angles and of the gradient.
#[inline]
pub(super) fn of_horizon(arc: &Arc<f64>) -> (f64, f64) {
    const U: f64 = ROUNDOFF;
    let (q, p) = (arc.start.inverse, arc.end.inverse);
    let (first, last) = (Moved::at(q), Moved::at(p));
    let g = arc.angle.abs();
    let dg =
        mutant!("constant-bound.horizon-angle", first.eta + last.eta + 3.5 * U + 9.0 * U * g.min(1.0) + 4.0 * U * g, |dg| 0.1
            * dg);
    if first.xi.max(last.xi) > MOST_DISPLACED || g + dg * SECOND_ORDER >= std::f64::consts::PI {
        return (f64::INFINITY, f64::INFINITY);
    }
    let light =
        mutant!("constant-bound.horizon-light", first.xi * first.xi * first.xi + last.xi * last.xi * last.xi, |light| 0.0
            * light);
    // The term's `|n1.N|` is 1.
    (
        dg + 5.5 * U * g + light,
        mutant!("constant-bound.horizon-slope", 0.5 * (first.xi * first.xi * q + last.xi * last.xi * p), |slope| 0.1 * slope),
    )
}

impl BoundedSum {
    /// The sums over the arcs of a polygon that nothing hides, and the bounds.
    #[inline]
    pub(crate) fn of(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (IrradianceAndGradient<f64>, Self) {
        edge_lanes::constant::bounded(receiver, polygon, plan).unwrap_or_else(|| Self::one_by_one(receiver, polygon, plan))
    }

    /// Of a polygon whose visible part is sure; the sums where its size is more than `narrow` of the distance of its farthest
    /// vertex.
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

    /// From the errors of the terms and their sums: those of the angles are twice those of the irradiance.
    #[inline(always)]
    pub(super) fn new(terms: &IrradianceAndGradient<f64>, angles: f64, edges: f64) -> Self {
        let products = mutant!("constant-bound.products", 8.0 * ROUNDOFF, |products| 0.1 * products);
        Self {
            irradiance: mutant!(
                "constant-bound.irradiance",
                SECOND_ORDER * (0.5 * angles + products * terms.irradiance.norm()),
                |bound| 0.1 * bound
            ),
            gradient: mutant!("constant-bound.gradient", SECOND_ORDER * (edges + products * terms.gradient.norm()), |bound| 0.1
                * bound),
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
    /// Of the gradient's terms along their normals, by components, and across them.
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
        let moved = self.crossing.then(|| Moved::at(arc.start.inverse.max(arc.end.inverse)).eta);
        let of_angle = AngleError::new(g, g.min(1.0), line.relative_error(), moved);
        let ew = of_angle.ew;
        self.angle_errors += of_angle.of_term(self.n1.dot(line.normal).abs());
        let (size, error) = if arc.is_within_a_quarter_turn() {
            let cosine = |end: &Sighted<f64>| self.n1.dot(end.point) * end.inverse;
            of_angle.of_weight(&Weighed::new(arc, [cosine(&arc.start), cosine(&arc.end)]))
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
fn with_displacement<T: Figure>(sum: T, eta: Option<T>, times: f64) -> T {
    match eta {
        Some(eta) => sum + eta * times,
        None => sum,
    }
}

/// The same with that times a factor.
#[inline(always)]
fn with_product<T: Figure>(sum: T, eta: Option<T>, times: f64, factor: T) -> T {
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
    /// Of the angle g, given `min(g, 1)`; eta of an edge that may be cut.
    #[inline(always)]
    pub(super) fn new(g: T, least: T, ew: T, eta: Option<T>) -> Self {
        const U: f64 = ROUNDOFF;
        let fraction = if eta.is_some() { FRACTION } else { 0.0 };
        let dg = mutant!(
            "constant-bound.angle",
            with_product(least * (ew + (8.0 * U + fraction)) + g * (4.0 * U), eta, 2.0, least),
            |dg| dg * 0.1
        );
        let ds = mutant!("constant-bound.sine", with_product(g * (ew + (14.0 * U + fraction)), eta, 2.0, g), |ds| ds * 0.1);
        Self { g, dg, ds, ew, eta }
    }

    /// Error of `n1.(g N)`, given `|n1.N|`.
    #[inline(always)]
    pub(super) fn of_term(&self, facing: T) -> T {
        const U: f64 = ROUNDOFF;
        mutant!("constant-bound.term", facing * (self.dg + self.g * (3.5 * U)) + self.g * (self.ew + 2.0 * U), |error| error
            * 0.1)
    }

    /// A bound on the size of the weight, and the error of its product with N along N.
    #[inline(always)]
    pub(super) fn of_weight(&self, weighed: &Weighed<T>) -> (T, T) {
        const U: f64 = ROUNDOFF;
        let Self { g, dg, ds, eta, .. } = *self;
        let Weighed { near, sum, turn, cosines, least } = *weighed;
        let quarter = turn * 0.25;
        let dc = mutant!("constant-bound.cosines", with_displacement(cosines * (6.5 * U) + 10.0 * U, eta, 4.0), |dc| dc * 0.1);
        let of_cosines = with_product(cosines * (19.0 * U) + dc, eta, 5.0, cosines);
        let first = mutant!("constant-bound.chi", quarter * (cosines * (dg + ds) + sum * of_cosines), |first| first * 0.1);
        let second = mutant!(
            "constant-bound.psi",
            g * with_product(dg * 0.11 + g * (0.8 * U) + dc * 0.091, eta, 0.091, g),
            |second| second * 0.1
        );
        let size = near * (quarter * sum * cosines + g * least * 0.091);
        (size, near * (first + second) + mutant!("constant-bound.weight-size", size * (5.5 * U), |error| error * 0.1))
    }

    /// The same past a quarter turn, from one over the distance of the line.
    #[inline(always)]
    pub(super) fn of_wide_weight(&self, nearness: T) -> (T, T) {
        const U: f64 = ROUNDOFF;
        let Self { g, dg, ds, ew, eta } = *self;
        let en = ew + 5.0 * U;
        let db = mutant!("constant-bound.bisector", with_displacement(en * 2.0 + 54.0 * U, eta, 2.0) * 0.71, |db| db * 0.1);
        let column = dg * 0.5 + ds + g * db * 2.0 + g * (28.0 * U);
        (g * nearness, mutant!("constant-bound.wide", (column + g * (en * 2.0 + 32.0 * U)) * nearness, |error| error * 0.1))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    /// `psi/g <= 0.091`, `psi' <= 0.11`, `(5 + 11 cos)/(1 + cos) <= 8`, and the roundings that the half unit to spare pays for.
    #[test]
    fn the_constants_of_a_weight_up_to_a_quarter_turn_hold() {
        let psi = |g: f64| (g - g.sin()) / (4.0 * (1.0 - g.cos()));
        let mut spare = f64::INFINITY;
        for k in 1..=1000 {
            let g = 0.01 + (FRAC_PI_2 - 0.01) * f64::from(k) / 1000.0;
            let turn = 1.0 / (1.0 + g.cos());
            assert!(psi(g) <= 0.091 * g, "{g}");
            assert!((psi(g) - psi(g - 1e-6)) / 1e-6 <= 0.11, "{g}");
            assert!((5.0 + 11.0 * g.cos()) * turn <= 8.0, "{g}");
            spare = spare.min(turn / 8.0 * (1.0 + g.sin() / g) - (10.5 * psi(g) / g - 0.8));
        }
        assert!(spare > 0.04, "{spare}");
    }
}
