//! Decimal numbers of hundreds of digits, to be subtracted.

use astro_float::{BigFloat, Consts, Radix, RoundingMode, Sign};

/// Bits of the numbers read: 450 digits.
const BITS: usize = 1536;
const NEAREST: RoundingMode = RoundingMode::ToEven;

/// A number of up to 450 digits.
#[derive(Debug, Clone)]
pub struct ManyDigits(BigFloat);

impl ManyDigits {
    /// Reads a decimal number.
    ///
    /// # Panics
    /// If the text is none.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let number = BigFloat::parse(text, Radix::Dec, BITS, NEAREST, &mut Consts::new().unwrap());
        assert!(!number.is_nan(), "{text}");
        Self(number)
    }

    /// The difference of two numbers.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        Self(self.0.sub(&other.0, BITS, NEAREST))
    }

    /// The quotient by a power of two or another double.
    #[must_use]
    pub fn over(&self, divisor: f64) -> Self {
        Self(self.0.div(&BigFloat::from_f64(divisor, 64), BITS, NEAREST))
    }

    /// The nearest double, to an ulp.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else { return f64::NAN };
        let size = libm::scalbn(words.last().copied().unwrap_or(0) as f64, exponent - 64);
        if sign == Sign::Neg { -size } else { size }
    }
}

impl From<f64> for ManyDigits {
    fn from(value: f64) -> Self {
        Self(BigFloat::from_f64(value, 64))
    }
}

/// Euclidean norm of the differences of components. Squares far from 1 would leave the range of a double.
#[must_use]
pub fn distance(a: &[ManyDigits], b: &[ManyDigits]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.minus(b).to_f64()).collect();
    let largest = differences.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    let part = |d: f64| d / largest * (d / largest);
    if largest == 0.0 { 0.0 } else { largest * differences.into_iter().map(part).sum::<f64>().sqrt() }
}
