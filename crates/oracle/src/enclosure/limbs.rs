//! Numbers of a fixed number of limbs, 192 to 512 bits, kept where they stand: no operation allocates.
//!
//! A number is `+-M 2^(exponent - 64 N)` with an integer M of 64 N bits whose first one is set, or 0. Operations cut the digits below
//! the last place, after a guard limb where they subtract; so sums and products err by less than two units in the last place of
//! the result. A quotient comes with the residual of its last step of Newton's, which bounds its error.

use crate::enclosure::arithmetic::Real;
use crate::enclosure::exact::{Exact, scaled};
use crate::enclosure::legendre::Rules;
use crate::error_free::two_product;

/// A number of 64 N bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Limbs<const N: usize> {
    negative: bool,
    /// Power of two above the number; any where the limbs are 0.
    exponent: i32,
    /// The lowest first.
    limbs: [u64; N],
}

/// Largest N.
const MOST: usize = 8;

/// `2^exponent`.
#[inline]
fn power_of_two(exponent: i32) -> f64 {
    match u64::try_from(exponent.saturating_add(1023)) {
        Ok(biased @ 1..=2046) => f64::from_bits(biased << 52),
        _ => scaled(1.0, exponent),
    }
}

impl<const N: usize> Limbs<N> {
    const ZERO: Self = Self { negative: false, exponent: 0, limbs: [0; N] };

    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "eight limbs at most")]
    const BITS: i32 = 64 * N as i32;

    /// Bound on the error of an operation relative to its result: two units in the last place.
    const RELATIVE: f64 = f64::from_bits(((1023 + 2 - Self::BITS) as u64) << 52);

    #[inline]
    const fn is_zero(&self) -> bool {
        self.limbs[N - 1] == 0
    }

    /// Two units in the last place.
    #[inline]
    fn two_units(&self) -> f64 {
        if self.is_zero() { 0.0 } else { power_of_two(self.exponent.saturating_sub(Self::BITS - 1)) }
    }

    /// The first bit set where it is to be, from limbs and a guard below them.
    #[inline]
    fn normalised(negative: bool, exponent: i32, mut limbs: [u64; N], mut guard: u64) -> Self {
        let mut exponent = exponent;
        let mut whole = 0;
        while limbs[N - 1] == 0 {
            // With the guard there are N + 1 of them.
            if whole > N {
                return Self::ZERO;
            }
            for i in (1..N).rev() {
                limbs[i] = limbs[i - 1];
            }
            (limbs[0], guard) = (guard, 0);
            exponent = exponent.saturating_sub(64);
            whole += 1;
        }
        let shift = limbs[N - 1].leading_zeros();
        if shift > 0 {
            for i in (1..N).rev() {
                limbs[i] = limbs[i] << shift | limbs[i - 1] >> (64 - shift);
            }
            limbs[0] = limbs[0] << shift | guard >> (64 - shift);
            exponent = exponent.saturating_sub(shift.cast_signed());
        }
        Self { negative, exponent, limbs }
    }

    /// The limbs and a guard below them, so many places down; digits below the guard are cut.
    #[inline]
    fn shifted_down(&self, places: u32) -> ([u64; N], u64) {
        let (whole, bits) = ((places / 64) as usize, places % 64);
        // Limb i of an endless number with zeros at both ends.
        let limb = |i: usize| if i < N { self.limbs[i] } else { 0 };
        let shifted = |i: usize| if bits == 0 { limb(i) } else { limb(i) >> bits | limb(i + 1) << (64 - bits) };
        let guard = match whole {
            0 if bits == 0 => 0,
            0 => self.limbs[0] << (64 - bits),
            _ => shifted(whole - 1),
        };
        (std::array::from_fn(|i| shifted(i + whole)), guard)
    }

    #[inline]
    fn compare_size(&self, other: &Self) -> std::cmp::Ordering {
        match (self.is_zero(), other.is_zero()) {
            (true, true) => std::cmp::Ordering::Equal,
            (true, false) => std::cmp::Ordering::Less,
            (false, true) => std::cmp::Ordering::Greater,
            _ => self.exponent.cmp(&other.exponent).then_with(|| self.limbs.iter().rev().cmp(other.limbs.iter().rev())),
        }
    }

    #[inline]
    fn sum(&self, other: &Self) -> Self {
        if other.is_zero() {
            return *self;
        }
        if self.is_zero() {
            return *other;
        }
        let (large, small) = if self.compare_size(other).is_lt() { (other, self) } else { (self, other) };
        let places = large.exponent.abs_diff(small.exponent);
        // Below the guard of the larger one.
        if places > Self::BITS.unsigned_abs() + 64 {
            return *large;
        }
        let (shifted, guard) = small.shifted_down(places);
        let mut limbs = large.limbs;
        if large.negative == small.negative {
            let mut carry = false;
            for (limb, term) in limbs.iter_mut().zip(shifted) {
                let (sum, over) = limb.overflowing_add(term);
                let (sum, again) = sum.overflowing_add(u64::from(carry));
                (*limb, carry) = (sum, over | again);
            }
            let mut exponent = large.exponent;
            if carry {
                for i in 0..N - 1 {
                    limbs[i] = limbs[i] >> 1 | limbs[i + 1] << 63;
                }
                limbs[N - 1] = limbs[N - 1] >> 1 | 1 << 63;
                exponent = exponent.saturating_add(1);
            }
            return Self { negative: large.negative, exponent, limbs };
        }
        let (low, mut borrow) = 0u64.overflowing_sub(guard);
        for (limb, term) in limbs.iter_mut().zip(shifted) {
            let (difference, over) = limb.overflowing_sub(term);
            let (difference, again) = difference.overflowing_sub(u64::from(borrow));
            (*limb, borrow) = (difference, over | again);
        }
        Self::normalised(large.negative, large.exponent, limbs, low)
    }

    /// Products below the guard are left out: less than N units of the guard.
    #[inline]
    fn product(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let mut product = [0u64; 2 * MOST];
        for (i, a) in self.limbs.iter().enumerate() {
            let mut carry = 0u128;
            for j in N.saturating_sub(i + 2)..N {
                let term =
                    (u128::from(*a) * u128::from(other.limbs[j])).wrapping_add(u128::from(product[i + j])).wrapping_add(carry);
                product[i + j] = low(term);
                carry = term >> 64;
            }
            product[i + N] = low(carry);
        }
        let mut limbs: [u64; N] = std::array::from_fn(|i| product[i + N]);
        let mut exponent = self.exponent.saturating_add(other.exponent);
        // Both are at least a half, so that the product is at least a quarter.
        if limbs[N - 1] >> 63 == 0 {
            for i in (1..N).rev() {
                limbs[i] = limbs[i] << 1 | limbs[i - 1] >> 63;
            }
            limbs[0] = limbs[0] << 1 | product[N - 1] >> 63;
            exponent = exponent.saturating_sub(1);
        }
        Self { negative: self.negative != other.negative, exponent, limbs }
    }

    #[inline]
    const fn opposite(&self) -> Self {
        Self { negative: !self.negative, ..*self }
    }

    /// A number in [1/2, 1) with the same limbs, as the nearest double or one next to it.
    #[inline]
    fn mantissa(&self) -> f64 {
        (self.limbs[N - 1] >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    #[inline]
    fn of_double(value: f64) -> Self {
        let bits = value.to_bits();
        let (biased, fraction) = ((bits >> 52) & 0x7ff, bits & ((1 << 52) - 1));
        if biased == 0 {
            debug_assert!(fraction == 0, "{value} is subnormal");
            return Self::ZERO;
        }
        let mut limbs = [0; N];
        limbs[N - 1] = (fraction | 1 << 52) << 11;
        Self { negative: value < 0.0, exponent: i32::try_from(biased).unwrap_or(0) - 1022, limbs }
    }
}

impl<const N: usize> Limbs<N>
where
    Self: CachedRules,
{
    /// About one over the number, which is not 0, and a bound on the relative error.
    ///
    /// With `r = 1 - b y` the error of `y (1 + r)` is `r^2`, that of `y (1 + r + r^2)` is `r^3`. An operation errs by less than
    /// `w = 2^(2 - 64 N)` of its result; so r is known to `2.1 w`, and with the last product and sum the result to `3.3 w` more.
    fn reciprocal(&self) -> (Self, f64) {
        let of_mantissa = Self { negative: false, exponent: 0, limbs: self.limbs };
        let mut inverse = of_mantissa.rough_reciprocal();
        let mut correct = ROUGH;
        loop {
            let defect = Self::of_double(1.0).sum(&of_mantissa.product(&inverse).opposite());
            let is_cubic = 2 * correct < Self::BITS && (3 * correct >= Self::BITS || 4 * correct < Self::BITS);
            let change = if is_cubic { defect.sum(&defect.product(&defect)) } else { defect };
            inverse = inverse.sum(&inverse.product(&change));
            correct *= if is_cubic { 3 } else { 2 };
            if correct >= Self::BITS {
                let size = defect.leading().abs() * (1.0 + 4.0 * f64::EPSILON) + 2.1 * Self::RELATIVE;
                let power = if is_cubic { size * size * size } else { size * size };
                let exponent = inverse.exponent.saturating_sub(self.exponent);
                return (Self { negative: self.negative, exponent, ..inverse }, (power + 3.3 * Self::RELATIVE) * (1.0 + 1e-9));
            }
        }
    }

    /// One over a number in [1/2, 1) to about [`ROUGH`] bits, by one step of Newton's in doubles.
    #[inline]
    fn rough_reciprocal(&self) -> Self {
        let (first, second) = (self.limbs[N - 1], self.limbs[N - 2]);
        let high = (first >> 11) as f64 * UNIT;
        let low = ((first & 0x7ff) << 42 | second >> 22) as f64 * (UNIT * UNIT);
        let inverse = 1.0 / high;
        let (product, error) = two_product(high, inverse);
        let defect = ((1.0 - product) - error) - low * inverse;
        Self::of_double(inverse).sum(&Self::of_double(inverse * defect))
    }
}

/// `2^-53`.
const UNIT: f64 = 1.0 / (1u64 << 53) as f64;

/// Correct bits of a reciprocal made of two doubles. It chooses the number of steps only: the error is computed.
const ROUGH: i32 = 99;

/// The lower half.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "the half is what it is for")]
const fn low(wide: u128) -> u64 {
    wide as u64
}

/// The cached rules of each size.
pub(crate) trait CachedRules: Sized {
    fn cached() -> &'static Rules<Self>;
}

macro_rules! cached_rules {
    ($($n:literal)*) => {
        $(impl CachedRules for Limbs<$n> {
            fn cached() -> &'static Rules<Self> {
                static RULES: Rules<Limbs<$n>> = Rules::new();
                &RULES
            }
        })*
    };
}

cached_rules!(3 4 5 6 7 8);

impl<const N: usize> Real for Limbs<N>
where
    Self: CachedRules,
{
    fn from_f64(value: f64, _bits: usize) -> Self {
        Self::of_double(value)
    }

    fn from_exact(exact: &Exact, _bits: usize) -> (Self, f64) {
        let Some((negative, digits, _)) = exact.parts() else { return (Self::ZERO, f64::INFINITY) };
        let leading = &digits[digits.len().saturating_sub(N + 1)..];
        // The first limb of the number is not 0, so with the guard all places are filled.
        let limb = |i: usize| leading.len().checked_sub(N - i).map_or(0, |at| leading[at]);
        let guard = leading.len().checked_sub(N + 1).map_or(0, |at| leading[at]);
        let places = exact.exponent();
        // Where the first bit is set in the first limb.
        let lifted = leading.last().map_or(0, |first| first.leading_zeros().cast_signed());
        let rounded = Self::normalised(negative, places + lifted, std::array::from_fn(limb), guard);
        let is_cut = digits.len() > N + 1 || guard << lifted != 0;
        (rounded, if is_cut { rounded.two_units() } else { 0.0 })
    }

    fn to_exact(&self) -> Exact {
        Exact::of_integer(self.negative, &self.limbs, self.exponent.saturating_sub(Self::BITS))
    }

    #[inline]
    fn add(&self, other: &Self) -> (Self, f64) {
        let sum = self.sum(other);
        // Where all digits cancel, the cut ones are below the guard of the larger operand.
        let bound = if sum.is_zero() { 0.0 } else { sum.two_units() };
        (sum, bound)
    }

    #[inline]
    fn subtract(&self, other: &Self) -> (Self, f64) {
        self.add(&other.opposite())
    }

    #[inline]
    fn multiply(&self, other: &Self) -> (Self, f64) {
        let product = self.product(other);
        (product, product.two_units())
    }

    fn divide(&self, other: &Self) -> (Self, f64) {
        if other.is_zero() {
            return (Self::ZERO, f64::INFINITY);
        }
        let (inverse, relative) = other.reciprocal();
        let quotient = self.product(&inverse);
        (quotient, quotient.leading().abs() * relative * (1.0 + 1e-9) + quotient.two_units())
    }

    #[inline]
    fn negated(&self) -> Self {
        self.opposite()
    }

    fn zero(&self) -> Self {
        Self::ZERO
    }

    fn one(&self) -> Self {
        Self::of_double(1.0)
    }

    fn approximate_root(&self) -> Self {
        if self.is_zero() || self.negative {
            return Self::ZERO;
        }
        // The root of a number in [1/4, 1) with an even exponent.
        let odd = self.exponent.rem_euclid(2);
        let reduced = Self { negative: false, exponent: -odd, limbs: self.limbs };
        let mut root = Self::of_double((self.mantissa() * power_of_two(-odd)).sqrt());
        let mut correct = 50;
        while correct < Self::BITS {
            let mean = root.sum(&reduced.divide(&root).0);
            root = Self { exponent: mean.exponent - 1, ..mean };
            correct *= 2;
        }
        Self { exponent: root.exponent.saturating_add((self.exponent.saturating_add(odd)) / 2), ..root }
    }

    #[inline]
    fn leading(&self) -> f64 {
        if self.is_zero() {
            return 0.0;
        }
        let size = (self.limbs[N - 1] >> 11) as f64;
        let power = self.exponent.saturating_sub(53);
        let size = match u64::try_from(power.saturating_add(1023)) {
            Ok(biased @ 1..=1990) => size * f64::from_bits(biased << 52),
            _ => scaled(size, power),
        };
        if self.negative { -size } else { size }
    }

    fn rules() -> &'static Rules<Self> {
        Self::cached()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A number with all limbs filled.
    fn number<const N: usize>(value: f64, low: u64) -> Limbs<N> {
        let mut number = Limbs::of_double(value);
        for (i, limb) in (0..).zip(number.limbs.iter_mut().take(N - 1)) {
            *limb = low.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(7 * i) ^ low;
        }
        number
    }

    fn check<const N: usize>(a: f64, b: f64, bits: u64, near: u32) -> Result<(), TestCaseError>
    where
        Limbs<N>: CachedRules,
    {
        let x = number::<N>(a, bits);
        // Close to -x in one case of two, so that sums cancel.
        let y = if near.is_multiple_of(2) {
            number::<N>(b, !bits)
        } else {
            Limbs {
                limbs: {
                    let mut l = x.limbs;
                    l[0] ^= bits >> (near % 64);
                    l
                },
                ..x.opposite()
            }
        };
        let (p, q) = (x.to_exact(), y.to_exact());
        prop_assert_eq!(Limbs::<N>::from_exact(&p, 64 * N), (x, 0.0));
        let error = |computed: &Limbs<N>, truth: &Exact| (&computed.to_exact() - truth).magnitude();
        let (sum, bound) = x.add(&y);
        prop_assert!(error(&sum, &(&p + &q)) <= bound, "{:e} {bound:e}", error(&sum, &(&p + &q)));
        let (difference, bound) = x.subtract(&y);
        prop_assert!(error(&difference, &(&p - &q)) <= bound);
        let (product, bound) = x.multiply(&y);
        prop_assert!(error(&product, &(&p * &q)) <= bound);
        prop_assert!(bound <= product.leading().abs() * power_of_two(2 - Limbs::<N>::BITS));
        let (quotient, bound) = x.divide(&y);
        let residual = (&(&quotient.to_exact() * &q) - &p).magnitude();
        prop_assert!(residual <= bound * y.leading().abs() * (1.0 + 1e-12), "{residual:e} {bound:e}");
        // The rules of Gauss and Legendre rely on this bound.
        prop_assert!(bound <= 22.0 * quotient.leading().abs() * power_of_two(-Limbs::<N>::BITS), "{bound:e}");
        let positive = Limbs { negative: false, ..x };
        let root = positive.approximate_root();
        let square = root.product(&root);
        let apart = square.sum(&positive.opposite()).leading().abs();
        prop_assert!(apart <= positive.leading() * power_of_two(6 - Limbs::<N>::BITS), "{apart:e}");
        Ok(())
    }

    proptest! {
        #[test]
        fn every_operation_keeps_its_bound(a in -1e3..1e3f64, scale in -40..40i32, b in 0.5..1.0f64, bits: u64, near: u32) {
            prop_assume!(a != 0.0);
            let b = b * power_of_two(scale);
            check::<3>(a, b, bits, near)?;
            check::<4>(a, -b, bits, near)?;
            check::<5>(a, b, bits, near)?;
            check::<6>(a, -b, bits, near)?;
            check::<7>(a, b, bits, near)?;
            check::<8>(a, b, bits, near)?;
        }
    }

    #[test]
    fn doubles_of_every_size_come_back() {
        for value in [1.0, -0.1, 1e300, f64::MAX, f64::MIN_POSITIVE, 0.0] {
            assert_eq!(Limbs::<3>::of_double(value).leading(), value);
            assert_eq!(Limbs::<3>::of_double(value).to_exact(), Exact::from(value));
        }
        let one = Limbs::<4>::of_double(1.0);
        assert!(one.subtract(&one).0.is_zero() && one.divide(&Limbs::ZERO).1.is_infinite());
    }
}
