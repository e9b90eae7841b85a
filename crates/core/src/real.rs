//! The scalar that the closed forms are written on: a plain double, or a number with a running error bound ([`crate::certify::Ball`]) of
//! double or double-double precision.
//!
//! One formula serves every precision. Decisions (which side, which branch) are taken on [`Real::value`], so that all scalars walk
//! the same path; where a wrong decision would change the answer, it is taken by an exact predicate instead ([`crate::plan`]).

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::dilogarithm;
use crate::double_double::DoubleDouble;
use crate::number::Number;

/// A real number known well enough to compute with.
pub(crate) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The floating-point number it is kept in.
    type Number: Number;

    /// A number that differs from `value` by at most `error`.
    fn approximate(value: Self::Number, error: f64) -> Self;

    /// The leading double of what is known.
    fn value(self) -> f64;

    /// Bound on the difference from the real number meant; 0 where it is not tracked.
    fn error(self) -> f64;

    /// Bound on the difference of [`Self::value`] from the real number meant.
    fn value_error(self) -> f64;

    /// The same number known less well, by `error`.
    fn widened(self, error: f64) -> Self;

    /// Times the sign of `other`.
    fn with_sign_of(self, other: Self) -> Self;

    /// Times a power of two, exactly.
    fn scaled(self, power_of_two: f64) -> Self;

    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;

    /// Natural logarithm of a positive number.
    fn ln(self) -> Self;

    /// Angle of the point `(x, self)`, in (-pi, pi]; never called across the cut.
    fn atan2(self, x: Self) -> Self;

    /// Clausen's function `Cl2`, see [`dilogarithm`].
    fn clausen(self) -> Self;

    /// Exactly this double.
    #[inline]
    fn exact(value: f64) -> Self {
        Self::approximate(Self::Number::from_double(value), 0.0)
    }

    /// The difference of two doubles, times a power of two.
    #[inline]
    fn difference(a: f64, b: f64, power_of_two: f64) -> Self {
        let difference = Self::Number::difference(a, b).scaled(power_of_two);
        Self::approximate(difference, Self::Number::DIFFERENCE * difference.high().abs())
    }

    /// A double-double known to within `error`, rounded to this scalar.
    #[inline]
    fn from_double_double(value: DoubleDouble, error: f64) -> Self {
        let rounded = Self::Number::from_double_double(value);
        Self::approximate(rounded, error + Self::Number::ROUNDOFF * rounded.high().abs())
    }

    /// pi.
    #[inline]
    fn pi() -> Self {
        Self::from_double_double(DoubleDouble::pi(), 0.0)
    }

    /// The magnitude.
    #[inline]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
}

impl Real for f64 {
    type Number = Self;

    #[inline]
    fn approximate(value: Self, _error: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn error(self) -> f64 {
        0.0
    }

    #[inline]
    fn value_error(self) -> f64 {
        0.0
    }

    #[inline]
    fn widened(self, _error: f64) -> Self {
        self
    }

    #[inline]
    fn with_sign_of(self, other: Self) -> Self {
        if other < 0.0 { -self } else { self }
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
        Number::ln(self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        Number::atan2(self, x)
    }

    #[inline]
    fn clausen(self) -> Self {
        dilogarithm::clausen(self)
    }

    #[inline]
    fn abs(self) -> Self {
        Self::abs(self)
    }
}
