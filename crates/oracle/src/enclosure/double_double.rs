//! Double-double arithmetic: an unevaluated sum `hi + lo` of two doubles with `|lo| <= u |hi|`, u = 2^-53.
//!
//! Every operation returns its result with a proven bound on its rounding error, so nothing has to be assumed by the caller.
//! Building blocks are [`crate::error_free`]. Quotient and product follow Joldes, Muller and Popescu (ACM TOMS 44, 2017), whose theorems are quoted at each function. About 31 digits; fails to be exact
//! only where a double under- or overflows: overflow ends as a radius that is not finite, and the absolute error of an
//! underflow, below 2^-1060, is covered by the constant every ball operation adds.

use crate::enclosure::arithmetic::Real;
use crate::enclosure::exact::Exact;
use crate::enclosure::legendre::Rules;
use crate::error_free::{fast_two_sum, two_product, two_sum};

/// u^2 = 2^-106.
const U2: f64 = 1.0 / (1u128 << 106) as f64;

/// `hi + lo`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// Their `DWTimesFP1` (Algorithm 7), relative error at most 2u^2.
    #[inline]
    fn times(self, y: f64) -> Self {
        let (p, e) = two_product(self.hi, y);
        let (t, low) = fast_two_sum(p, self.lo * y);
        let (hi, lo) = fast_two_sum(t, low + e);
        Self { hi, lo }
    }
}

impl Real for DoubleDouble {
    #[inline]
    fn from_f64(value: f64, _bits: usize) -> Self {
        Self { hi: value, lo: 0.0 }
    }

    /// The leading 53 bits and the next 53; the rest is the error.
    fn from_exact(exact: &Exact, _bits: usize) -> (Self, f64) {
        let first = exact.leading();
        let remainder = exact - &Exact::from(first);
        let second = remainder.leading();
        let remainder = &remainder - &Exact::from(second);
        let (hi, lo) = fast_two_sum(first, second);
        (Self { hi, lo }, remainder.magnitude())
    }

    fn to_exact(&self) -> Exact {
        &Exact::from(self.hi) + &Exact::from(self.lo)
    }

    /// Their `SloppyDWPlusDW` with a full last sum. `lo_a + lo_b` rounds by at most `u^2 (|a| + |b|)`, the sum with the error
    /// of the leading terms by `2.01 u^2 (|a| + |b|)`: together below `4 u^2 (|a| + |b|)`, cancellation or not.
    #[inline]
    fn add(&self, other: &Self) -> (Self, f64) {
        let (s, e) = two_sum(self.hi, other.hi);
        let (hi, lo) = two_sum(s, e + (self.lo + other.lo));
        (Self { hi, lo }, 4.0 * U2 * (self.hi.abs() + other.hi.abs()))
    }

    #[inline]
    fn subtract(&self, other: &Self) -> (Self, f64) {
        self.add(&other.negated())
    }

    #[inline]
    fn negated(&self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// Their `DWTimesDW1` (Algorithm 10, Theorem 5.1): relative error at most 7u^2.
    #[inline]
    fn multiply(&self, other: &Self) -> (Self, f64) {
        let (p, e) = two_product(self.hi, other.hi);
        let cross = self.hi * other.lo + self.lo * other.hi;
        let (hi, lo) = fast_two_sum(p, e + cross);
        (Self { hi, lo }, 8.0 * U2 * hi.abs())
    }

    /// Their `DWDivDW2` (Algorithm 17, Theorem 7.1): relative error at most 15u^2 + 56u^3.
    #[inline]
    fn divide(&self, other: &Self) -> (Self, f64) {
        let first = self.hi / other.hi;
        let product = other.times(first);
        let second = ((self.hi - product.hi) + (self.lo - product.lo)) / other.hi;
        let (hi, lo) = fast_two_sum(first, second);
        (Self { hi, lo }, 16.0 * U2 * hi.abs())
    }

    #[inline]
    fn zero(&self) -> Self {
        Self { hi: 0.0, lo: 0.0 }
    }

    #[inline]
    fn one(&self) -> Self {
        Self { hi: 1.0, lo: 0.0 }
    }

    /// One Newton step from the root in double precision (Karp and Markstein, ACM TOMS 23, 1997).
    fn approximate_root(&self) -> Self {
        let root = self.hi.sqrt();
        let (square, error) = two_product(root, root);
        let residual = (self.hi - square) + (self.lo - error);
        let (hi, lo) = fast_two_sum(root, residual / (2.0 * root));
        Self { hi, lo }
    }

    #[inline]
    fn leading(&self) -> f64 {
        self.hi
    }

    fn rules() -> &'static Rules<Self> {
        static RULES: Rules<DoubleDouble> = Rules::new();
        &RULES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible stream of doubles of both signs with exponents from -20 to 20.
    struct Stream(u64);

    impl Stream {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let mantissa = (self.0 >> 11) as f64 / (1u64 << 53) as f64 + 0.5;
            let power = f64::from_bits((1003 + (self.0 >> 5) % 40) << 52);
            if self.0 & 16 == 0 { mantissa * power } else { -mantissa * power }
        }

        fn number(&mut self) -> DoubleDouble {
            let (hi, lo) = two_sum(self.next(), self.next() / (1u64 << 60) as f64);
            DoubleDouble { hi, lo }
        }
    }

    #[test]
    fn every_operation_keeps_its_bound() {
        let mut stream = Stream(1);
        let mut worst = [0.0f64; 4];
        for round in 0..20_000 {
            let (a, mut b) = (stream.number(), stream.number());
            if round % 3 == 0 {
                b = DoubleDouble { hi: -a.hi, lo: b.lo * f64::from_bits((1023 - 60) << 52) };
            }
            let (x, y) = (a.to_exact(), b.to_exact());
            let (sum, sum_bound) = a.add(&b);
            let (product, product_bound) = a.multiply(&b);
            let (quotient, quotient_bound) = a.divide(&b);
            let errors = [
                (&sum.to_exact() - &(&x + &y)).magnitude() / sum_bound,
                (&product.to_exact() - &(&x * &y)).magnitude() / product_bound,
                // |q - x/y| = |q y - x| / |y|
                (&(&quotient.to_exact() * &y) - &x).magnitude() / b.hi.abs() / quotient_bound,
                (sum.lo / sum.hi).abs() * (1u64 << 53) as f64,
            ];
            for (kind, error) in errors.into_iter().enumerate().filter(|(_, e)| !e.is_nan()) {
                worst[kind] = worst[kind].max(error);
            }
        }
        assert!(worst.iter().all(|w| *w <= 1.0), "{worst:?}");
        assert!(worst[..3].iter().all(|w| *w > 0.05), "a bound is far from reached, is it tested at all? {worst:?}");
    }
}
