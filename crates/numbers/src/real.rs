//! The scalar that the closed forms are written on: a plain double, or a number with a running error bound
//! ([`crate::ball::Ball`]) of double, double-double or arbitrary precision.
//!
//! One formula serves every precision. Decisions (which side, which branch) are taken on [`Real::value`], so that all scalars
//! walk the same path; where a wrong decision would change the answer, a caller takes it by an exact predicate
//! ([`crate::exact`]).

use crate::arithmetic::Arithmetic;
use crate::dilogarithm;
use crate::double_double::DoubleDouble;
use crate::number::Number;
use crate::series::sine;

/// The type of a scalar's error bounds.
pub type RadiusOf<T> = <<T as Real>::Number as Number>::Radius;

/// A real number known well enough to compute with.
pub trait Real: Arithmetic<Mask = bool> {
    /// The floating-point number it is kept in.
    type Number: Number;

    /// A number that differs from `value` by at most `error`.
    fn approximate(value: Self::Number, error: RadiusOf<Self>) -> Self;

    /// The leading double.
    fn value(self) -> f64;

    /// Magnitude, off by at most a relative 2^-52; without the error bound.
    fn size(self) -> RadiusOf<Self>;

    /// Bound on the difference from the real number meant; 0 where it is not tracked.
    fn error(self) -> RadiusOf<Self>;

    /// Bound on the difference of [`Self::value`] from the real number meant.
    fn value_error(self) -> f64;

    /// The same number known less well, by `error`.
    fn widened(self, error: RadiusOf<Self>) -> Self;

    /// Times a power of two, exactly.
    fn scaled(self, power_of_two: f64) -> Self;

    /// Exactly this double.
    #[inline]
    fn exact(value: f64) -> Self {
        Self::approximate(Self::Number::from_double(value), 0.0.into())
    }

    /// The difference of two doubles, times a power of two.
    #[inline]
    fn difference(a: f64, b: f64, power_of_two: f64) -> Self {
        let difference = Self::Number::difference(a, b).scaled(power_of_two);
        // Below the normal range the power of two rounds.
        let size = difference.size();
        let rounds = size < Self::Number::tiny() / Self::Number::roundoff() && difference.high() != 0.0;
        let lost = if rounds { Self::Number::tiny() } else { 0.0.into() };
        Self::approximate(difference, Self::Number::roundoff() * size * Self::Number::DIFFERENCE_UNITS + lost)
    }

    /// A double-double known to within `error`, rounded to this scalar.
    #[inline]
    fn from_double_double(value: DoubleDouble, error: f64) -> Self {
        let rounded = Self::Number::from_double_double(value);
        Self::rounded(rounded).widened(error.into())
    }

    /// A number off by at most a roundoff.
    #[inline]
    fn rounded(value: Self::Number) -> Self {
        Self::approximate(value, Self::Number::roundoff() * value.size())
    }

    /// pi.
    #[inline]
    fn pi() -> Self {
        Self::rounded(Self::Number::pi())
    }
}

impl Real for f64 {
    type Number = Self;

    #[inline]
    fn approximate(value: Self, _error: Self) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn size(self) -> Self {
        self.abs()
    }

    #[inline]
    fn error(self) -> Self {
        0.0
    }

    #[inline]
    fn value_error(self) -> f64 {
        0.0
    }

    #[inline]
    fn widened(self, _error: Self) -> Self {
        self
    }

    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        self * power_of_two
    }
}

impl Arithmetic for f64 {
    type Mask = bool;
    const IS_DOUBLE: bool = true;

    #[inline(always)]
    fn like(self, constant: f64) -> Self {
        constant
    }

    #[inline(always)]
    fn like_pi(self) -> Self {
        std::f64::consts::PI
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn choose(mask: bool, set: Self, unset: Self) -> Self {
        if mask { set } else { unset }
    }

    #[inline(always)]
    fn choose_of(mask: bool, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self {
        if mask { set() } else { unset() }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Number::ln(self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        Number::atan2(self, x)
    }

    #[inline]
    fn clausen_rest(self) -> Self {
        dilogarithm::clausen_rest(self)
    }

    #[inline]
    fn sine_series(square: Self) -> Self {
        sine::double_sum(square) * 12.0
    }

    #[inline(always)]
    fn known_to(self, _: f64) -> Self {
        self
    }
}
