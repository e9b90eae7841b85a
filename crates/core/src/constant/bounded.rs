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
//! - Of a term `g N` only `n1.(g N)` matters: with `c = |n1.N|` it errs by `c (dg + 3.5ug)` along N, by `g ew` across, and by 2ug in
//!   the products.
//!
//! The gradient's weight ([`Arc::weight`]) of an arc up to a quarter turn, `chi Q (c + c') + psi (q' - q)(c' - c)`, `q = 1/|r|`,
//! `c = n1.r/|r|`, `Q = q + q'`, `T = 1/(1 + cos g)`, a number from 1/2 to 1:
//! - the sine errs by `ds = g (ew + 14u + 7u + 2 eta)`, the cosine by at most `5u + 11u cos + 4 eta`, so 1 + cos by `9u + 4 eta`
//!   relative; c errs by `10.5u + 2 eta`, and `c + c'` or their difference by `23u + 4 eta`;
//! - `chi = T (g + sin g)/4`, `1/2|u + v| = (T/8)^(1/2) <= a = 1/8 + T/4` and `|c + c'| <= |u + v|`: the first term errs by `Q [a (dg +
//!   ds) + (g + sin g) (a (19u + 5 eta) + (T/4) (23u + 4 eta))]`;
//! - `psi <= 0.091g`, `psi' <= 0.11`, psi errs by 3u of itself and `|c' - c| <= |v - u| <= g`: the second errs by `Q g [0.11 dg +
//!   0.3ug + 0.091 (23u + 4 eta)]`;
//! - the sum adds u. The weight is at most `Q (a + 0.13 min(g, 1)) (g + sin g)`, and its product with N errs by that times `ew +
//!   5.5u + u`.
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
        let n1 = unit_normal(receiver);
        let mut errors = ArcErrors { n1, crossing: plan.horizon == Horizon::Crossing, ..ArcErrors::default() };
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
    n1: Vec3<f64>,
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
        self.arcs += 1.0;
        self.angles += g;
        let facing = self.n1.dot(arc.generator.normal()).abs();
        self.angle_errors += facing * (dg + 3.5 * U * g) + g * (ew + 2.0 * U);
        let Some(line) = line else {
            if g + dg * SECOND_ORDER >= std::f64::consts::PI {
                self.angle_errors = f64::INFINITY;
            }
            return;
        };
        let ds = g * (ew + 14.0 * U + fraction + 2.0 * eta);
        let (size, error) = if arc.is_within_a_quarter_turn() {
            let near = arc.start.inverse + arc.end.inverse;
            let (sum, turn) = arc.angle_and_sine();
            let half = 0.125 + 0.25 * turn;
            let first = half * (dg + ds) + sum * (half * (19.0 * U + 5.0 * eta) + 0.25 * turn * (23.0 * U + 4.0 * eta));
            let second = g * (0.11 * dg + 0.3 * U * g);
            let size = near * (half + 0.13 * least) * sum;
            let weight = near * (first + second + 0.091 * g * (23.0 * U + 4.0 * eta));
            (size, weight + size * (ew + 7.5 * U))
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
