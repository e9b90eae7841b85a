//! Numbers of a fixed number of limbs, 192 to 512 bits, kept where they stand: no operation allocates.
//!
//! A number is `+-M 2^(exponent - 64 N)` with an integer M of 64 N bits whose first one is set, or 0. Operations cut what is below
//! the last place, after a guard limb where they subtract; so sums and products err by less than two units in the last place of
//! the result. The residual of a quotient, computed afterwards, bounds its error.

use astro_float::{BigFloat, Sign, WORD_BIT_SIZE, Word};

use crate::enclosure::arithmetic::Real;
use crate::enclosure::exact::{Exact, scaled};
use crate::enclosure::legendre::Rules;

/// A number of 64 N bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Limbs<const N: usize> {
    negative: bool,
    /// Of the first number beyond; any where the limbs are 0.
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

    /// The limbs and a guard below them, so many places down; what leaves the guard is cut.
    #[inline]
    fn shifted_down(&self, places: u32) -> ([u64; N], u64) {
        let (whole, bits) = ((places / 64) as usize, places % 64);
        // Limb i of an endless number with zeros at both ends.
        let limb = |i: usize| if i < N { self.limbs[i] } else { 0 };
        let at = |i: usize| if bits == 0 { limb(i) } else { limb(i) >> bits | limb(i + 1) << (64 - bits) };
        let guard = match whole {
            0 if bits == 0 => 0,
            0 => self.limbs[0] << (64 - bits),
            _ => at(whole - 1),
        };
        (std::array::from_fn(|i| at(i + whole)), guard)
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

    #[inline]
    fn product(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let mut product = [0u64; 2 * MOST];
        for (i, a) in self.limbs.iter().enumerate() {
            let mut carry = 0u128;
            for (j, b) in other.limbs.iter().enumerate() {
                let term = u128::from(*a) * u128::from(*b) + u128::from(product[i + j]) + carry;
                product[i + j] = low(term);
                carry = term >> 64;
            }
            product[i + N] = low(carry);
        }
        let limbs = std::array::from_fn(|i| product[i + N]);
        let exponent = self.exponent.saturating_add(other.exponent);
        Self::normalised(self.negative != other.negative, exponent, limbs, product[N - 1])
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
        if value == 0.0 {
            return Self::ZERO;
        }
        // Callers pass finite doubles: constants, reflectances, places along an edge.
        let (mantissa, exponent) = libm::frexp(value);
        let mut limbs = [0; N];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number of 53 bits")]
        let whole = (mantissa.abs() * (1u64 << 53) as f64) as u64;
        limbs[N - 1] = whole << 11;
        Self { negative: value < 0.0, exponent, limbs }
    }

    /// About one over the number, which is not 0.
    fn reciprocal(&self) -> Self {
        let of_mantissa = Self { negative: false, exponent: 0, limbs: self.limbs };
        let mut inverse = Self::of_double(1.0 / self.mantissa());
        let mut correct = 50;
        while correct < Self::BITS {
            // x + x (1 - b x)
            let rest = Self::of_double(1.0).sum(&of_mantissa.product(&inverse).opposite());
            inverse = inverse.sum(&inverse.product(&rest));
            correct *= 2;
        }
        Self { negative: self.negative, exponent: inverse.exponent.saturating_sub(self.exponent), ..inverse }
    }
}

/// The lower half.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "the half is what it is for")]
const fn low(wide: u128) -> u64 {
    wide as u64
}

/// Where the rules of each size are kept.
pub(crate) trait Kept: Sized {
    fn kept() -> &'static Rules<Self>;
}

macro_rules! kept {
    ($($n:literal)*) => {
        $(impl Kept for Limbs<$n> {
            fn kept() -> &'static Rules<Self> {
                static RULES: Rules<Limbs<$n>> = Rules::new();
                &RULES
            }
        })*
    };
}

kept!(3 4 5 6 7 8);

impl<const N: usize> Real for Limbs<N>
where
    Self: Kept,
{
    fn from_f64(value: f64, _bits: usize) -> Self {
        Self::of_double(value)
    }

    #[allow(clippy::useless_conversion, reason = "on some machines words have 32 bits")]
    fn from_exact(exact: &Exact, _bits: usize) -> (Self, f64) {
        let Some((words, _, sign, exponent, _)) = exact.inner().as_raw_parts() else { return (Self::ZERO, f64::INFINITY) };
        if exact.is_zero() {
            return (Self::ZERO, 0.0);
        }
        let per_limb = 64 / WORD_BIT_SIZE;
        let mut limbs = [0u64; N];
        let mut cut = false;
        for (place, word) in words.iter().rev().enumerate() {
            let (limb, part) = (place / per_limb, place % per_limb);
            match limbs.len().checked_sub(limb + 1) {
                Some(i) => limbs[i] |= u64::from(*word) << (64 - WORD_BIT_SIZE * (part + 1)),
                None => cut |= *word != 0,
            }
        }
        let found = Self::normalised(sign == Sign::Neg, exponent, limbs, 0);
        (found, if cut { found.two_units() } else { 0.0 })
    }

    fn to_exact(&self) -> Exact {
        if self.is_zero() {
            return Exact::zero();
        }
        let mut words: Vec<Word> = Vec::with_capacity(N * 64 / WORD_BIT_SIZE);
        for limb in self.limbs {
            for part in 0..64 / WORD_BIT_SIZE {
                #[allow(clippy::cast_possible_truncation, reason = "a word of the limb")]
                words.push((limb >> (part * WORD_BIT_SIZE)) as Word);
            }
        }
        let sign = if self.negative { Sign::Neg } else { Sign::Pos };
        Exact::from_inner(BigFloat::from_words(&words, sign, self.exponent))
    }

    #[inline]
    fn add(&self, other: &Self) -> (Self, f64) {
        let sum = self.sum(other);
        // Where all cancels what was cut is below the guard of the larger operand.
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

    /// With `r = a - q b`, `|a/b - q| = |r|/|b|`.
    fn divide(&self, other: &Self) -> (Self, f64) {
        if other.is_zero() {
            return (Self::ZERO, f64::INFINITY);
        }
        let inverse = other.reciprocal();
        let rough = self.product(&inverse);
        let rest = self.sum(&rough.product(other).opposite());
        let quotient = rough.sum(&rest.product(&inverse));
        let product = quotient.product(other);
        let rest = self.sum(&product.opposite());
        let most = rest.leading().abs() * (1.0 + 4.0 * f64::EPSILON) + product.two_units() + rest.two_units();
        let least = other.leading().abs() * (1.0 - 4.0 * f64::EPSILON);
        (quotient, if least > 0.0 { most / least * (1.0 + 4.0 * f64::EPSILON) } else { f64::INFINITY })
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
        Self::kept()
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
        Limbs<N>: Kept,
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
        let off = |found: &Limbs<N>, truth: &Exact| (&found.to_exact() - truth).magnitude();
        let (sum, bound) = x.add(&y);
        prop_assert!(off(&sum, &(&p + &q)) <= bound, "{:e} {bound:e}", off(&sum, &(&p + &q)));
        let (difference, bound) = x.subtract(&y);
        prop_assert!(off(&difference, &(&p - &q)) <= bound);
        let (product, bound) = x.multiply(&y);
        prop_assert!(off(&product, &(&p * &q)) <= bound);
        prop_assert!(bound <= product.leading().abs() * power_of_two(2 - Limbs::<N>::BITS));
        let (quotient, bound) = x.divide(&y);
        let rest = (&(&quotient.to_exact() * &q) - &p).magnitude();
        prop_assert!(rest <= bound * y.leading().abs() * (1.0 + 1e-12), "{rest:e} {bound:e}");
        prop_assert!(bound <= quotient.leading().abs() * power_of_two(6 - Limbs::<N>::BITS), "{bound:e}");
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
            check::<7>(a, b, bits, near)?;
        }
    }

    #[test]
    fn doubles_of_every_size_come_back() {
        for value in [1.0, -0.1, 1e300, 5e-324, -2.5e-310, f64::MAX, f64::MIN_POSITIVE, 0.0] {
            assert_eq!(Limbs::<3>::of_double(value).leading(), value);
            assert_eq!(Limbs::<3>::of_double(value).to_exact(), Exact::from(value));
        }
        let one = Limbs::<4>::of_double(1.0);
        assert!(one.subtract(&one).0.is_zero() && one.divide(&Limbs::ZERO).1.is_infinite());
    }
}
