//! The type of the error bound of a [`crate::ball::Ball`]: doubles, or numbers of a double's digits and a wider range.
//!
//! Each operation may err by a relative 2^-53; the callers pay for it.

use std::ops::{Add, Div, Mul, Sub};

/// A bound: not negative, possibly infinite or not a number.
pub trait Radius:
    Copy
    + std::fmt::Debug
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
{
    /// Square root.
    fn sqrt(self) -> Self;

    /// A double that is not smaller.
    fn to_double(self) -> f64;

    /// The smaller of the two; the other one where one is not a number.
    #[inline]
    fn min(self, other: Self) -> Self {
        if other < self || self.partial_cmp(&self).is_none() { other } else { self }
    }

    /// The larger of the two; the other one where one is not a number.
    #[inline]
    fn max(self, other: Self) -> Self {
        if other > self || self.partial_cmp(&self).is_none() { other } else { self }
    }
}

impl Radius for f64 {
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn to_double(self) -> f64 {
        self
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        Self::min(self, other)
    }
    #[inline]
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
}
