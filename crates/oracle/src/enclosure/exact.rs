//! Exact dyadic arithmetic for decisions that must not round: signs over the horizon, the side of the emitter, areas of needles.
//!
//! Sums and products of doubles are dyadic rationals, held here with as many bits as they need and an exponent of their own, so
//! nothing under- or overflows for coordinates of any magnitude. Limbs stand at multiples of 64 places, so that sums need no
//! shifts, and are kept where the number stands while there are few: no operation on doubles of one size allocates.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use astro_float::{BigFloat, Sign, WORD_BIT_SIZE, Word};

/// A dyadic rational: `+-M 2^(64 place)`, M the integer of the limbs, of which neither the first nor the last is 0.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    /// False for NaN; every operation on NaN gives NaN.
    is_number: bool,
    negative: bool,
    place: i32,
    limbs: Limbs,
}

/// Limbs that are kept where they stand.
const FEW: usize = 12;

/// Limbs, the lowest first.
#[derive(Debug, Clone)]
enum Limbs {
    Few([u64; FEW], usize),
    Many(Vec<u64>),
}

impl Limbs {
    /// So many limbs, all 0.
    fn zeros(count: usize) -> Self {
        if count <= FEW { Self::Few([0; FEW], count) } else { Self::Many(vec![0; count]) }
    }

    fn get(&self) -> &[u64] {
        match self {
            Self::Few(limbs, count) => &limbs[..*count],
            Self::Many(limbs) => limbs,
        }
    }

    fn get_mut(&mut self) -> &mut [u64] {
        match self {
            Self::Few(limbs, count) => &mut limbs[..*count],
            Self::Many(limbs) => limbs,
        }
    }

    /// The limbs from `start` to `end`.
    fn cut(mut self, start: usize, end: usize) -> Self {
        match &mut self {
            Self::Few(limbs, count) => {
                if start > 0 {
                    limbs.copy_within(start..end, 0);
                }
                *count = end - start;
            }
            Self::Many(limbs) => {
                limbs.truncate(end);
                limbs.drain(..start);
            }
        }
        self
    }
}

/// `2^exponent`, for exponents of normal doubles.
fn power_of_two(exponent: i32) -> Option<f64> {
    match u64::try_from(exponent.saturating_add(1023)) {
        Ok(biased @ 1..=2046) => Some(f64::from_bits(biased << 52)),
        _ => None,
    }
}

/// `mantissa 2^exponent`, rounded once; 0 or infinite beyond the range of a double.
pub(crate) fn scaled(mantissa: f64, exponent: i32) -> f64 {
    power_of_two(exponent).map_or_else(|| libm::scalbn(mantissa, exponent), |power| mantissa * power)
}

/// A place as a number of limbs, and of bits above it.
const fn split(places: i32) -> (i32, u32) {
    (places.div_euclid(64), places.rem_euclid(64).unsigned_abs())
}

/// The number of limbs of a list; none has two billion.
fn count(limbs: &[u64]) -> i32 {
    i32::try_from(limbs.len()).unwrap_or(i32::MAX / 128)
}

/// How far above `low` a place is; callers see to it that it is not below.
fn above(place: i32, low: i32) -> usize {
    usize::try_from(place.saturating_sub(low)).unwrap_or(0)
}

/// The lower half.
#[expect(clippy::cast_possible_truncation, reason = "the half is what it is for")]
const fn low(wide: u128) -> u64 {
    wide as u64
}

impl Exact {
    /// Zero.
    pub(crate) const fn zero() -> Self {
        Self { is_number: true, negative: false, place: 0, limbs: Limbs::Few([0; FEW], 0) }
    }

    /// NaN.
    pub(crate) const fn nan() -> Self {
        Self { is_number: false, negative: false, place: 0, limbs: Limbs::Few([0; FEW], 0) }
    }

    /// The number of limbs of which some at either end may be 0.
    fn trimmed(negative: bool, place: i32, limbs: Limbs) -> Self {
        let digits = limbs.get();
        let Some(start) = digits.iter().position(|limb| *limb != 0) else { return Self::zero() };
        let end = digits.iter().rposition(|limb| *limb != 0).map_or(digits.len(), |last| last + 1);
        let first = place + count(&digits[..start]);
        Self { is_number: true, negative, place: first, limbs: limbs.cut(start, end) }
    }

    /// `+-M 2^power`, M the integer of the limbs.
    pub(crate) fn of_integer(negative: bool, limbs: &[u64], power: i32) -> Self {
        let (place, bits) = split(power);
        let mut shifted = Limbs::zeros(limbs.len() + 1);
        let mut carry = 0;
        let digits = shifted.get_mut();
        for (to, limb) in digits.iter_mut().zip(limbs) {
            let wide = u128::from(*limb) << bits;
            *to = low(wide) | carry;
            carry = low(wide >> 64);
        }
        digits[limbs.len()] = carry;
        Self::trimmed(negative, place, shifted)
    }

    /// The value of an arbitrary-precision number; NaN for an infinity.
    pub(crate) fn of_big(value: &BigFloat) -> Self {
        if value.is_zero() {
            return Self::zero();
        }
        let Some((words, _, sign, exponent, _)) = value.as_raw_parts() else { return Self::nan() };
        let limbs: Vec<u64> = words.chunks(64 / WORD_BIT_SIZE).map(joined).collect();
        let bits = i32::try_from(words.len() * WORD_BIT_SIZE).unwrap_or(i32::MAX / 2);
        Self::of_integer(sign == Sign::Neg, &limbs, exponent - bits)
    }

    /// The value as an arbitrary-precision number.
    pub(crate) fn to_big(&self) -> BigFloat {
        if !self.is_number {
            return BigFloat::nan(None);
        }
        if self.is_zero() {
            return BigFloat::from_f64(0.0, 64);
        }
        let digits = self.limbs.get();
        let zeros = digits[digits.len() - 1].leading_zeros();
        let mut words: Vec<Word> = Vec::with_capacity(digits.len() * 64 / WORD_BIT_SIZE);
        let mut below = 0;
        for limb in digits {
            let wide = u128::from(*limb) << zeros;
            parted(low(wide) | below, &mut words);
            below = low(wide >> 64);
        }
        BigFloat::from_words(&words, if self.negative { Sign::Neg } else { Sign::Pos }, self.exponent())
    }

    /// Sign, limbs with the lowest first, and the power of two at the lowest bit; `None` for NaN.
    pub(crate) fn parts(&self) -> Option<(bool, &[u64], i32)> {
        self.is_number.then(|| (self.negative, self.limbs.get(), 64 * self.place))
    }

    /// Whether this is zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.is_number && self.limbs.get().is_empty()
    }

    /// -1, 0 or 1.
    pub(crate) fn sign(&self) -> i32 {
        match self.negative {
            _ if self.is_zero() => 0,
            true => -1,
            false => 1,
        }
    }

    /// The exponent `e` with `2^(e-1) <= |v| < 2^e`; 0 for 0.
    pub(crate) fn exponent(&self) -> i32 {
        let digits = self.limbs.get();
        let zeros = |last: &u64| last.leading_zeros().cast_signed();
        digits.last().map_or(0, |last| 64 * (self.place + count(digits)) - zeros(last))
    }

    /// Multiplied by `2^power`.
    pub(crate) fn times_power(&self, power: i32) -> Self {
        if !self.is_number || self.is_zero() {
            return self.clone();
        }
        match split(power) {
            (places, 0) => Self { place: self.place + places, ..self.clone() },
            _ => Self::of_integer(self.negative, self.limbs.get(), 64 * self.place + power),
        }
    }

    /// The leading 53 bits as a double, rounded toward zero. Not a number gives not a number.
    pub(crate) fn leading(&self) -> f64 {
        if self.is_number { self.cut(0) } else { f64::NAN }
    }

    /// An upper bound of the absolute value, above it by at most one part in 2^52; infinite if it is not a number.
    pub(crate) fn magnitude(&self) -> f64 {
        match self.is_number {
            false => f64::INFINITY,
            true if self.is_zero() => 0.0,
            true => {
                let size = self.cut(1).abs();
                if size < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { size }
            }
        }
    }

    /// The 53 leading bits, as an integer raised by `extra`, in the place they had.
    fn cut(&self, extra: u64) -> f64 {
        let digits = self.limbs.get();
        let Some((last, lower)) = digits.split_last() else { return 0.0 };
        let zeros = last.leading_zeros();
        let below = lower.last().map_or(0, |below| if zeros == 0 { 0 } else { below >> (64 - zeros) });
        let top = last << zeros | below;
        let size = scaled(((top >> 11) + extra) as f64, self.exponent() - 53);
        if self.negative { -size } else { size }
    }

    /// Compares absolute values.
    fn compare_size(&self, other: &Self) -> Ordering {
        let (a, b) = (self.limbs.get(), other.limbs.get());
        match (a.is_empty(), b.is_empty()) {
            (true, true) => return Ordering::Equal,
            (true, false) => return Ordering::Less,
            (false, true) => return Ordering::Greater,
            (false, false) => {}
        }
        let by_exponent = self.exponent().cmp(&other.exponent());
        // Where one has more limbs and all of the other's are the same, its lowest is not 0.
        by_exponent.then_with(|| a.iter().rev().cmp(b.iter().rev()))
    }

    /// `self + other`, or `self - other`.
    fn plus(&self, other: &Self, is_difference: bool) -> Self {
        if !(self.is_number && other.is_number) {
            return Self::nan();
        }
        let other_negative = other.negative != is_difference;
        if other.is_zero() {
            return self.clone();
        }
        if self.is_zero() {
            return Self { negative: other_negative, ..other.clone() };
        }
        let (a, b) = (self.limbs.get(), other.limbs.get());
        let place = self.place.min(other.place);
        let end = (self.place + count(a)).max(other.place + count(b));
        let mut sum = Limbs::zeros(above(end, place) + 1);
        let adds = self.negative == other_negative;
        let larger_is_self = adds || self.compare_size(other).is_ge();
        let (large, small, negative) = if larger_is_self { (self, other, self.negative) } else { (other, self, other_negative) };
        let digits = sum.get_mut();
        let from = above(large.place, place);
        digits[from..from + large.limbs.get().len()].copy_from_slice(large.limbs.get());
        let overlap = &mut digits[above(small.place, place)..];
        if adds {
            add_into(overlap, small.limbs.get());
        } else {
            subtract_from(overlap, small.limbs.get());
        }
        Self::trimmed(negative, place, sum)
    }
}

/// Adds to the lowest limbs; there is room for the carry.
fn add_into(digits: &mut [u64], terms: &[u64]) {
    let mut carry = false;
    let zeros = std::iter::repeat(&0);
    for (index, (limb, term)) in digits.iter_mut().zip(terms.iter().chain(zeros)).enumerate() {
        if index >= terms.len() && !carry {
            return;
        }
        let (sum, over) = limb.overflowing_add(*term);
        let (sum, again) = sum.overflowing_add(u64::from(carry));
        (*limb, carry) = (sum, over | again);
    }
}

/// Subtracts from the lowest limbs of a larger number.
fn subtract_from(digits: &mut [u64], terms: &[u64]) {
    let mut borrow = false;
    let zeros = std::iter::repeat(&0);
    for (index, (limb, term)) in digits.iter_mut().zip(terms.iter().chain(zeros)).enumerate() {
        if index >= terms.len() && !borrow {
            return;
        }
        let (difference, over) = limb.overflowing_sub(*term);
        let (difference, again) = difference.overflowing_sub(u64::from(borrow));
        (*limb, borrow) = (difference, over | again);
    }
}

/// A limb of words, the lowest first.
fn joined(words: &[Word]) -> u64 {
    words.iter().rev().fold(0, |limb, word| limb.checked_shl(WORD_BITS).unwrap_or(0) | widened(*word))
}

/// The words of a limb, the lowest first.
fn parted(limb: u64, words: &mut Vec<Word>) {
    for part in 0..64 / WORD_BITS {
        #[allow(clippy::cast_possible_truncation, reason = "a word of the limb")]
        words.push((limb >> (part * WORD_BITS)) as Word);
    }
}

#[expect(clippy::cast_possible_truncation, reason = "32 or 64")]
const WORD_BITS: u32 = WORD_BIT_SIZE as u32;

#[allow(clippy::useless_conversion, reason = "on some machines words have 32 bits")]
fn widened(word: Word) -> u64 {
    u64::from(word)
}

impl From<f64> for Exact {
    fn from(value: f64) -> Self {
        if !value.is_finite() {
            return Self::nan();
        }
        let bits = value.to_bits();
        let (fraction, biased) = (bits & ((1 << 52) - 1), (bits >> 52) & 0x7ff);
        let whole = if biased == 0 { fraction } else { fraction | 1 << 52 };
        // At most 2046.
        let exponent = i32::try_from(biased.max(1)).unwrap_or(0) - 1075;
        let (place, shift) = split(exponent);
        let wide = u128::from(whole) << shift;
        let mut limbs = [0; FEW];
        (limbs[0], limbs[1]) = (low(wide), low(wide >> 64));
        Self::trimmed(value < 0.0, place, Limbs::Few(limbs, 2))
    }
}

impl Add for &Exact {
    type Output = Exact;

    fn add(self, other: Self) -> Exact {
        self.plus(other, false)
    }
}

impl Sub for &Exact {
    type Output = Exact;

    fn sub(self, other: Self) -> Exact {
        self.plus(other, true)
    }
}

impl Mul for &Exact {
    type Output = Exact;

    fn mul(self, other: Self) -> Exact {
        if !(self.is_number && other.is_number) {
            return Exact::nan();
        }
        let (a, b) = (self.limbs.get(), other.limbs.get());
        let mut product = Limbs::zeros(a.len() + b.len());
        let digits = product.get_mut();
        for (i, x) in a.iter().enumerate() {
            let mut carry = 0;
            for (y, to) in b.iter().zip(&mut digits[i..]) {
                let term = u128::from(*x) * u128::from(*y) + u128::from(*to) + carry;
                *to = low(term);
                carry = term >> 64;
            }
            digits[i + b.len()] = low(carry);
        }
        Exact::trimmed(self.negative != other.negative, self.place + other.place, product)
    }
}

impl Neg for &Exact {
    type Output = Exact;

    fn neg(self) -> Exact {
        Exact { negative: !self.negative && !self.is_zero(), ..self.clone() }
    }
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        let header = |number: &Self| (number.is_number, number.negative, number.place);
        self.is_number && header(self) == header(other) && self.limbs.get() == other.limbs.get()
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
    use proptest::prelude::*;

    proptest! {
        /// Numbers of one limb to thirty, so that some are kept where they stand and some are not.
        #[test]
        fn sums_and_products_are_those_of_another_arithmetic(
            numbers in prop::array::uniform6((-1.0..1.0f64, -300..300i32)), nearness in 0..2,
        ) {
            let doubles = numbers.map(|(value, scale)| scaled(value, if nearness == 0 { scale } else { scale / 100 }));
            prop_assume!(doubles.iter().all(|value| *value != 0.0));
            let [a, b, c, d, e, f] = doubles.map(Exact::from);
            let x = &(&a * &b) + &(&c * &d);
            let [p, q, r, s, t, u] = doubles.map(|value| BigFloat::from_f64(value, 64));
            let y = p.mul_full_prec(&q).add_full_prec(&r.mul_full_prec(&s));
            prop_assert_eq!(&Exact::of_big(&y), &x);
            prop_assert_eq!(&Exact::of_big(&x.to_big()), &x);
            let (z, w) = (&x - &(&e * &f), y.sub_full_prec(&t.mul_full_prec(&u)));
            prop_assert_eq!(&Exact::of_big(&w), &z);
            prop_assert_eq!(&Exact::of_big(&w.mul_full_prec(&y)), &(&z * &x));
            let near = z.leading();
            prop_assert!((&z - &Exact::from(near)).magnitude() <= f64::EPSILON * near.abs() && near.abs() <= z.magnitude());
            prop_assert!(z.is_zero() || near.signum() == f64::from(z.sign()));
        }
    }

    #[test]
    fn what_is_no_number_stays_so_and_is_bounded_by_nothing() {
        for nothing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(Exact::from) {
            let one = Exact::from(1.0);
            for number in [&nothing + &one, &one - &nothing, &nothing * &Exact::zero(), -&nothing, nothing.times_power(3)] {
                assert!(
                    number.leading().is_nan() && number.magnitude() == f64::INFINITY && !number.is_zero() && number != number
                );
            }
        }
    }

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
