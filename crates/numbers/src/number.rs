//! The numbers that the middle of a [`crate::ball::Ball`] can be: a double, a double-double, or one of as many digits as
//! are requested (`crate::big`), each with the relative errors of its operations.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

#[cfg(doc)]
use crate::dilogarithm;
use crate::double_double::DoubleDouble;
use crate::double_double::LIBRARY_UNITS;
use crate::radius::Radius;
use crate::series::clausen;
use crate::series::sine::SINE_SERIES;
use crate::{arc_tangent, double_double, exact, logarithm};

/// Unit roundoff of double precision, 2^-53.
pub const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A floating-point number. All errors are relative to the result, barring underflow.
pub trait Number:
    Copy + std::fmt::Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The type of its error bounds.
    type Radius: Radius;
    /// Whether it has more digits than the normals and gradients that are kept in double-double, so that they must be found anew.
    const BEYOND_DOUBLE_DOUBLE: bool;
    /// Whether approximations to a rounding of a double serve.
    const IS_DOUBLE: bool;
    /// Error of a quotient, in units of roundoff.
    const QUOTIENT_UNITS: f64;
    /// Error of logarithm and arc tangent, in units of roundoff.
    const LIBRARY_UNITS: f64;
    /// Error of [`dilogarithm::clausen_rest`], in units of roundoff.
    const CLAUSEN_UNITS: f64;
    /// Error of [`Self::difference`], in units of roundoff.
    const DIFFERENCE_UNITS: f64;

    /// Error of sum, difference, product and square root, and of rounding a double-double to this.
    fn roundoff() -> Self::Radius;
    /// Above the absolute error of any one operation whose result is not normal.
    fn tiny() -> Self::Radius;
    /// The magnitude, off by at most a relative 2^-52.
    fn size(self) -> Self::Radius;
    /// The leading double.
    fn high(self) -> f64;
    /// The rest beyond the leading double.
    fn low(self) -> f64;
    /// Exactly this double.
    fn from_double(value: f64) -> Self;
    /// Error `ROUNDOFF`.
    fn from_double_double(value: DoubleDouble) -> Self;
    /// pi, off by at most a roundoff.
    fn pi() -> Self;
    /// `a - b`, off by [`Self::DIFFERENCE_UNITS`].
    fn difference(a: f64, b: f64) -> Self;
    /// `n . (point - x)` times a power of two: with the right sign, and an error of two units of roundoff; below the normal range
    /// of doubles, of [`Self::tiny`].
    fn exact_height(n: (DVec3, f64), point: DVec3, x: DVec3, power: f64) -> Self;
    /// Times a power of two: exact.
    fn scaled(self, power_of_two: f64) -> Self;
    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;
    /// Natural logarithm of a positive number, off by [`Self::LIBRARY_UNITS`].
    fn ln(self) -> Self;
    /// Angle of the point `(x, self)` in [-pi, pi], off by [`Self::LIBRARY_UNITS`].
    fn atan2(self, x: Self) -> Self;
    /// Coefficients of [`series::sine::SINE_SERIES`](crate::series::sine::SINE_SERIES), as many as an argument of at most 1 takes.
    fn sine_coefficients() -> impl DoubleEndedIterator<Item = Self>;
    /// The sum of [`dilogarithm`]'s series over the cube of its argument.
    fn clausen_sum(square: Self) -> Self;
}

const _: () = assert!(
    arc_tangent::UNITS <= <f64 as Number>::LIBRARY_UNITS && logarithm::UNITS <= <f64 as Number>::LIBRARY_UNITS,
    "doubles state too little for their functions"
);

impl Number for f64 {
    type Radius = Self;
    const BEYOND_DOUBLE_DOUBLE: bool = false;
    const IS_DOUBLE: bool = true;
    const QUOTIENT_UNITS: Self = 1.0;
    /// Above those of [`arc_tangent`] and [`logarithm`].
    const LIBRARY_UNITS: Self = 4.0;
    const CLAUSEN_UNITS: Self = clausen::DOUBLE_UNITS;
    const DIFFERENCE_UNITS: Self = 1.0;

    #[inline]
    fn roundoff() -> Self {
        ROUNDOFF
    }
    #[inline]
    fn tiny() -> Self {
        Self::MIN_POSITIVE
    }
    #[inline]
    fn size(self) -> Self {
        self.abs()
    }
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
    fn pi() -> Self {
        std::f64::consts::PI
    }
    #[inline]
    fn difference(a: f64, b: f64) -> Self {
        a - b
    }
    #[inline]
    fn exact_height(n: (DVec3, f64), point: DVec3, x: DVec3, power: f64) -> Self {
        exact::height(n, point, x, power).hi
    }
    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        self * power_of_two
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        logarithm::ln(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        arc_tangent::atan2(self, x)
    }
    #[inline]
    fn sine_coefficients() -> impl DoubleEndedIterator<Item = Self> {
        SINE_SERIES[..8].iter().map(|c| c.hi)
    }
    #[inline]
    fn clausen_sum(square: Self) -> Self {
        clausen::double_sum(square)
    }
}

impl Number for DoubleDouble {
    type Radius = f64;
    const BEYOND_DOUBLE_DOUBLE: bool = false;
    const IS_DOUBLE: bool = false;
    const QUOTIENT_UNITS: f64 = 2.0;
    const LIBRARY_UNITS: f64 = LIBRARY_UNITS;
    const CLAUSEN_UNITS: f64 = clausen::UNITS;
    const DIFFERENCE_UNITS: f64 = 0.0;

    #[inline]
    fn roundoff() -> f64 {
        double_double::ROUNDOFF_OF_DOUBLE_DOUBLE
    }
    #[inline]
    fn tiny() -> f64 {
        f64::MIN_POSITIVE
    }
    #[inline]
    fn size(self) -> f64 {
        self.hi.abs()
    }
    #[inline]
    fn high(self) -> f64 {
        self.hi
    }
    #[inline]
    fn low(self) -> f64 {
        self.lo
    }
    #[inline]
    fn from_double(value: f64) -> Self {
        Self::from(value)
    }
    #[inline]
    fn from_double_double(value: DoubleDouble) -> Self {
        value
    }
    #[inline]
    fn pi() -> Self {
        Self::pi()
    }
    #[inline]
    fn difference(a: f64, b: f64) -> Self {
        Self::difference(a, b)
    }
    #[inline]
    fn exact_height(n: (DVec3, f64), point: DVec3, x: DVec3, power: f64) -> Self {
        exact::height(n, point, x, power)
    }
    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        Self::scaled(self, power_of_two)
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn ln(self) -> Self {
        Self::ln(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        Self::atan2(self, x)
    }
    #[inline]
    fn sine_coefficients() -> impl DoubleEndedIterator<Item = Self> {
        SINE_SERIES.into_iter()
    }
    #[inline]
    fn clausen_sum(square: Self) -> Self {
        clausen::SERIES.as_slice().iter().rev().fold(Self::from(0.0), |sum, c| sum * square + *c)
    }
}
