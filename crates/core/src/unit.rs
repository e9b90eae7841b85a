//! From normalised lengths and emission to the units of the caller.
//!
//! All is computed with lengths and an emission of about 1, so each result has to be multiplied by one power of two: exactly,
//! while the product is a normal number. A product beyond the range of a double is an error, and so is one that is not 0 but
//! below the normal range, where doubles have fewer digits than were found.

use crate::plan::Plan;
use crate::{Emitter, Error};

/// The power of two that takes a normalised result to the unit of the caller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unit {
    exponent: i32,
    quantity: &'static str,
}

/// The smallest double, an ulp of all that are not normal.
const SMALLEST: f64 = f64::from_bits(1);

impl Unit {
    /// Of a derivative of the radiosity: the unit of the emission over that of length to the power `order`.
    #[inline]
    pub(crate) fn of_derivative(order: i32, quantity: &'static str, plan: &Plan, emitter: &Emitter) -> Self {
        Self { exponent: order * libm::ilogb(plan.power) - libm::ilogb(emitter.power()), quantity }
    }

    /// The components of a number, vector or matrix, at most nine, that is off by at most `error`, and a bound on the error they
    /// have in this unit.
    ///
    /// Below the normal range each component is rounded by half the smallest double at most, and so is the bound: four of those
    /// halves together.
    #[inline]
    pub(crate) fn components<const N: usize>(self, normalised: [f64; N], error: f64) -> Result<([f64; N], f64), Error> {
        const { assert!(N <= 9) };
        let components = normalised.map(|c| libm::scalbn(c, self.exponent));
        let bound = libm::scalbn(error, self.exponent);
        let is_rounded = |normalised: f64, scaled: f64| normalised != 0.0 && scaled.abs() < f64::MIN_POSITIVE;
        let rounded = is_rounded(error, bound) || normalised.iter().zip(&components).any(|(c, scaled)| is_rounded(*c, *scaled));
        let bound = if rounded { (bound + 2.0 * SMALLEST).next_up() } else { bound };
        self.check(components, largest(&normalised) > error)?;
        Ok((components, if bound.is_nan() { f64::INFINITY } else { bound }))
    }

    /// Refuses what is not finite, and what is known not to be 0 but below the normal range.
    #[inline]
    pub(crate) fn check<const N: usize>(self, components: [f64; N], is_nonzero: bool) -> Result<(), Error> {
        if components.iter().any(|c| !c.is_finite()) {
            Err(Error::Overflow { quantity: self.quantity })
        } else if largest(&components) < f64::MIN_POSITIVE && is_nonzero {
            Err(Error::Underflow { quantity: self.quantity })
        } else {
            Ok(())
        }
    }

    /// The power of two itself.
    #[cfg(feature = "arbitrary-precision")]
    pub(crate) const fn magnitude(self) -> crate::big::Magnitude {
        crate::big::Magnitude::power_of_two(self.exponent as i64)
    }
}

fn largest(components: &[f64]) -> f64 {
    components.iter().fold(0.0, |m: f64, c| m.max(c.abs()))
}
