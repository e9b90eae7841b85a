//! Constant emission (HS95 Eq. 8 and A.1): sums over the arcs of the visible boundary.
//!
//! - Irradiance vector of a unit emission, `Phi = int omega domega = -1/2 sum g N`; the radiosity is `(rho B/pi) n1.Phi`. Exact
//!   in the arc's angle and normal, so each term errs by a few roundings; the sum cancels when the emitter is small, grazing or
//!   far, by about `|terms|/|sum|`, D/s at distance D for size s.
//! - Gradient: `(rho B/pi) sum e x (M n1) / |w|`, which in the frame of the generating line is `-(rho B/pi) sum (N/S) (cc p1 +
//!   cs p2)`, with S the distance of the line, `p1 = n1.toward`, `p2 = n1.along` and the moments of the arc. The horizon has no
//!   line and adds nothing: its points have no projected area. Cancels like the value.
//!
//! # Bound
//! [`BoundedSum`] adds up, arc by arc, what double precision may have done: u = 2^-53, first order; 5 % on top pays for the
//! rest, and a relative error of w above 1e-6, a moment near underflow or an arc of the horizon that may have either sign, next
//! to pi, bounds nothing. With `ew` the relative error of w ([`Line::relative_error`]) and `eta` that of a crossing point (0
//! for a vertex):
//! - N errs by `en = ew + 5u`, the distance S by `ew + 6u`, `toward` by `en + 8u`, `along` by 5u, and (p1, p2) by `en + 15u`;
//! - the angle is that of the point (inline, across), which err by 5u and `ew + 5u` (6u more for the fraction of a cut edge):
//!   `dg = min(g, 1) (ew + 10u + 6u) + 2 eta + 4ug`, 4u of it from atan2; the sine errs by `g (ew + 11u)`;
//! - cosine and sine of an end in the frame err by `en + 21u + eta` together, so the bisector by `db = q (2 en + 44u + 2 eta)`,
//!   where `q = 0.5 + 0.21 min(g, 1)` bounds one over the length of the longer of sum and difference of two unit vectors;
//! - the column (cc, cs) of the symmetric matrix M errs by half of `dg + dsine` and half of dsine, by `2 g db`, and by 28ug of
//!   rounding;
//! - a crossing point `r + t e` errs by `u (2 |q| + 9 t |e|)`, and `t |e| <= |q| + 2 sqrt(3)` in normalised lengths: `eta = u
//!   (11 + 32/|q|)`.
//!
//! A term of Phi errs by `(dg + g (en + 2u))/2`, one of the gradient by that column's error and `g (2 en + ew + 27u)`, over S;
//! each sum of n adds `nu` of the sum of sizes, and the products with emission, normal and reflectance 12u.

use crate::arc::{Arc, Line};
use crate::number::ROUNDOFF;
use crate::plan::{Horizon, Plan, unit_normal};
use crate::real::Real;
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Polygon, Receiver, horizon};

/// `sum g N`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SolidAngleVector<T>(Vec3<T>);

impl<T: Real> SolidAngleVector<T> {
    pub(crate) fn zero() -> Self {
        Self(Vec3::zero())
    }

    #[inline]
    pub(crate) fn add(&mut self, arc: &Arc<T>) {
        self.0 = self.0 + arc.generator.normal() * arc.angle;
    }

    /// `Phi`.
    #[inline]
    pub(crate) fn phi(self) -> Vec3<T> {
        self.0 * T::exact(-0.5)
    }
}

/// The gradient's sum, `sum e x (M n1) / |w|`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EdgeSum<T> {
    n1: Vec3<T>,
    sum: Vec3<T>,
}

impl<T: Real> EdgeSum<T> {
    pub(crate) fn new(n1: Vec3<T>) -> Self {
        Self { n1, sum: Vec3::zero() }
    }

    #[inline]
    pub(crate) fn add(&mut self, arc: &Arc<T>) {
        let Some(line) = arc.line() else { return };
        let frame = line.frame();
        let m = arc.moments(&frame);
        let along_toward = m.cc * self.n1.dot(frame.toward) + m.cs * self.n1.dot(frame.along);
        self.sum = self.sum - frame.normal * (along_toward / frame.distance);
    }

    #[inline]
    pub(crate) fn sum(self) -> Vec3<T> {
        self.sum
    }
}

/// The sums for a unit emission in double precision, with a bound on their errors.
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
    pub(crate) fn of(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> (Terms<f64>, Self) {
        let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(unit_normal(receiver)));
        let mut errors = ArcErrors { crossing: plan.horizon == Horizon::Crossing, ..ArcErrors::default() };
        horizon::visit_boundary(receiver, polygon, plan, |arc: &Arc<f64>| {
            angles.add(arc);
            edges.add(arc);
            errors.add(arc);
        });
        (Terms { irradiance: angles.phi(), gradient: edges.sum() }, errors.bound())
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
        let moved = |point: Vec3<f64>| U * (11.0 + 32.0 / point.norm_squared().sqrt());
        let eta = if self.crossing { moved(arc.start).max(moved(arc.end)) } else { 0.0 };
        let g = arc.angle.abs();
        let line = arc.line();
        let ew = line.map_or(0.0, Line::relative_error);
        let en = ew + 5.0 * U;
        let fraction = if self.crossing { 6.0 * U } else { 0.0 };
        let dg = g.min(1.0) * (ew + 10.0 * U + fraction) + 2.0 * eta + 4.0 * U * g;
        self.arcs += 1.0;
        self.angles += g;
        self.angle_errors += dg + g * (en + 2.0 * U);
        if let Some(line) = line {
            let nearness = line.e.norm_squared().sqrt() / line.moment;
            let dsine = g * (ew + 11.0 * U + fraction);
            let db = (0.5 + 0.21 * g.min(1.0)) * (2.0 * en + 44.0 * U + 2.0 * eta);
            let column = 0.5 * dg + dsine + 2.0 * g * db + 28.0 * U * g;
            self.edges += g * nearness;
            self.edge_errors += nearness * (column + g * (2.0 * en + ew + 27.0 * U));
            if ew > 1e-6 || line.moment < 1e-100 {
                (self.angle_errors, self.edge_errors) = (f64::INFINITY, f64::INFINITY);
            }
        } else if g + dg * SECOND_ORDER >= std::f64::consts::PI {
            self.angle_errors = f64::INFINITY;
        }
    }

    fn bound(self) -> BoundedSum {
        let sums = (self.arcs + 12.0) * ROUNDOFF;
        BoundedSum {
            irradiance: 0.5 * SECOND_ORDER * (self.angle_errors + sums * self.angles),
            gradient: SECOND_ORDER * (self.edge_errors + sums * self.edges),
        }
    }
}
