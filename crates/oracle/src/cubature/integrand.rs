//! Eq. 1 (HS95) and its gradient as integrands over the plane of the emitter.
//!
//! `B(x) = (rho/pi) int B(y) s h / r^4 dA`, `s = n1.r`, `h = -n2.r`, `r = y - x`. Differentiating the kernel with respect to
//! `x`, the region held fixed (`s = 0` on the horizon, so its motion adds nothing): `grad B(x) = (rho/pi) int B(y) { (s n2 - h
//! n1)/r^4 + 4 s h r/r^6 } dA`. All factors of the first are positive where the emitter is seen, so it keeps its digits; the
//! second changes sign, and near contact its integral is smaller than that of its magnitude by the factor `h / size`: that many
//! digits are lost, and the caller counts them.

use glam::DVec3;
use radgrad_core::Emission;

use crate::cubature::piece::Four;
use crate::region::plane::Vertex;
use crate::region::{FrameVector, Region};
use crate::source_function::SourceFunction;

/// A region and a source, as an integrand reads them. Integrands are without the factor `rho/pi`, in scaled lengths,
/// gradients in the frame `(u, v, n2)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integrand<'a> {
    pub(crate) height: f64,
    pub(crate) normal: FrameVector,
    region: &'a Region,
    source: SourceFunction<'a>,
}

impl<'a> Integrand<'a> {
    pub(crate) fn new(region: &'a Region, source: SourceFunction<'a>) -> Self {
        Self { height: region.height, normal: region.normal, region, source }
    }

    /// Emission at a point of the plane.
    #[inline]
    pub(crate) fn emission(&self, at: &Vertex) -> f64 {
        match self.source {
            SourceFunction::Emitter(emitter) => match emitter.emission() {
                Emission::Polynomial(polynomial) => polynomial.value_at(self.region.point(at.p, at.q)),
                Emission::Constant(_) | Emission::Linear(_) => at.b,
            },
            SourceFunction::Function(function) => (function.radiosity)(self.region.point(at.p, at.q)),
        }
    }

    /// Its gradient along `u` and `v`, per scaled length. Not a number for a function without: who needs one has asked.
    pub(crate) fn emission_gradient(&self, at: &Vertex) -> [f64; 2] {
        let gradient = match self.source {
            SourceFunction::Emitter(emitter) => emitter.emission_gradient_at(self.region.point(at.p, at.q)),
            SourceFunction::Function(function) => {
                function.gradient.map_or(DVec3::NAN, |gradient| gradient(self.region.point(at.p, at.q)))
            }
        };
        [self.region.axes[0].dot(gradient) / self.region.unit, self.region.axes[1].dot(gradient) / self.region.unit]
    }

    /// `r` and `1/r^2`.
    #[inline]
    pub(crate) fn ray(&self, at: &Vertex) -> (FrameVector, f64) {
        (FrameVector::new(at.p, at.q, -self.height), 1.0 / (at.p * at.p + at.q * at.q + self.height * self.height))
    }

    /// The integrand of Eq. 1 and its gradient over the surface.
    #[inline]
    pub(crate) fn surface(&self, at: &Vertex) -> Four {
        let h = self.height;
        let (r, inverse) = self.ray(at);
        let weight = self.emission(at) * inverse * inverse;
        let pull = 4.0 * at.s * h * inverse;
        let gradient = pull * r - h * self.normal + FrameVector::new(0.0, 0.0, at.s);
        [weight * (at.s * h), weight * gradient.x, weight * gradient.y, weight * gradient.z]
    }
}
