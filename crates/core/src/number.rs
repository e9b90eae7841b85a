//! What the middle of a [`crate::certify::Ball`] can be: a double or a double-double, each with the relative errors of its operations.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::dilogarithm;
use crate::double_double::{self, DoubleDouble, LIBRARY_UNITS};

/// Unit roundoff of double precision, 2^-53.
pub(crate) const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A floating-point number. All errors are relative to the result, barring underflow.
pub(crate) trait Number:
    Copy + std::fmt::Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Error of sum, difference, product and square root, and of rounding a double-double to this.
    const ROUNDOFF: f64;
    /// Error of a quotient.
    const QUOTIENT: f64;
    /// Error of logarithm and arc tangent.
    const LIBRARY: f64;
    /// Error of [`dilogarithm::clausen`].
    const CLAUSEN: f64;
    /// Terms that series on an argument of at most 1 take, of [`crate::arc`], and that Clausen's series take.
    const SERIES_TERMS: usize;
    const CLAUSEN_TERMS: usize;

    /// The leading double.
    fn high(self) -> f64;
    /// What the leading double leaves.
    fn low(self) -> f64;
    fn from_double(value: f64) -> Self;
    /// Error `ROUNDOFF`.
    fn from_double_double(value: DoubleDouble) -> Self;
    /// The difference of two doubles, with the error [`Self::DIFFERENCE`].
    fn difference(a: f64, b: f64) -> Self;
    const DIFFERENCE: f64;
    /// Times a power of two: exact.
    fn scaled(self, power_of_two: f64) -> Self;
    fn sqrt(self) -> Self;
    fn ln(self) -> Self;
    fn atan2(self, x: Self) -> Self;
    /// `pi - self`, to full relative accuracy.
    fn pi_minus(self) -> Self;
}

impl Number for f64 {
    const ROUNDOFF: Self = ROUNDOFF;
    const QUOTIENT: Self = ROUNDOFF;
    /// 2 ulp, an ulp being at most two units of the result: the assumption that `tests/library_functions.rs` tests.
    const LIBRARY: Self = 4.0 * ROUNDOFF;
    const CLAUSEN: Self = dilogarithm::DOUBLE_UNITS * ROUNDOFF;
    const SERIES_TERMS: usize = 8;
    const CLAUSEN_TERMS: usize = 15;
    const DIFFERENCE: Self = ROUNDOFF;

    #[inline]
    fn high(self) -> f64 {
        self
    }
    #[inline]
    fn low(self) -> f64 {
        0.0
    }
    #[inline]
    fn from_double(value: f64) -> Self {
        value
    }
    #[inline]
    fn from_double_double(value: DoubleDouble) -> Self {
        value.hi
    }
    #[inline]
    fn difference(a: f64, b: f64) -> Self {
        a - b
    }
    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        self * power_of_two
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn ln(self) -> Self {
        libm::log(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
    #[inline]
    fn pi_minus(self) -> Self {
        let pi = DoubleDouble::pi();
        (pi.hi - self) + pi.lo
    }
}

impl Number for DoubleDouble {
    const ROUNDOFF: f64 = double_double::UNIT;
    const QUOTIENT: f64 = 2.0 * double_double::UNIT;
    const LIBRARY: f64 = LIBRARY_UNITS * double_double::UNIT;
    const CLAUSEN: f64 = dilogarithm::DOUBLE_DOUBLE_UNITS * double_double::UNIT;
    const SERIES_TERMS: usize = 14;
    const CLAUSEN_TERMS: usize = 34;
    const DIFFERENCE: f64 = 0.0;

    fn high(self) -> f64 {
        self.hi
    }
    fn low(self) -> f64 {
        self.lo
    }
    fn from_double(value: f64) -> Self {
        Self::from(value)
    }
    fn from_double_double(value: DoubleDouble) -> Self {
        value
    }
    fn difference(a: f64, b: f64) -> Self {
        Self::difference(a, b)
    }
    fn scaled(self, power_of_two: f64) -> Self {
        Self::scaled(self, power_of_two)
    }
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    fn ln(self) -> Self {
        Self::ln(self)
    }
    fn atan2(self, x: Self) -> Self {
        Self::atan2(self, x)
    }
    fn pi_minus(self) -> Self {
        Self::pi_minus(self)
    }
}
