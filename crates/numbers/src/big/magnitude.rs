//! A double's digits with an exponent of its own: bounds far below 1e-308.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Sub};

use astro_float::BigFloat;

use crate::big::float::{mantissa_bits, shifted};
use crate::radius::Radius;

/// `mantissa 2^exponent`, the mantissa 0, infinite, not a number or of size in [1, 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnitude {
    mantissa: f64,
    exponent: i64,
}

impl Magnitude {
    fn new(mantissa: f64, exponent: i64) -> Self {
        if mantissa == 0.0 || !mantissa.is_finite() {
            return Self { mantissa, exponent: 0 };
        }
        let (fraction, shift) = libm::frexp(mantissa);
        Self { mantissa: 2.0 * fraction, exponent: exponent + i64::from(shift) - 1 }
    }

    /// `2^exponent`, exactly.
    pub const fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: 1.0, exponent }
    }

    /// Size of a number, from its leading 64 bits.
    pub fn of_number(number: &BigFloat) -> Self {
        match number.as_raw_parts() {
            Some((words, _, _, exponent, _)) => Self::new(mantissa_bits(words, 0) as f64, i64::from(exponent) - 64),
            None => Self::from(if number.is_nan() { f64::NAN } else { f64::INFINITY }),
        }
    }

    /// Logarithm to base two, off by at most 1e-9.
    pub fn log2(self) -> f64 {
        libm::log2(self.mantissa) + self.exponent as f64
    }

    /// `10^exponent`, off by at most a relative 1e-12 for the exponents of doubles and some thousand digits.
    pub fn power_of_ten(exponent: i64) -> Self {
        let power = (0..exponent.unsigned_abs()).fold(Self::from(1.0), |power, _| power * 10.0);
        if exponent < 0 { Self::from(1.0) / power } else { power }
    }

    /// The largest k with `10^k <= self`; next to a power of ten possibly the next one. 0 for 0.
    #[allow(clippy::cast_possible_truncation, reason = "a logarithm, far below 2^63")]
    pub fn decimal_exponent(self) -> i64 {
        if self.mantissa == 0.0 { 0 } else { (self.log2() * std::f64::consts::LOG10_2).floor() as i64 }
    }

    /// The number times this power of two.
    pub fn shift(self, number: &BigFloat) -> BigFloat {
        shifted(number, i32::try_from(self.exponent).unwrap_or(i32::MAX))
    }

    /// The mantissa moved to another exponent that is not smaller; bits below the range of doubles are lost, far below a roundoff
    /// of a mantissa that is there.
    fn aligned(self, exponent: i64) -> f64 {
        if !self.mantissa.is_finite() {
            return self.mantissa;
        }
        match i32::try_from(self.exponent - exponent) {
            Ok(shift) if shift > -200 => libm::scalbn(self.mantissa, shift),
            _ => 0.0,
        }
    }

    /// The exponent to which the two are aligned.
    fn common_exponent(self, other: Self) -> i64 {
        match (self.mantissa == 0.0, other.mantissa == 0.0) {
            (true, _) => other.exponent,
            (_, true) => self.exponent,
            _ => self.exponent.max(other.exponent),
        }
    }
}

impl From<f64> for Magnitude {
    fn from(value: f64) -> Self {
        Self::new(value, 0)
    }
}

impl Add for Magnitude {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let exponent = self.common_exponent(other);
        Self::new(self.aligned(exponent) + other.aligned(exponent), exponent)
    }
}

impl Sub for Magnitude {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { mantissa: -other.mantissa, ..other }
    }
}

impl Mul for Magnitude {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.mantissa * other.mantissa, self.exponent + other.exponent)
    }
}

impl Mul<f64> for Magnitude {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self::from(factor)
    }
}

impl Div for Magnitude {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self::new(self.mantissa / other.mantissa, self.exponent - other.exponent)
    }
}

impl PartialOrd for Magnitude {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let exponent = self.common_exponent(*other);
        self.aligned(exponent).partial_cmp(&other.aligned(exponent))
    }
}

impl Radius for Magnitude {
    fn sqrt(self) -> Self {
        let odd = self.exponent.rem_euclid(2);
        let mantissa = if odd == 1 { 2.0 * self.mantissa } else { self.mantissa };
        Self::new(mantissa.sqrt(), (self.exponent - odd) / 2)
    }

    /// Below the normal range the next double up.
    fn to_double(self) -> f64 {
        match i32::try_from(self.exponent) {
            Ok(exponent) if exponent >= -1022 => libm::scalbn(self.mantissa, exponent),
            Ok(exponent) => libm::scalbn(self.mantissa, exponent).next_up(),
            Err(_) if self.exponent > 0 => f64::INFINITY,
            Err(_) => f64::from_bits(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn arithmetic_is_that_of_doubles(a in 1e-30..1e30f64, b in 1e-30..1e30f64) {
            let (p, q) = (Magnitude::from(a), Magnitude::from(b));
            prop_assert_eq!((p + q).to_double(), a + b);
            prop_assert_eq!((p - q).to_double(), a - b);
            prop_assert_eq!((p * q).to_double(), a * b);
            prop_assert_eq!((p / q).to_double(), a / b);
            prop_assert_eq!(p.sqrt().to_double(), a.sqrt());
            prop_assert_eq!(p < q, a < b);
        }
    }

    #[test]
    fn the_range_is_wider_than_that_of_doubles() {
        let small = Magnitude::power_of_two(-4000) * 3.0;
        assert!(small > Magnitude::from(0.0) && small < Magnitude::from(5e-324) && small + small > small);
        assert_eq!(small.to_double(), 5e-324);
        assert_eq!((small * Magnitude::power_of_two(4000)).to_double(), 3.0);
        assert_eq!((small * small).sqrt(), small);
        assert_eq!((small - small).to_double(), 0.0);
        assert_eq!(Magnitude::power_of_two(4000).to_double(), f64::INFINITY);
        assert_eq!(Magnitude::power_of_two(-1074).to_double(), 1e-323);
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        let (one, nan, infinity) = (Magnitude::from(1.0), Magnitude::from(f64::NAN), Magnitude::from(f64::INFINITY));
        assert!((one + nan).to_double().is_nan() && (infinity - infinity).to_double().is_nan());
        assert_eq!((infinity + one).to_double(), f64::INFINITY);
        assert!(one < infinity && nan.partial_cmp(&one).is_none());
        assert_eq!((one / Magnitude::from(0.0)).to_double(), f64::INFINITY);
        assert_eq!((nan.max(one), one.min(nan)), (one, one));
    }
}
