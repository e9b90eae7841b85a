//! Arbitrary precision in Rust: `astro-float`, each operation rounded to nearest, so its error is at most `2^-bits` of the
//! result.

use astro_float::{BigFloat, RoundingMode, Sign, WORD_BIT_SIZE};

use crate::enclosure::arithmetic::Real;
use crate::enclosure::exact::{Exact, scaled};
use crate::enclosure::legendre::Rules;

const NEAREST: RoundingMode = RoundingMode::ToEven;

/// A number of `bits` bits, a multiple of 64.
#[derive(Debug, Clone)]
pub(crate) struct Astro {
    value: BigFloat,
    bits: usize,
}

impl Astro {
    fn rounded(value: BigFloat, bits: usize) -> (Self, f64) {
        let bound = half_unit(&value, bits);
        (Self { value, bits }, bound)
    }
}

/// Half a unit in the last of `bits` places of a number in `[2^(exponent-1), 2^exponent)`: the largest error of rounding to
/// nearest.
pub(crate) fn half_unit_at(exponent: i32, bits: usize) -> f64 {
    scaled(1.0, exponent - i32::try_from(bits).unwrap_or(i32::MAX / 2))
}

/// The leading 53 bits, rounded toward zero; NaN for an infinity.
fn leading(value: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = value.as_raw_parts() else { return f64::NAN };
    if value.is_zero() {
        return 0.0;
    }
    let mut top = 0u64;
    for (place, word) in words.iter().rev().take(64 / WORD_BIT_SIZE).enumerate() {
        top |= *word << (64 - WORD_BIT_SIZE * (place + 1));
    }
    let magnitude = scaled((top >> 11) as f64, exponent - 53);
    if sign == Sign::Neg { -magnitude } else { magnitude }
}

fn half_unit(result: &BigFloat, bits: usize) -> f64 {
    match result.exponent() {
        _ if result.is_zero() => 0.0,
        Some(exponent) if !result.is_inf() => half_unit_at(exponent, bits),
        _ => f64::INFINITY,
    }
}

impl Real for Astro {
    fn from_f64(value: f64, bits: usize) -> Self {
        Self { value: BigFloat::from_f64(value, bits), bits }
    }

    fn from_exact(exact: &Exact, bits: usize) -> (Self, f64) {
        let mut value = exact.to_big();
        if exact.is_zero() {
            return (Self::from_f64(0.0, bits), 0.0);
        }
        if value.set_precision(bits, NEAREST).is_err() {
            return (Self::from_f64(0.0, bits), f64::INFINITY);
        }
        Self::rounded(value, bits)
    }

    fn to_exact(&self) -> Exact {
        Exact::of_big(&self.value)
    }

    fn add(&self, other: &Self) -> (Self, f64) {
        let bits = self.bits.max(other.bits);
        Self::rounded(self.value.add(&other.value, bits, NEAREST), bits)
    }

    fn subtract(&self, other: &Self) -> (Self, f64) {
        let bits = self.bits.max(other.bits);
        Self::rounded(self.value.sub(&other.value, bits, NEAREST), bits)
    }

    fn multiply(&self, other: &Self) -> (Self, f64) {
        let bits = self.bits.max(other.bits);
        Self::rounded(self.value.mul(&other.value, bits, NEAREST), bits)
    }

    fn divide(&self, other: &Self) -> (Self, f64) {
        let bits = self.bits.max(other.bits);
        Self::rounded(self.value.div(&other.value, bits, NEAREST), bits)
    }

    fn negated(&self) -> Self {
        Self { value: -self.value.clone(), bits: self.bits }
    }

    fn zero(&self) -> Self {
        Self::from_f64(0.0, self.bits)
    }

    fn one(&self) -> Self {
        Self::from_f64(1.0, self.bits)
    }

    fn approximate_root(&self) -> Self {
        Self { value: self.value.sqrt(self.bits, NEAREST), bits: self.bits }
    }

    fn leading(&self) -> f64 {
        leading(&self.value)
    }

    fn rules() -> &'static Rules<Self> {
        static RULES: Rules<Astro> = Rules::new();
        &RULES
    }
}
