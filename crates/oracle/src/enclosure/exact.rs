//! Exact dyadic arithmetic for decisions that must not round: signs over the horizon, the side of the emitter, areas of needles.
//!
//! Sums and products of doubles are dyadic rationals, held here with as many bits as they need and an exponent of 32 bits, so
//! nothing under- or overflows for coordinates of any magnitude.

use std::ops::{Add, Mul, Neg, Sub};

use astro_float::{BigFloat, Sign, WORD_BIT_SIZE};

/// A dyadic rational.
#[derive(Debug, Clone)]
pub(crate) struct Exact(BigFloat);

/// `mantissa 2^exponent`, in two steps so that neither factor leaves the range of a double; 0 or infinite beyond it.
pub(crate) fn scaled(mantissa: f64, exponent: i32) -> f64 {
    libm::scalbn(mantissa, exponent)
}

impl Exact {
    /// Zero.
    pub(crate) fn zero() -> Self {
        Self(BigFloat::from_f64(0.0, 64))
    }

    /// The value of an arbitrary-precision number; not a number stays not a number.
    pub(crate) const fn from_inner(value: BigFloat) -> Self {
        Self(value)
    }

    /// The value as an arbitrary-precision number.
    pub(crate) const fn inner(&self) -> &BigFloat {
        &self.0
    }

    /// The value as an arbitrary-precision number, without a copy.
    pub(crate) fn into_inner(self) -> BigFloat {
        self.0
    }

    /// Whether this is zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// -1, 0 or 1.
    pub(crate) fn sign(&self) -> i32 {
        match self.0.sign() {
            _ if self.is_zero() => 0,
            Some(Sign::Neg) => -1,
            Some(Sign::Pos) | None => 1,
        }
    }

    /// The exponent `e` with `2^(e-1) <= |v| < 2^e`; 0 for 0.
    pub(crate) fn exponent(&self) -> i32 {
        if self.is_zero() { 0 } else { self.0.exponent().unwrap_or(0) }
    }

    /// Multiplied by `2^power`.
    pub(crate) fn times_power(&self, power: i32) -> Self {
        let mut result = self.clone();
        if !self.is_zero()
            && let Some(exponent) = self.0.exponent()
        {
            result.0.set_exponent(exponent + power);
        }
        result
    }

    /// The leading 53 bits as a double, rounded toward zero. Not a number gives not a number.
    pub(crate) fn leading(&self) -> f64 {
        rounded(&self.0, 0)
    }

    /// An upper bound of the absolute value, above it by at most one part in 2^52.
    pub(crate) fn magnitude(&self) -> f64 {
        if self.is_zero() { 0.0 } else { rounded(&self.0, 1).abs().max(f64::MIN_POSITIVE) }
    }
}

/// A double as a number of `bits` bits. The conversion of the arithmetic halves subnormal doubles, so those are lifted first.
pub(crate) fn big(value: f64, bits: usize) -> BigFloat {
    if value == 0.0 || value.abs() >= f64::MIN_POSITIVE {
        return BigFloat::from_f64(value, bits);
    }
    let mut lifted = BigFloat::from_f64(scaled(value, 64), bits);
    if let Some(exponent) = lifted.exponent() {
        lifted.set_exponent(exponent - 64);
    }
    lifted
}

/// The 53 leading bits, as an integer raised by `extra`, in the place they had.
pub(crate) fn rounded(value: &BigFloat, extra: u64) -> f64 {
    let Some((words, _, sign, exponent, _)) = value.as_raw_parts() else { return f64::NAN };
    if value.is_zero() {
        return 0.0;
    }
    let mut top = 0u64;
    for (place, word) in words.iter().rev().take(64 / WORD_BIT_SIZE).enumerate() {
        top |= *word << (64 - WORD_BIT_SIZE * (place + 1));
    }
    let magnitude = scaled(((top >> 11) + extra) as f64, exponent - 53);
    if sign == Sign::Neg { -magnitude } else { magnitude }
}

impl From<f64> for Exact {
    fn from(value: f64) -> Self {
        Self(big(value, 64))
    }
}

// The full-precision sum of the arithmetic loses the other operand when one is zero, hence the tests.
impl Add for &Exact {
    type Output = Exact;

    fn add(self, other: Self) -> Exact {
        match (self.is_zero(), other.is_zero()) {
            (true, _) => other.clone(),
            (_, true) => self.clone(),
            _ => Exact(self.0.add_full_prec(&other.0)),
        }
    }
}

impl Sub for &Exact {
    type Output = Exact;

    fn sub(self, other: Self) -> Exact {
        match (self.is_zero(), other.is_zero()) {
            (true, _) => -other,
            (_, true) => self.clone(),
            _ => Exact(self.0.sub_full_prec(&other.0)),
        }
    }
}

impl Mul for &Exact {
    type Output = Exact;

    fn mul(self, other: Self) -> Exact {
        if self.is_zero() || other.is_zero() { Exact::zero() } else { Exact(self.0.mul_full_prec(&other.0)) }
    }
}

impl Neg for &Exact {
    type Output = Exact;

    fn neg(self) -> Exact {
        Exact(-self.0.clone())
    }
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        (self - other).is_zero()
    }
}

/// A vector of exact components.
pub(crate) type ExactVector = [Exact; 3];

/// `a . b`.
pub(crate) fn dot(a: &ExactVector, b: &ExactVector) -> Exact {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

/// `a x b`.
pub(crate) fn cross(a: &ExactVector, b: &ExactVector) -> ExactVector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &(&a[j] * &b[k]) - &(&a[k] * &b[j])
    })
}

/// `a - b`.
pub(crate) fn difference(a: &ExactVector, b: &ExactVector) -> ExactVector {
    std::array::from_fn(|i| &a[i] - &b[i])
}

/// `a + scale b`.
pub(crate) fn along(a: &ExactVector, scale: f64, b: &ExactVector) -> ExactVector {
    let scale = Exact::from(scale);
    std::array::from_fn(|i| &a[i] + &(&scale * &b[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_lose_nothing() {
        let (large, small) = (Exact::from(1e300), Exact::from(5e-324));
        let sum = &large + &small;
        assert_eq!((&sum - &large).leading(), 5e-324);
        assert_eq!((&(&sum * &sum) - &(&large * &large)), &(&(&large * &small) + &(&large * &small)) + &(&small * &small));
        assert_eq!((&Exact::zero() + &small).leading(), 5e-324);
        assert_eq!((&Exact::zero() - &large).leading(), -1e300);
        assert_eq!((&small * &small).sign(), 1);
        assert!((&large - &large).is_zero());
    }

    #[test]
    fn leading_bits_and_magnitude_enclose() {
        let tenth = 0.1;
        let above = &Exact::from(tenth) + &Exact::from(1e-30);
        assert_eq!(above.leading(), tenth);
        assert_eq!(above.magnitude(), tenth.next_up());
        assert_eq!((-&above).leading(), -tenth);
        assert_eq!(above.times_power(-7).leading(), tenth / 128.0);
    }
}
