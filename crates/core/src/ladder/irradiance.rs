//! The irradiance vector to a tolerance: the closed form in double precision, in double-double, or with as many bits as it takes.

use glam::DVec3;
use radgrad_numbers::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::Big;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::enclosure::{Enclosure, Outcome, PRECISIONS, enough_for_doubles, is_nothing, refined, relative_error};
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::Number;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::error::Error;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::{Enclosed, to_doubles};

/// The irradiance vector with a proven absolute error bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, irradiance_vector_to};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let found = irradiance_vector_to(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[], 1e-12)?;
/// assert!(found.vector.z > 0.0 && found.error <= 1e-12 * found.vector.length());
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

/// The result of a rung, in normalised lengths and emission.
struct Found {
    vector: Vec3<f64>,
    error: f64,
    method: Method,
}

impl Case<'_> {
    /// The first rung whose bound meets the tolerance, or the last.
    #[cold]
    pub(crate) fn irradiance_vector(&self, tolerance: f64) -> Result<IrradianceVector, Error> {
        let Some(rough) = self.irradiance_by::<f64>(Method::ClosedForm) else { return Ok(IrradianceVector::ZERO) };
        if let Some(answer) = self.irradiance_within(tolerance, &rough)? {
            return Ok(answer);
        }
        let Some(fine) = self.irradiance_by::<DoubleDouble>(Method::DoubleDouble) else { return Ok(IrradianceVector::ZERO) };
        if let Some(answer) = self.irradiance_within(tolerance, &fine)? {
            return Ok(answer);
        }
        #[cfg(feature = "arbitrary-precision")]
        {
            let find = || {
                let Vec3 { x, y, z } = IrradianceAndGradient::<Ball<Big>>::sum::<true, false>(self)?.irradiance;
                Some([x, y, z].map(Enclosure::of))
            };
            let stays_open =
                |vector: &[Enclosure; 3]| (self.is_of_one_scale() && is_nothing(vector)) || Enclosed::is_coincidence(self);
            match refined(PRECISIONS, enough_for_doubles(tolerance), |vector| relative_error(vector), stays_open, find) {
                Outcome::Nothing { .. } => return Ok(IrradianceVector::ZERO),
                Outcome::Found(refined) => {
                    let (vector, error) = to_doubles(&refined.found, self.irradiance_unit())?;
                    return Ok(IrradianceVector { vector: vector.into(), error, method: Method::ArbitraryPrecision });
                }
                Outcome::TooDear => {}
            }
        }
        self.irradiance_of(&fine)
    }

    /// The closed form with a running bound; `None` where nothing is visible.
    fn irradiance_by<N: Number>(&self, method: Method) -> Option<Found> {
        let terms = IrradianceAndGradient::<Ball<N>>::sum::<true, false>(self)?;
        let error = terms.irradiance.map(Real::value_error).length() * (1.0 + 8.0 * f64::EPSILON);
        Some(Found { vector: terms.irradiance.map(Real::value), error, method })
    }

    /// The answer if it meets the tolerance, before and after the change of unit.
    fn irradiance_within(&self, tolerance: f64, found: &Found) -> Result<Option<IrradianceVector>, Error> {
        if found.error <= tolerance * found.vector.length() {
            self.irradiance_of(found).map(|answer| Some(answer).filter(|answer| answer.meets(tolerance)))
        } else {
            Ok(None)
        }
    }

    fn irradiance_of(&self, found: &Found) -> Result<IrradianceVector, Error> {
        let Vec3 { x, y, z } = found.vector;
        let (vector, error) = self.irradiance_unit().components([x, y, z], found.error)?;
        Ok(IrradianceVector { vector: vector.into(), error, method: found.method })
    }

    pub(crate) fn irradiance_unit(&self) -> CallerUnits {
        CallerUnits::of_derivative(0, "irradiance vector", self.plan, self.emitter)
    }
}
