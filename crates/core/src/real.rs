//! The scalar that the closed forms are written on: a double, or a double with a running error bound ([`crate::certify::Ball`]).
//!
//! One formula serves every precision. Decisions (which side, which branch) are taken on [`Real::value`], so that all scalars walk
//! the same path; where a wrong decision would change the answer, it is taken by an exact predicate instead ([`crate::plan`]).

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::dilogarithm;
use crate::double_double::{self, DoubleDouble};

/// Unit roundoff of double precision, 2^-53.
pub(crate) const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A real number known well enough to compute with.
pub(crate) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number that differs from `value` by at most `error`.
    fn approximate(value: f64, error: f64) -> Self;

    /// The double nearest to what is known.
    fn value(self) -> f64;

    /// Bound on the difference from the real number meant; 0 where it is not tracked.
    fn error(self) -> f64;

    /// The same number known less well, by `error`.
    fn widened(self, error: f64) -> Self;

    /// Times the sign of `other`.
    fn with_sign_of(self, other: Self) -> Self;

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
        Self::approximate(value, 0.0)
    }

    /// A double that was rounded to nearest once.
    #[inline]
    fn rounded(value: f64) -> Self {
        Self::approximate(value, ROUNDOFF * value.abs())
    }

    /// A double-double known to within `error`, rounded to this scalar.
    #[inline]
    fn from_double_double(value: DoubleDouble, error: f64) -> Self {
        let rounded = value.to_f64();
        Self::approximate(rounded, error + (ROUNDOFF + double_double::UNIT) * rounded.abs())
    }

    /// pi.
    #[inline]
    fn pi() -> Self {
        Self::rounded(std::f64::consts::PI)
    }

    /// The magnitude.
    #[inline]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
}

impl Real for f64 {
    #[inline]
    fn approximate(value: f64, _error: f64) -> Self {
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
    fn widened(self, _error: f64) -> Self {
        self
    }

    #[inline]
    fn with_sign_of(self, other: Self) -> Self {
        if other < 0.0 { -self } else { self }
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
    fn clausen(self) -> Self {
        dilogarithm::clausen(self)
    }

    #[inline]
    fn abs(self) -> Self {
        Self::abs(self)
    }
}
