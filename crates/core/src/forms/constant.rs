//! Constant emission (HS95 Eqs. 10, 11 and A.1): sums over the arcs of the visible boundary.
//!
//! - Irradiance vector of a unit emission, `Phi = int omega domega = -1/2 sum g N`; the radiosity is `(rho B/pi) n1.Phi`. Exact
//!   in the arc's angle and normal, so each term errs by a few roundings; the sum cancels when the emitter is small, grazing or
//!   far, by about `|terms|/|sum|`, D/s at distance D for size s.
//! - Gradient: `(rho B/pi) sum e x (M n1) / |w|`, which in the frame of the generating line is
//!   `-(rho B/pi) sum N toward.(M n1)/S`, with S the distance of the line ([`Arc::weight`]). The horizon has no line and adds
//!   nothing: its points have no projected area. Cancels like the value.

use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;

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
        self.sum = self.sum - line.normal * arc.weight(line, self.n1);
    }

    #[inline]
    pub(crate) fn sum(self) -> Vec3<T> {
        self.sum
    }
}
