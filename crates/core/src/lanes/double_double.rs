//! [`crate::scalar::double_double`] on lanes: the same operations in the same order, so the same digits.

use fearless_simd::{Simd, SimdBase, f64x4};

use crate::scalar::double_double::SPLIT;

/// Four double-doubles.
pub(crate) struct DoubleDoubles<S: Simd> {
    pub(crate) hi: f64x4<S>,
    pub(crate) lo: f64x4<S>,
}

impl<S: Simd> Clone for DoubleDoubles<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for DoubleDoubles<S> {}

impl<S: Simd> DoubleDoubles<S> {
    /// The exact difference of two doubles, times a power of two.
    #[inline(always)]
    pub(crate) fn difference(a: f64x4<S>, b: f64x4<S>, power: f64x4<S>) -> Self {
        let Self { hi, lo } = two_sum(a, -b);
        Self { hi: hi * power, lo: lo * power }
    }

    #[inline(always)]
    pub(crate) fn times(self, simd: S, other: Self) -> Self {
        let product = self.hi * other.hi;
        let ([a_high, a_low], [b_high, b_low]) = (halves(simd, self.hi), halves(simd, other.hi));
        let rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
        fast_two_sum(product, rest + (self.hi * other.lo + self.lo * other.hi))
    }

    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        let (s, t) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let v = fast_two_sum(s.hi, s.lo + t.hi);
        fast_two_sum(v.hi, t.lo + v.lo)
    }
}

#[inline(always)]
fn two_sum<S: Simd>(a: f64x4<S>, b: f64x4<S>) -> DoubleDoubles<S> {
    let hi = a + b;
    let b_seen = hi - a;
    DoubleDoubles { hi, lo: (a - (hi - b_seen)) + (b - b_seen) }
}

#[inline(always)]
fn fast_two_sum<S: Simd>(a: f64x4<S>, b: f64x4<S>) -> DoubleDoubles<S> {
    let hi = a + b;
    DoubleDoubles { hi, lo: b - (hi - a) }
}

#[inline(always)]
fn halves<S: Simd>(simd: S, a: f64x4<S>) -> [f64x4<S>; 2] {
    let c = f64x4::splat(simd, SPLIT) * a;
    let high = c - (c - a);
    [high, a - high]
}
