//! Numbers of as many bits as are requested at run time: the middle of a [`crate::ball::Ball`] where double-double is not
//! enough.
//!
//! The formulas are written on scalars that copy. A [`Big`] is a place in an arena of its thread, that [`within`] opens and
//! clears; it means nothing outside. Sums, differences, products, quotients and square roots are those of the crate
//! `astro-float`, rounded to nearest, so that they err by at most `2^-bits` of the result, which the tests of its functions hold;
//! logarithm and arc tangent are made there. The exponent has 32 bits: nothing that is made of doubles over- or underflows.

pub mod decimal;
pub mod enclosure;
mod float;
mod functions;
pub mod magnitude;
mod series;

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float::{BigFloat, Consts};
use glam::DVec3;

use crate::big::float::{NEAREST, exact, exact_sum, nearest_double, shifted, split_double};
use crate::big::magnitude::Magnitude;
use crate::big::series::Coefficients;
use crate::double_double::DoubleDouble;
use crate::effort;
use crate::number::Number;
use crate::radius::Radius;

/// A number in the arena of the thread.
#[derive(Debug, Clone, Copy)]
pub struct Big(usize);

/// The numbers of a computation, and the constants kept from one to the next.
struct Arena {
    /// A multiple of 64.
    bits: usize,
    numbers: Vec<BigFloat>,
    /// The effort that the computation has cost, and the limit on it.
    spent: u64,
    limit: u64,
    constants: Consts,
    coefficients: Vec<Coefficients>,
}

thread_local! {
    static ARENA: RefCell<Arena> = RefCell::new(Arena {
        bits: 64,
        numbers: Vec::new(),
        spent: 0,
        limit: u64::MAX,
        // Fails only where there is no memory for a dozen numbers.
        constants: Consts::new().expect("memory for the constants"),
        coefficients: Vec::new(),
    });
}

/// Clears the arena also where the computation panics.
struct Clear;

impl Drop for Clear {
    fn drop(&mut self) {
        ARENA.with_borrow_mut(|arena| arena.numbers.clear());
    }
}

/// Runs a computation with at least so many bits. Its result must not hold a [`Big`].
#[cfg(test)]
pub(crate) fn with_bits<R>(bits: usize, computation: impl FnOnce() -> R) -> R {
    within(bits, u64::MAX, computation).0.expect("no limit")
}

/// The same within an effort: `None` where it would have taken more. From there on the computation goes on without computing
/// anything, so that it ends soon, and its result is dropped. It is a part of the effort of its thread ([`effort`]), and ends
/// with that.
pub fn within<R>(bits: usize, limit: u64, computation: impl FnOnce() -> R) -> (Option<R>, Spent) {
    let limit = limit.min(effort::remaining());
    ARENA.with_borrow_mut(|arena| {
        arena.bits = bits.next_multiple_of(64);
        (arena.spent, arena.limit) = (0, limit);
    });
    let _clear = Clear;
    let result = computation();
    let (bits, effort) = ARENA.with_borrow(|arena| (arena.bits, arena.spent));
    let is_whole = effort <= limit && !effort::is_over();
    // At most the whole limit: a caller that asks for less has the result of fewer bits.
    effort::spend(effort.min(limit));
    (is_whole.then_some(result), Spent { bits, effort })
}

/// The cost of a computation.
#[derive(Debug, Clone, Copy)]
pub struct Spent {
    bits: usize,
    effort: u64,
}

impl Spent {
    /// Operations, each weighted by the square of its words.
    pub const fn effort(self) -> u64 {
        self.effort
    }

    /// The effort of as many operations with other bits.
    pub const fn with_bits(self, bits: usize) -> u64 {
        (self.effort / price(self.bits)).saturating_mul(price(bits.next_multiple_of(64)))
    }
}

/// The cost of an operation: a product of all words with all others, and a place in the arena.
const fn price(bits: usize) -> u64 {
    let words = (bits / 64) as u64;
    256 + words * words
}

/// As many operations as a logarithm, an arc tangent or Clausen's function takes.
const OF_A_FUNCTION: u64 = 64;

impl Arena {
    /// Pays for some operations; false where there is nothing left to pay with, and a number to stand for any other.
    fn pays(&mut self, operations: u64) -> bool {
        self.spent = self.spent.saturating_add(operations * price(self.bits));
        self.spent <= self.limit || self.numbers.is_empty()
    }

    fn keep(&mut self, number: BigFloat) -> Big {
        self.numbers.push(number);
        Big(self.numbers.len() - 1)
    }

    /// The coefficients of the series at the present precision, with the rest of the arena.
    fn with_coefficients(&mut self) -> (&mut Coefficients, &[BigFloat], &mut Consts) {
        let bits = self.bits;
        let place = self.coefficients.iter().position(|c| c.bits() == bits).unwrap_or_else(|| {
            self.coefficients.push(Coefficients::new(bits));
            self.coefficients.len() - 1
        });
        (&mut self.coefficients[place], &self.numbers, &mut self.constants)
    }
}

impl Big {
    /// Keeps a number found without others.
    fn new(number: impl FnOnce(&mut Arena) -> BigFloat) -> Self {
        Self::paid(1, number)
    }

    /// Keeps the value of a function that takes some operations.
    fn paid(operations: u64, number: impl FnOnce(&mut Arena) -> BigFloat) -> Self {
        ARENA.with_borrow_mut(|arena| {
            if !arena.pays(operations) {
                return Self(0);
            }
            let number = number(arena);
            arena.keep(number)
        })
    }

    /// Keeps a function of a number, given it and the number of bits.
    fn map(self, function: impl FnOnce(&BigFloat, usize) -> BigFloat) -> Self {
        Self::new(|arena| function(&arena.numbers[self.0], arena.bits))
    }

    /// Keeps a function of two numbers.
    fn combine(self, other: Self, function: impl FnOnce(&BigFloat, &BigFloat, usize) -> BigFloat) -> Self {
        Self::new(|arena| function(&arena.numbers[self.0], &arena.numbers[other.0], arena.bits))
    }

    fn read<R>(self, look: impl FnOnce(&BigFloat) -> R) -> R {
        ARENA.with_borrow(|arena| look(&arena.numbers[self.0]))
    }

    /// The number itself, that may leave the computation.
    pub fn to_float(self) -> BigFloat {
        self.read(Clone::clone)
    }
}

impl Add for Big {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.combine(other, |a, b, bits| a.add(b, bits, NEAREST))
    }
}

impl Sub for Big {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.combine(other, |a, b, bits| a.sub(b, bits, NEAREST))
    }
}

impl Mul for Big {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.combine(other, |a, b, bits| a.mul(b, bits, NEAREST))
    }
}

impl Div for Big {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.combine(other, |a, b, bits| a.div(b, bits, NEAREST))
    }
}

impl Neg for Big {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|a, _| a.neg())
    }
}

impl Number for Big {
    type Radius = Magnitude;
    const BEYOND_DOUBLE_DOUBLE: bool = true;
    const IS_DOUBLE: bool = false;
    const QUOTIENT_UNITS: f64 = 1.0;
    const LIBRARY_UNITS: f64 = functions::LIBRARY_UNITS;
    const CLAUSEN_UNITS: f64 = crate::series::clausen::UNITS;
    /// Differences of doubles are kept to as many bits as they take.
    const DIFFERENCE_UNITS: f64 = 0.0;

    fn roundoff() -> Magnitude {
        ARENA.with_borrow(|arena| Magnitude::power_of_two(-(arena.bits as i64)))
    }
    fn tiny() -> Magnitude {
        Magnitude::from(0.0)
    }
    fn size(self) -> Magnitude {
        self.read(Magnitude::of_number)
    }
    fn high(self) -> f64 {
        self.read(nearest_double)
    }
    /// Rounded up in size.
    fn low(self) -> f64 {
        self.read(|number| split_double(number).1.to_double())
    }
    fn from_double(value: f64) -> Self {
        Self::new(|_| exact(value))
    }
    fn from_double_double(value: DoubleDouble) -> Self {
        Self::new(|arena| exact(value.hi).add(&exact(value.lo), arena.bits, NEAREST))
    }
    fn pi() -> Self {
        Self::new(|arena| arena.constants.pi(arena.bits, NEAREST))
    }
    fn difference(a: f64, b: f64) -> Self {
        Self::new(|_| exact_sum(&exact(a), &exact(-b)))
    }
    /// Exact.
    fn exact_height((n, power_of_n): (DVec3, f64), point: DVec3, x: DVec3, power: f64) -> Self {
        let product = |axis: usize| exact(n[axis]).mul_full_prec(&exact_sum(&exact(point[axis]), &exact(-x[axis])));
        let sum = exact_sum(&exact_sum(&product(0), &product(1)), &product(2));
        Self::new(|_| sum).scaled(power).scaled(power_of_n)
    }
    fn scaled(self, power_of_two: f64) -> Self {
        let (_, exponent) = libm::frexp(power_of_two);
        self.map(|a, _| shifted(a, exponent - 1))
    }
    fn sqrt(self) -> Self {
        self.map(|a, bits| a.sqrt(bits, NEAREST))
    }
    fn ln(self) -> Self {
        Self::paid(OF_A_FUNCTION, |arena| {
            let bits = arena.bits;
            let (coefficients, numbers, constants) = arena.with_coefficients();
            functions::ln(&numbers[self.0], bits, &mut coefficients.steps, constants)
        })
    }
    fn atan2(self, x: Self) -> Self {
        Self::paid(OF_A_FUNCTION, |arena| {
            let bits = arena.bits;
            let (coefficients, numbers, constants) = arena.with_coefficients();
            functions::atan2(&numbers[self.0], &numbers[x.0], bits, &mut coefficients.steps, constants)
        })
    }
    fn sine_coefficients() -> impl DoubleEndedIterator<Item = Self> {
        let terms = ARENA.with_borrow_mut(|arena| arena.with_coefficients().0.sine_terms());
        (0..terms).map(|k| Self::new(|arena| arena.with_coefficients().0.sine(k).clone()))
    }
    fn clausen_sum(square: Self) -> Self {
        Self::paid(OF_A_FUNCTION, |arena| {
            let (coefficients, numbers, _) = arena.with_coefficients();
            coefficients.clausen_sum(&numbers[square.0])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_double_goes_in_and_comes_out() {
        with_bits(128, || {
            for value in [0.0, 1.0, -0.1, 1e300, 5e-324, -2.5e-310, f64::MAX] {
                assert_eq!(Big::from_double(value).high(), value);
                assert_eq!(Big::from_double(value).low(), 0.0);
            }
            let tiny = Big::from_double(-5e-324) * Big::from_double(5e-324);
            assert_eq!((tiny.high(), tiny.low()), (-5e-324, 1e-323));
            assert_eq!((tiny * tiny).scaled(0.5).high(), 5e-324);
        });
    }

    #[test]
    fn a_difference_of_doubles_is_exact_however_far_apart_they_are() {
        with_bits(128, || {
            let difference = Big::difference(1e200, 1e-200);
            assert_eq!((difference - Big::from_double(1e200)).high(), -1e-200);
            assert_eq!((Big::difference(3.0, 0.0).high(), Big::difference(0.0, 3.0).high()), (3.0, -3.0));
            assert_eq!(Big::difference(0.1, 0.1).high(), 0.0);
            let (n, tiny) = (DVec3::new(0.1, -0.1, 0.0), 2f64.powi(-900));
            let height = Big::exact_height((n, 1.0), DVec3::new(1.0, 1.0, 5.0), DVec3::new(-tiny, 0.0, 0.0), 0.5);
            assert_eq!(height.high(), 0.05 * tiny);
        });
    }
}
