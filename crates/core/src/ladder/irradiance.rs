//! The irradiance vector to a tolerance.

use glam::DVec3;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::error::Error;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
use crate::ladder::components::{Bounded, Components};

/// The irradiance vector with a proven absolute error bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, irradiance_vector_to};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let vector = irradiance_vector_to(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[], 1e-12)?;
/// assert!(vector.vector.z > 0.0 && vector.error <= 1e-12 * vector.vector.length());
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IrradianceVector {
    /// `int B(y) omega domega` over the visible part above the horizon, in the unit of the emission.
    pub vector: DVec3,
    /// Proven bound on the Euclidean norm of its error.
    pub error: f64,
    /// The method that answered.
    pub method: Method,
}

impl IrradianceVector {
    pub(crate) const ZERO: Self = Self { vector: DVec3::ZERO, error: 0.0, method: Method::Zero };

    /// Whether the bound is within `tolerance`, relative to the vector's length.
    #[must_use]
    pub fn meets(&self, tolerance: f64) -> bool {
        self.error <= tolerance * Vec3::from(self.vector).length()
    }
}

impl Components<3> for IrradianceVector {
    /// Three squares, their sum, a root, and the way back from a power of two.
    const UP: f64 = 1.0 + 8.0 * f64::EPSILON;

    fn find<T: Real>(case: &Case<'_>) -> Option<[T; 3]> {
        let Vec3 { x, y, z } = IrradianceAndGradient::<T>::sum::<true, false>(case)?.irradiance;
        Some([x, y, z])
    }

    fn norm([x, y, z]: [f64; 3]) -> f64 {
        Vec3::new(x, y, z).length()
    }

    fn unit(case: &Case<'_>) -> CallerUnits {
        CallerUnits::of_derivative(0, "irradiance vector", case.plan, case.emitter)
    }
}

impl Case<'_> {
    /// The first rung whose bound meets the tolerance, or the last.
    pub(crate) fn irradiance_vector(&self, tolerance: f64) -> Result<IrradianceVector, Error> {
        let bounded = Bounded::to::<IrradianceVector>(self, tolerance)?;
        Ok(bounded.map_or(IrradianceVector::ZERO, |Bounded { components, error, method }| IrradianceVector {
            vector: components.into(),
            error,
            method,
        }))
    }
}
