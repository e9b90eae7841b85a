//! The value alone, to a tolerance that is relative or absolute.
//!
//! The ladder is that of [`super`] without the gradient. That is more than a saving: where the edge of a shadow is seen in line
//! with another edge the gradient has two values, and no number of bits decides between them; the value is the same for both
//! decisions, and [`crate::visibility::Doubt`] bounds by how much it is not. A bound that is below the absolute tolerance is
//! accepted as it stands, so a sliver that nobody would miss is bounded and not decided.

#[cfg(feature = "arbitrary-precision")]
use std::array::from_ref;

use super::{Budget, Case, Found, WIDE_BESIDE_RUNNING};
use crate::Error;
#[cfg(feature = "arbitrary-precision")]
use crate::big::{Big, Enclosure, Magnitude, PRECISIONS, Refined, enough_for_doubles, refined, relative_error, to_doubles};
use crate::certify::Ball;
#[cfg(feature = "arbitrary-precision")]
use crate::digits::Enclosed;
use crate::double_double::DoubleDouble;
use crate::evaluate::{Method, Tolerance, Value};
use crate::number::Number;
use crate::real::Real;
use crate::terms::Terms;
use crate::vec3::Vec3;

impl Tolerance {
    /// The error that is allowed of a value.
    fn of(self, value: f64) -> f64 {
        self.absolute.max(self.relative * value.abs())
    }
}

impl Case<'_> {
    pub(crate) fn value(&self, tolerance: Tolerance) -> Result<Value, Error> {
        if self.is_dark() {
            return Ok(Value::ZERO);
        }
        let budget = Budget::of(self.emitter.emission());
        // The same in normalised emission.
        let normalised = Tolerance { absolute: tolerance.absolute * self.emitter.power(), ..tolerance };
        let meets = |found: &Found, normalised: Tolerance| found.radiosity_error <= normalised.of(found.radiosity);
        let accepted = |found: Found, method| -> Result<Option<Value>, Error> {
            if !meets(&found, normalised) {
                return Ok(None);
            }
            let value = self.value_of(&found, method)?;
            let is_fine = value.radiosity_error >= f64::MIN_POSITIVE || value.radiosity_error <= tolerance.of(value.radiosity);
            Ok(Some(value).filter(|_| is_fine))
        };
        let mut rule = if self.is_within(budget.wide) { self.rule() } else { None };
        if let Some(found) = self.by_few_nodes(rule.as_ref(), budget.cheap)
            && let Some(value) = accepted(found, Method::Quadrature)?
        {
            return Ok(value);
        }
        let derived = self.bounded();
        if derived.is_none() && budget.running > budget.cheap && self.is_within(WIDE_BESIDE_RUNNING) {
            rule = rule.or_else(|| self.rule());
            if let Some(found) = self.by_few_nodes(rule.as_ref(), budget.running)
                && let Some(value) = accepted(found, Method::Quadrature)?
            {
                return Ok(value);
            }
        }
        let found = derived.unwrap_or_else(|| self.certified_value::<f64>());
        if let Some(value) = accepted(found, Method::ClosedForm)? {
            return Ok(value);
        }
        let found = self.certified_value::<DoubleDouble>();
        // Where little but the rounding to doubles is left nothing dearer gives more.
        #[cfg(feature = "arbitrary-precision")]
        let last = Tolerance { relative: normalised.relative.max(1.01 * crate::number::ROUNDOFF), ..normalised };
        #[cfg(feature = "arbitrary-precision")]
        if !meets(&found, last) {
            return self.rounded_value(normalised);
        }
        self.value_of(&found, Method::DoubleDouble)
    }

    /// The value with as many bits as it takes, rounded to a double.
    #[cfg(feature = "arbitrary-precision")]
    #[cold]
    #[inline(never)]
    fn rounded_value(&self, normalised: Tolerance) -> Result<Value, Error> {
        let enough = enough_for_doubles(normalised.relative);
        let absolute = Magnitude::from(0.25 * normalised.absolute);
        let share = |found: &Enclosure| {
            if found.radius <= absolute { Magnitude::from(0.0) } else { relative_error(from_ref(found)) }
        };
        let find = || {
            let terms = Terms::<Ball<Big>>::sum::<true, false>(self)?;
            Some(Enclosure::of(terms.radiosity(self.receiver)))
        };
        let Refined { found, .. } = refined(PRECISIONS, enough, share, || Enclosed::is_coincidence(self), find);
        let Some(found) = found else { return Ok(Value::ZERO) };
        let ([radiosity], radiosity_error) = to_doubles(from_ref(&found), self.radiosity_unit())?;
        Ok(Value { radiosity, radiosity_error, method: Method::ArbitraryPrecision })
    }

    fn certified_value<N: Number>(&self) -> Found {
        let Some(terms) = Terms::<Ball<N>>::sum::<true, false>(self) else { return Found::ZERO };
        let radiosity = terms.radiosity(self.receiver);
        let (radiosity, radiosity_error) = (radiosity.value(), radiosity.value_error());
        Found { radiosity, radiosity_error, gradient: Vec3::default(), gradient_error: 0.0 }
    }

    fn value_of(&self, found: &Found, method: Method) -> Result<Value, Error> {
        if found.radiosity == 0.0 && found.radiosity_error == 0.0 {
            return Ok(Value::ZERO);
        }
        let ([radiosity], radiosity_error) = self.radiosity_unit().components([found.radiosity], found.radiosity_error)?;
        Ok(Value { radiosity, radiosity_error, method })
    }
}
