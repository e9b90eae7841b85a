//! Arbitrary precision through MPFR, round to nearest: by its standard the same bits as [`crate::enclosure::astro`], from an
//! independent implementation.

use rug::float::Round;
use rug::integer::Order;
use rug::{Float, Integer};

use crate::enclosure::arithmetic::Real;
use crate::enclosure::astro::half_unit_at;
use crate::enclosure::exact::Exact;
use crate::enclosure::legendre::Rules;

/// A number of as many bits as it was made with.
#[derive(Debug, Clone)]
pub(crate) struct Mpfr(Float);

/// MPFR counts bits in 32-bit integers; more would not fit in memory.
fn precision(bits: usize) -> u32 {
    u32::try_from(bits).unwrap_or(u32::MAX / 2)
}

impl Mpfr {
    fn rounded(value: Float) -> (Self, f64) {
        let bound = match value.get_exp() {
            Some(exponent) => half_unit_at(exponent, value.prec() as usize),
            None if value.is_zero() => 0.0,
            None => f64::INFINITY,
        };
        (Self(value), bound)
    }

    fn wider(&self, other: &Self) -> u32 {
        self.0.prec().max(other.0.prec())
    }
}

impl Real for Mpfr {
    fn from_f64(value: f64, bits: usize) -> Self {
        Self(Float::with_val(precision(bits), value))
    }

    fn from_exact(exact: &Exact, bits: usize) -> (Self, f64) {
        let Some((negative, limbs, power)) = exact.parts() else {
            return (Self::from_f64(0.0, bits), f64::INFINITY);
        };
        if exact.is_zero() {
            return (Self::from_f64(0.0, bits), 0.0);
        }
        let mut value = Float::with_val(precision(bits), Integer::from_digits(limbs, Order::Lsf));
        value <<= power;
        if negative {
            value = -value;
        }
        Self::rounded(value)
    }

    fn to_exact(&self) -> Exact {
        let Some((mantissa, exponent)) = self.0.to_integer_exp() else {
            return Exact::nan();
        };
        Exact::of_integer(mantissa.is_negative(), &mantissa.to_digits(Order::Lsf), exponent)
    }

    fn add(&self, other: &Self) -> (Self, f64) {
        Self::rounded(Float::with_val(self.wider(other), &self.0 + &other.0))
    }

    fn subtract(&self, other: &Self) -> (Self, f64) {
        Self::rounded(Float::with_val(self.wider(other), &self.0 - &other.0))
    }

    fn multiply(&self, other: &Self) -> (Self, f64) {
        Self::rounded(Float::with_val(self.wider(other), &self.0 * &other.0))
    }

    fn divide(&self, other: &Self) -> (Self, f64) {
        Self::rounded(Float::with_val(self.wider(other), &self.0 / &other.0))
    }

    fn negated(&self) -> Self {
        Self(-self.0.clone())
    }

    fn zero(&self) -> Self {
        Self(Float::new(self.0.prec()))
    }

    fn one(&self) -> Self {
        Self(Float::with_val(self.0.prec(), 1))
    }

    fn approximate_root(&self) -> Self {
        Self(self.0.clone().sqrt())
    }

    fn leading(&self) -> f64 {
        self.0.to_f64_round(Round::Zero)
    }

    fn rules() -> &'static Rules<Self> {
        static RULES: Rules<Mpfr> = Rules::new();
        &RULES
    }
}
