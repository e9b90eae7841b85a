//! The sums over arcs for a constant emission in double precision, with a bound on their errors that is derived, not run.
//!
//! u = 2^-53, first order; 5 % on top pays for the rest, and a relative error of w above 1e-6, a moment near underflow or an arc
//! of the horizon that may have either sign, next to pi, bounds nothing. With `ew` the relative error of w
//! ([`Line::relative_error`]) and `eta` that of a crossing point (0 for a vertex, whose components err by u):
//!
//! - Lengths: `|w|` errs by `ew + 2.5u`, 1/|w| by `ew + 3.5u`, 1/|r| by `4.5u + eta`. N errs by ew across and 3.5u along itself,
//!   and u for its product.
//! - The angle is that of the point (inline, across), which err by 5u of `|r||r'|` and by `ew + 2.5u`, 7u more for the fraction
//!   of a cut edge: `dg = min(g, 1) (ew + 8u + 7u) + 2 eta + 4ug`, the last from the arc tangent.
//! - A crossing point `r + t e` errs by `u (2 |q| + 9 t |e|)`, and `t |e| <= |q| + 2 sqrt(3)` in normalised lengths: `eta = u (11 +
//!   32/|q|)`.
//! - A term `g N` errs by `dg + 3.5ug` along N and by `g ew` across: in all by `dg + g (k ew + 5.5u)`, with k = 0.42 where the first
//!   is the larger, g <= 1, and 1 elsewhere.
//!
//! The gradient's weight ([`Arc::weight`]) of an arc up to a quarter turn, `chi Q (c + c') + psi (q' - q)(c' - c)`, `q = 1/|r|`,
//! `c = n1.r/|r|`, `Q = q + q'`:
//! - the sine errs by `ds = g (ew + 14u + 7u + 2 eta)`, the cosine by at most `5u + 11u cos + 4 eta`, so 1 + cos by `9u + 4 eta`
//!   relative; c errs by `10.5u + 2 eta`, and `c + c'` or their difference by `23u + 4 eta`;
//! - `chi |u + v| <= 0.58g`, `chi <= 0.41g`, `1/|u + v| <= 0.71`: the first term errs by `Q [0.36 (dg + ds) + 0.58g (22u + 5 eta) +
//!   0.41g (23u + 4 eta)]`;
//! - `psi <= 0.091g` and `|v - u| <= 1.42 min(g, 1)`: the second by `Q [min(g, 1) (0.55 (dg + ds) + 5ug) + 0.091g (23u + 4 eta)]`;
//! - together, with their sum, `Q [(0.36 + 0.55 min(g, 1)) (dg + ds) + g (25u + 6 eta) + 5ug min(g, 1)]`. The weight is at most
//!   `0.71gQ`, and its product with N errs by that times `ew + 5.5u + u`.
//!
//! Past a quarter turn the weight is `(cc p1 + cs p2)/S` in the frame of the line:
//! - 1/S errs by `ew + 8u`, `along` by 7u, `toward` by `en + 10u`, `en = ew + 5u`, and (p1, p2) by `en + 18u`;
//! - cosine and sine of an end in the frame err by `en + 26u + eta` together, so the bisector by `db = 0.71 (2 en + 54u + 2 eta)`,
//!   0.71 bounding one over the length of the longer of sum and difference of two unit vectors;
//! - the column (cc, cs) of the symmetric matrix M errs by half of `dg + ds` and half of ds, by `2 g db`, and by 28ug of rounding;
//!   the term by that and `g (2 en + ew + 32u)`, over S.
//!
//! Each sum of n vectors adds `(n - 1) u` of the sum of sizes, and the products with emission, normal and reflectance 8u of the
//! result.

use crate::arc::Arc;
use crate::constant::{EdgeSum, SolidAngleVector};
use crate::line::{Line, Sighted};
use crate::number::ROUNDOFF;
use crate::plan::{Horizon, Plan, unit_normal};
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Polygon, Receiver, horizon};

/// Bounds on the errors of the sums for a unit emission.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundedSum {
    /// Bound on the error of `n1.Phi`.
    pub(crate) irradiance: f64,
    /// Bound on the norm of the error of the gradient's sum.
    pub(crate) gradient: f64,
}

/// Pays for terms of second order in the errors.
const SECOND_ORDER: f64 = 1.05;

impl BoundedSum {
    /// The sums over the arcs of a polygon that nothing hides, and the bounds.
    pub(crate) fn of(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (Terms<f64>, Self) {
        let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(unit_normal(receiver)));
        let mut errors = ArcErrors { crossing: plan.horizon == Horizon::Crossing, ..ArcErrors::default() };
        horizon::visit_boundary(receiver, polygon, plan, |arc: &Arc<f64>| {
            angles.add(arc);
            edges.add(arc);
            errors.add(arc);
        });
        let terms = Terms { irradiance: angles.phi(), gradient: edges.sum() };
        let bound = errors.bound(&terms);
        (terms, bound)
    }
}

/// Sums of the errors and sizes of the arcs' terms.
#[derive(Debug, Clone, Copy, Default)]
struct ArcErrors {
    crossing: bool,
    arcs: f64,
    angles: f64,
    angle_errors: f64,
    edges: f64,
    edge_errors: f64,
}

impl ArcErrors {
    #[inline]
    fn add(&mut self, arc: &Arc<f64>) {
        const U: f64 = ROUNDOFF;
        let moved = |end: &Sighted<f64>| U * (11.0 + 32.0 * end.inverse);
        let (eta, fraction) = if self.crossing { (moved(&arc.start).max(moved(&arc.end)), 7.0 * U) } else { (0.0, 0.0) };
        let (g, line) = (arc.angle.abs(), arc.line());
        let least = g.min(1.0);
        let ew = line.map_or(0.0, Line::relative_error);
        let dg = least * (ew + 8.0 * U + fraction) + 2.0 * eta + 4.0 * U * g;
        let across = if g <= 1.0 { 0.42 } else { 1.0 };
        self.arcs += 1.0;
        self.angles += g;
        self.angle_errors += dg + g * (across * ew + 5.5 * U);
        let Some(line) = line else {
            if g + dg * SECOND_ORDER >= std::f64::consts::PI {
                self.angle_errors = f64::INFINITY;
            }
            return;
        };
        let ds = g * (ew + 14.0 * U + fraction + 2.0 * eta);
        let (size, error) = if arc.is_within_a_quarter_turn() {
            let size = 0.71 * g * (arc.start.inverse + arc.end.inverse);
            let weight = (0.36 + 0.55 * least) * (dg + ds) + g * (25.0 * U + 6.0 * eta) + 5.0 * U * g * least;
            (size, weight * (arc.start.inverse + arc.end.inverse) + size * (ew + 6.5 * U))
        } else {
            let en = ew + 5.0 * U;
            let db = 0.71 * (2.0 * en + 54.0 * U + 2.0 * eta);
            let column = 0.5 * dg + ds + 2.0 * g * db + 28.0 * U * g;
            (g * line.nearness(), (column + g * (2.0 * en + ew + 32.0 * U)) * line.nearness())
        };
        self.edges += size;
        self.edge_errors += error;
        if ew > 1e-6 || line.moment < 1e-100 {
            (self.angle_errors, self.edge_errors) = (f64::INFINITY, f64::INFINITY);
        }
    }

    fn bound(self, terms: &Terms<f64>) -> BoundedSum {
        let (sums, products) = ((self.arcs - 1.0) * ROUNDOFF, 8.0 * ROUNDOFF);
        let length = |v: Vec3<f64>| v.norm_squared().sqrt();
        BoundedSum {
            irradiance: SECOND_ORDER * (0.5 * (self.angle_errors + sums * self.angles) + products * length(terms.irradiance)),
            gradient: SECOND_ORDER * (self.edge_errors + sums * self.edges + products * length(terms.gradient)),
        }
    }
}
