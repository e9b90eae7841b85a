//! The sums over arcs for a constant emission in double precision, with a bound on their errors that is derived, not run.
//!
//! u = 2^-53, first order; 0.1 % on top pays for the rest, and a relative error of w or of a crossing point above 1e-6, a
//! moment near underflow or an arc of the horizon that may have either sign, next to pi, bounds nothing. With `ew` the relative
//! error of w ([`Line::relative_error`]) and `eta` that of a crossing point (0 for a vertex, whose components err by u):
//!
//! - Lengths: `|w|` errs by `ew + 2.5u`, 1/|w| by `ew + 3.5u`, 1/|r| by `4.5u + eta`. N errs by ew across and 3.5u along itself,
//!   and u for its product.
//! - The angle is that of the point (inline, across), which err by 5u of `|r||r'|` and by `ew + 2.5u`, 7u more for the fraction
//!   of a cut edge: `dg = min(g, 1) (ew + 8u + 7u) + 2 eta + 4ug`, the last from the arc tangent.
//! - A crossing point `r + t e` errs by `u (2 |q| + 9 t |e|)`, and `t |e| <= |q| + 2 sqrt(3)` in normalised lengths: `eta = u
//!   (11 + 32/|q|)`.
//! - Of a term `g N` only `n1.(g N)` matters: with `c = |n1.N|` it errs by `c (dg + 3.5ug)` along N, by `g ew` across, and by
//!   2ug in the products.
//!
//! The gradient's weight ([`Arc::weight`]) of an arc up to a quarter turn, `chi Q (c + c') + psi (q' - q)(c' - c)`, `q = 1/|r|`,
//! `c = n1.r/|r|`, `Q = q + q'`, `T = 1/(1 + cos g)`, a number from 1/2 to 1, and `s = |c| + |c'|`:
//! - the sine errs by `ds = g (ew + 14u + 7u + 2 eta)`, the cosine by at most `5u + 11u cos + 4 eta`, so 1 + cos by `9u + 4 eta`
//!   relative; c errs by `5u + 5.5u |c| + 2 eta`, and `c + c'` or their difference by `dc = 10u + 6.5us + 4 eta`;
//! - `chi = T (g + sin g)/4`: the first term errs by `Q (T/4) [s (dg + ds) + (g + sin g) (s (19u + 5 eta) + dc)]`;
//! - `psi <= 0.091g`, `psi' <= 0.11`, psi errs by 3u of itself, `q' - q` by `(5.5u + eta) Q` and `|c' - c| <= |v - u| <= g`:
//!   the second errs by `Q g [0.11 dg + 0.8ug + 0.091 (eta g + dc)]`;
//! - the weight is at most `Q ((T/4) (g + sin g) s + 0.091g min(g, s))`; its sum and its product with N err by that times ew
//!   across N and 5.5u along it.
//!
//! Past a quarter turn the weight is `(cc p1 + cs p2)/S` in the frame of the line:
//! - 1/S errs by `ew + 8u`, `along` by 7u, `toward` by `en + 10u`, `en = ew + 5u`, and (p1, p2) by `en + 18u`;
//! - cosine and sine of an end in the frame err by `en + 26u + eta` together, so the bisector by `db = 0.71 (2 en + 54u + 2
//!   eta)`, 0.71 bounding one over the length of the longer of sum and difference of two unit vectors;
//! - the column (cc, cs) of the symmetric matrix M errs by half of `dg + ds` and half of ds, by `2 g db`, and by 28ug of
//!   rounding; the term by that and `g (2 en + 32u)` along N and by `g ew` across, over S.
//!
//! Each sum of n vectors adds `(n - 1) u` of the sum of sizes, and the products with emission, normal and reflectance 8u of the
//! result.

mod side_by_side;

use std::ops::{Add, Mul};

use crate::arc::Arc;
use crate::constant::{EdgeSum, SolidAngleVector};
use crate::four::Whole;
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
const SECOND_ORDER: f64 = 1.001;

impl BoundedSum {
    /// The sums over the arcs of a polygon that nothing hides, and the bounds.
    #[inline]
    pub(crate) fn of(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (Terms<f64>, Self) {
        let whole = match plan.horizon {
            Horizon::Above => side_by_side::bounded(receiver, polygon, plan.power),
            Horizon::Crossing => None,
        };
        whole.unwrap_or_else(|| Self::one_by_one(receiver, polygon, plan))
    }

    /// Of a polygon that is surely seen whole; the sums where its size is more than `narrow` of the distance of its farthest vertex.
    #[inline]
    pub(crate) fn whole(receiver: &Receiver, polygon: &Polygon, narrow: f64) -> Option<Whole<Self>> {
        side_by_side::bounded_whole(receiver, polygon, narrow)
    }

    #[inline(never)]
    fn one_by_one(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (Terms<f64>, Self) {
        let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(unit_normal(receiver)));
        let n1 = unit_normal(receiver);
        let mut errors = ArcErrors::new(n1, plan.horizon == Horizon::Crossing);
        horizon::visit_boundary(receiver, polygon, plan, |arc: &Arc<f64>| {
            angles.add(arc);
            edges.add(arc);
            errors.add(arc);
        });
        let terms = Terms { irradiance: angles.phi(), gradient: edges.sum() };
        let bound = errors.bound(&terms);
        (terms, bound)
    }

    /// From what the terms and their sums err by: the angles' twice what that does to the irradiance.
    #[inline(always)]
    fn new(terms: &Terms<f64>, angles: f64, edges: f64) -> Self {
        let products = 8.0 * ROUNDOFF;
        Self {
            irradiance: SECOND_ORDER * (0.5 * angles + products * length(terms.irradiance)),
            gradient: SECOND_ORDER * (edges + products * length(terms.gradient)),
        }
    }
}

#[inline(always)]
fn length(v: Vec3<f64>) -> f64 {
    v.norm_squared().sqrt()
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
        const U: f64 = ROUNDOFF;
        let moved = |end: &Sighted<f64>| U * (11.0 + 32.0 * end.inverse);
        let (eta, fraction) = if self.crossing { (moved(&arc.start).max(moved(&arc.end)), 7.0 * U) } else { (0.0, 0.0) };
        let line = arc.line();
        let of_angle =
            AngleError::new(arc.angle.abs(), arc.angle.abs().min(1.0), line.map_or(0.0, Line::relative_error), eta, fraction);
        let AngleError { g, dg, ew, .. } = of_angle;
        self.arcs += 1.0;
        self.angles += g;
        self.angle_errors += of_angle.of_term(self.n1.dot(arc.generator.normal()).abs());
        let Some(line) = line else {
            if g + dg * SECOND_ORDER >= std::f64::consts::PI {
                self.angle_errors = f64::INFINITY;
            }
            return;
        };
        let (size, error) = if arc.is_within_a_quarter_turn() {
            let (sum, turn) = arc.angle_and_sine();
            let [c1, c2] = [&arc.start, &arc.end].map(|end| (self.n1.dot(end.point) * end.inverse).abs());
            let near = arc.start.inverse + arc.end.inverse;
            of_angle.of_weight(&Weighed { near, sum, turn, cosines: c1 + c2, least: g.min(c1 + c2) })
        } else {
            let en = ew + 5.0 * U;
            let db = 0.71 * (2.0 * en + 54.0 * U + 2.0 * eta);
            let column = 0.5 * dg + of_angle.ds + 2.0 * g * db + 28.0 * U * g;
            (g * line.nearness(), (column + g * (2.0 * en + 32.0 * U)) * line.nearness())
        };
        self.edges += size;
        self.along = self.along + line.normal.map(f64::abs) * error;
        self.across += size * ew;
        if ew.max(eta) > 1e-6 || line.moment < 1e-100 {
            (self.angle_errors, self.across) = (f64::INFINITY, f64::INFINITY);
        }
    }

    fn bound(self, terms: &Terms<f64>) -> BoundedSum {
        let sums = (self.arcs - 1.0) * ROUNDOFF;
        BoundedSum::new(terms, self.angle_errors + sums * self.angles, length(self.along) + self.across + sums * self.edges)
    }
}

/// What bounds are kept in: doubles, one arc at a time or several on lanes.
trait Figure: Copy + Add<Output = Self> + Mul<Output = Self> + Add<f64, Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = T> + Mul<Output = T> + Add<f64, Output = T> + Mul<f64, Output = T>> Figure for T {}

/// An arc's angle and what it, its sine and w err by; eta and the error of a fraction are 0 but for cut edges.
#[derive(Debug, Clone, Copy)]
struct AngleError<T> {
    g: T,
    dg: T,
    ds: T,
    ew: T,
    eta: f64,
}

/// What the weight of an arc up to a quarter turn is made of: `Q`, `g + sin g`, `T`, `s` and `min(g, s)`, all as sizes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighed<T> {
    pub(super) near: T,
    pub(super) sum: T,
    pub(super) turn: T,
    pub(super) cosines: T,
    pub(super) least: T,
}

impl<T: Figure> AngleError<T> {
    /// Of the angle g, given `min(g, 1)`.
    #[inline(always)]
    fn new(g: T, least: T, ew: T, eta: f64, fraction: f64) -> Self {
        const U: f64 = ROUNDOFF;
        let dg = least * (ew + (8.0 * U + fraction)) + g * (4.0 * U) + 2.0 * eta;
        Self { g, dg, ds: g * (ew + (14.0 * U + fraction + 2.0 * eta)), ew, eta }
    }

    /// What `n1.(g N)` errs by, given `|n1.N|`.
    #[inline(always)]
    fn of_term(&self, facing: T) -> T {
        const U: f64 = ROUNDOFF;
        facing * (self.dg + self.g * (3.5 * U)) + self.g * (self.ew + 2.0 * U)
    }

    /// A bound on the size of the weight, and on what its product with N errs by along N.
    #[inline(always)]
    fn of_weight(&self, weighed: &Weighed<T>) -> (T, T) {
        const U: f64 = ROUNDOFF;
        let Self { g, dg, ds, eta, .. } = *self;
        let Weighed { near, sum, turn, cosines, least } = *weighed;
        let quarter = turn * 0.25;
        let dc = cosines * (6.5 * U) + (10.0 * U + 4.0 * eta);
        let first = quarter * (cosines * (dg + ds) + sum * (cosines * (19.0 * U + 5.0 * eta) + dc));
        let second = g * (dg * 0.11 + g * (0.8 * U + 0.091 * eta) + dc * 0.091);
        let size = near * (quarter * sum * cosines + g * least * 0.091);
        (size, near * (first + second) + size * (5.5 * U))
    }
}
