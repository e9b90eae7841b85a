//! Irradiance and gradient as a closed form sums them: on balls with a proven bound, on doubles the same digits without one.

use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::problem::receiver::{Receiver, albedo, unit_normal};

/// Irradiance vector and gradient without the factor rho/pi, in normalised lengths and emission.
pub(crate) struct IrradianceAndGradient<T> {
    pub(crate) irradiance: Vec3<T>,
    /// Zero where it was not requested.
    pub(crate) gradient: Vec3<T>,
}

impl<T: Real> IrradianceAndGradient<T> {
    /// Radiosity, in normalised emission.
    #[inline]
    pub(crate) fn radiosity(&self, receiver: &Receiver) -> T {
        unit_normal(receiver).dot(self.irradiance) * albedo(receiver)
    }

    /// Gradient, in normalised lengths and emission.
    #[inline]
    pub(crate) fn gradient(&self, receiver: &Receiver) -> Vec3<T> {
        self.gradient * albedo(receiver)
    }
}
