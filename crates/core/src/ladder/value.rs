//! The value alone, to a tolerance that is relative or absolute.
//!
//! The ladder is that of [`crate::ladder::rungs`] without the gradient. That is more than a saving: where the edge of a shadow is
//! seen in line with another edge the gradient has two values, and no number of bits decides between them; the value is the same
//! for both decisions, and [`crate::boundary::visibility::uncertainty::Uncertainty`] bounds by how much it is not. A bound that
//! is below the absolute tolerance is accepted as it stands, so a sliver that nobody would miss is bounded and not decided.

#[cfg(feature = "arbitrary-precision")]
use std::array::from_ref;

#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::Big;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::enclosure::{Enclosure, Outcome, PRECISIONS, enough_for_doubles, is_nothing, refined, relative_error};
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::magnitude::Magnitude;
use radgrad_numbers::number::ROUNDOFF;

use crate::boundary::case::Case;
use crate::error::Error;
#[cfg(feature = "arbitrary-precision")]
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::answer::{Method, Tolerance, Value};
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::{Enclosed, to_doubles};
use crate::ladder::rungs::{Climb, Evaluated};

impl Tolerance {
    /// The error that is allowed of a value.
    fn allowed(self, value: f64) -> f64 {
        self.absolute.max(self.relative * value.abs())
    }
}

impl Case<'_> {
    pub(crate) fn value(&self, tolerance: Tolerance) -> Result<Value, Error> {
        if self.is_dark() {
            return Ok(Value::ZERO);
        }
        if self.plan.on_surface {
            return self.value_of(&self.on_surface(), Method::OnSurface);
        }
        // The same in normalised emission.
        let normalised = Tolerance { absolute: tolerance.absolute * self.emitter.power(), ..tolerance };
        // Where little but the rounding to doubles is left nothing dearer gives more.
        let nearly = Tolerance { relative: normalised.relative.max(1.01 * ROUNDOFF), ..normalised };
        let climb = self.climb::<_, false>(normalised.relative, |evaluated, method| {
            let enough = if method == Method::DoubleDouble { nearly } else { normalised };
            if evaluated.radiosity_error > enough.allowed(evaluated.radiosity) || evaluated.radiosity_error.is_nan() {
                return Ok(None);
            }
            let value = self.value_of(evaluated, method)?;
            let is_fine = value.radiosity_error >= f64::MIN_POSITIVE
                || value.radiosity_error <= tolerance.allowed(value.radiosity)
                || method == Method::DoubleDouble;
            Ok(Some(value).filter(|_| is_fine))
        })?;
        match climb {
            Climb::Met(value) => Ok(value),
            #[cfg(feature = "arbitrary-precision")]
            Climb::Last(last) => self.narrowed_value(self.rounded_value(normalised, &last)?),
            #[cfg(not(feature = "arbitrary-precision"))]
            Climb::Last(last) => self.narrowed_value(self.value_of(&last, Method::DoubleDouble)?),
            Climb::LastOfInput(last) => self.narrowed_value(self.value_of(&last, Method::DoubleDouble)?),
        }
    }

    /// The value with as many bits as it takes, rounded to a double, or the value before where that would take too long.
    #[cfg(feature = "arbitrary-precision")]
    #[cold]
    #[inline(never)]
    fn rounded_value(&self, normalised: Tolerance, before: &Evaluated) -> Result<Value, Error> {
        if let Some([radiosity_error, _]) = self.below_range()? {
            return Ok(Value { radiosity: 0.0, radiosity_error, method: Method::Quadrature });
        }
        let enough = enough_for_doubles(normalised.relative);
        let absolute = Magnitude::from(0.25 * normalised.absolute);
        let share = |enclosure: &Enclosure| {
            if enclosure.radius <= absolute { Magnitude::from(0.0) } else { relative_error(from_ref(enclosure)) }
        };
        let find = || {
            let terms = IrradianceAndGradient::<Ball<Big>>::sum::<true, false>(self)?;
            Some(Enclosure::from_ball(terms.radiosity(self.receiver)))
        };
        let stays_open =
            |enclosure: &Enclosure| (self.is_of_one_scale() && is_nothing(from_ref(enclosure))) || Enclosed::is_coincidence(self);
        let enclosure = match refined(PRECISIONS, enough, share, stays_open, find) {
            Outcome::Nothing { .. } => return Ok(Value::ZERO),
            Outcome::Found(refined) => refined.result,
            Outcome::TooDear => return self.value_of(before, Method::DoubleDouble),
        };
        let ([radiosity], radiosity_error) = to_doubles(from_ref(&enclosure), self.radiosity_unit())?;
        Ok(Value { radiosity, radiosity_error, method: Method::ArbitraryPrecision })
    }

    pub(super) fn value_of(&self, evaluated: &Evaluated, method: Method) -> Result<Value, Error> {
        if evaluated.radiosity == 0.0 && evaluated.radiosity_error == 0.0 {
            return Ok(Value::ZERO);
        }
        let ([radiosity], radiosity_error) =
            self.radiosity_unit().components([evaluated.radiosity], evaluated.radiosity_error)?;
        Ok(Value { radiosity, radiosity_error, method })
    }
}
