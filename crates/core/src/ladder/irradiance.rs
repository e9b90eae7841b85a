//! The irradiance vector with more digits than double precision has.

use crate::boundary::case::Case;
use crate::error::Error;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::caller_units::CallerUnits;
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::to_doubles;
use crate::scalar::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use crate::scalar::big::Big;
#[cfg(feature = "arbitrary-precision")]
use crate::scalar::big::enclosure::{Enclosure, PRECISIONS, enough_for_doubles, is_nothing, refined, relative_error};
use crate::scalar::double_double::DoubleDouble;
use crate::scalar::real::Real;
use crate::scalar::vec3::Vec3;

impl Case<'_> {
    /// The irradiance vector in double-double, or with as many bits as it takes to a relative tolerance.
    #[cold]
    pub(crate) fn irradiance_vector(&self, tolerance: f64, unit: CallerUnits) -> Result<[f64; 3], Error> {
        let Some(terms) = IrradianceAndGradient::<Ball<DoubleDouble>>::sum::<true, false>(self) else { return Ok([0.0; 3]) };
        let [found, errors] = [terms.irradiance.map(Real::value), terms.irradiance.map(Real::value_error)];
        let Vec3 { x, y, z } = found;
        if errors.length() <= tolerance * found.length() {
            return unit.plain([x, y, z]);
        }
        #[cfg(feature = "arbitrary-precision")]
        {
            let find = || {
                let terms = IrradianceAndGradient::<Ball<Big>>::sum::<true, false>(self)?;
                let Vec3 { x, y, z } = terms.irradiance;
                Some([x, y, z].map(Enclosure::of))
            };
            let stays_open = |vector: &[Enclosure; 3]| self.is_of_one_scale() && is_nothing(vector);
            let refined = refined(PRECISIONS, enough_for_doubles(tolerance), |vector| relative_error(vector), stays_open, find);
            refined.found.map_or(Ok([0.0; 3]), |vector| to_doubles(&vector, unit).map(|(vector, _)| vector))
        }
        #[cfg(not(feature = "arbitrary-precision"))]
        unit.plain([x, y, z])
    }
}
