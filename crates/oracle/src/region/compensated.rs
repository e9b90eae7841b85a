//! Sums and products of doubles kept to twice the precision, for the geometry a receiver point sees.
//!
//! A height over a plane or a distance to an edge is a small difference of large coordinates: in plain double precision its
//! relative error is `eps size / distance`, more than the tolerances asked of an oracle near contact. [`Pair`] is the
//! unevaluated sum `high + low`; each operation has a relative error below 2^-100, and the difference of two doubles is exact
//! ([`crate::error_free`]). It holds while nothing over- or underflows: callers normalise by a power of two first.
//! Once an integrand is evaluated, plain doubles serve, since every coordinate is then relative to the foot of the receiver.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::error_free::{two_product, two_sum};

/// An unevaluated sum with `|low| <= ulp(high)/2`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Pair {
    high: f64,
    low: f64,
}

/// Three pairs.
pub(crate) type PairVector = [Pair; 3];

impl Pair {
    pub(crate) const ZERO: Self = Self { high: 0.0, low: 0.0 };

    /// The exact difference of two doubles.
    pub(crate) fn difference(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, -b);
        Self { high, low }
    }

    /// Times a power of two: exact.
    pub(crate) fn scaled(self, power_of_two: f64) -> Self {
        Self { high: self.high * power_of_two, low: self.low * power_of_two }
    }

    /// The nearest double.
    pub(crate) fn rounded(self) -> f64 {
        self.high + self.low
    }

    /// One Newton step from the double root.
    pub(crate) fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 {
            return Self::ZERO;
        }
        let (high, low) = two_product(root, root);
        let (high, low) = two_sum(root, (self - Self { high, low }).rounded() / (2.0 * root));
        Self { high, low }
    }

    pub(crate) fn is_positive(self) -> bool {
        self.high > 0.0
    }

    pub(crate) fn is_negative(self) -> bool {
        self.high < 0.0
    }
}

impl From<f64> for Pair {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Pair {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = two_sum(self.high, other.high);
        let (t_high, t_low) = two_sum(self.low, other.low);
        let (high, low) = two_sum(high, low + t_high);
        let (high, low) = two_sum(high, low + t_low);
        Self { high, low }
    }
}

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Pair {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for Pair {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        let (high, low) = two_sum(high, low + (self.high * other.low + self.low * other.high));
        Self { high, low }
    }
}

impl Div for Pair {
    type Output = Self;
    /// Long division, three digits of base 2^53.
    fn div(self, divisor: Self) -> Self {
        let first = self.high / divisor.high;
        let remainder = self - divisor * Self::from(first);
        let second = remainder.high / divisor.high;
        let remainder = remainder - divisor * Self::from(second);
        let (high, low) = two_sum(first, second);
        Self { high, low } + Self::from(remainder.high / divisor.high)
    }
}

pub(crate) fn dot(a: PairVector, b: PairVector) -> Pair {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: PairVector, b: PairVector) -> PairVector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `v` over its length; `v` is first brought near unit size, since a needle's normal is short.
pub(crate) fn unit(v: PairVector) -> PairVector {
    let power = normalising_power(v.iter().map(|c| c.high.abs()).fold(0.0, f64::max));
    let v = v.map(|c| c.scaled(power));
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

/// The power of two that brings a positive normal double into [1, 2), the largest ones as near as there is one; 1 for anything else.
pub(crate) fn normalising_power(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) & 0x7ff;
    match exponent {
        1..=2045 if size > 0.0 => f64::from_bits((2046 - exponent) << 52),
        2046 if size > 0.0 => f64::MIN_POSITIVE / 2.0,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_keep_a_hundred_bits() {
        let third = Pair::from(1.0) / Pair::from(3.0);
        assert!(((third + third + third) - Pair::from(1.0)).rounded().abs() < 1e-31);
        let root = Pair::from(2.0).sqrt();
        assert!((root * root - Pair::from(2.0)).rounded().abs() < 1e-31);
        let tiny = Pair::difference(1.0, 1.0 + f64::EPSILON) + Pair::from(f64::EPSILON * (1.0 + f64::EPSILON));
        assert_eq!(tiny.rounded(), f64::EPSILON * f64::EPSILON);
    }

    #[test]
    fn a_short_vector_is_normalised() {
        let v = unit([Pair::from(3e-200), Pair::ZERO, Pair::from(4e-200)]);
        assert!((dot(v, v) - Pair::from(1.0)).rounded().abs() < 1e-31);
        assert!((v[0].rounded() - 0.6).abs() < 1e-16);
    }

    #[test]
    fn normalising_powers_are_exact() {
        for (size, power) in [(1.0, 1.0), (3.0, 0.5), (0.75, 2.0), (0.0, 1.0)] {
            assert_eq!(normalising_power(size), power);
        }
    }
}
