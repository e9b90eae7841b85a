//! The numbers that a closed form is written on: one number, or several side by side on the lanes of a vector.
//!
//! A formula has one definition for all of them. Its operations and their order are the same on each, so on lanes each number
//! gets the digits that it would get alone. Constants are spelled `x.like(constant)`, since a vector is made for an instruction
//! set, and a decision is a [`Arithmetic::choose`] between two results.

use std::ops::{Add, BitAnd, BitXor, Div, Mul, Neg, Sub};

/// A number of any precision, or several.
pub trait Arithmetic:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A truth value for the number, or for each one.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitXor<Output = Self::Mask>;

    /// Whether approximations to a rounding of a double serve.
    const IS_DOUBLE: bool;

    /// A constant, as many times as there are numbers here.
    fn like(self, constant: f64) -> Self;

    /// pi, likewise.
    fn like_pi(self) -> Self;

    /// Where this is larger, by the leading doubles.
    fn exceeds(self, other: Self) -> Self::Mask;

    /// One number where the mask is set, the other one where it is not.
    fn choose(mask: Self::Mask, set: Self, unset: Self) -> Self;

    /// The same for values that take long to find: a number alone evaluates only its own one.
    fn choose_of(mask: Self::Mask, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self;

    /// The magnitude.
    fn abs(self) -> Self;

    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;

    /// Natural logarithm of a positive number; on lanes, of a normal one.
    fn ln(self) -> Self;

    /// Angle of the point `(x, self)`, in (-pi, pi]; on lanes where self is not negative and
    /// `arc_tangent::is_in_range`.
    fn atan2(self, x: Self) -> Self;

    /// The same where x is not negative either.
    #[inline(always)]
    fn atan2_right(self, x: Self) -> Self {
        self.atan2(x)
    }

    /// Clausen's function without its logarithm, see the module `dilogarithm`.
    fn clausen_rest(self) -> Self;

    /// `6 (g - sin g)/g^3` as a function of `g^2 <= 1`.
    fn sine_series(square: Self) -> Self;

    /// The same number known less well, by so many roundings of 1, where that is tracked.
    fn known_to(self, units: f64) -> Self;
}

/// A double, or several.
pub trait Doubles: Arithmetic {
    /// The smaller one; neither must be NaN.
    fn min(self, other: Self) -> Self;

    /// The larger one; neither must be NaN.
    fn max(self, other: Self) -> Self;

    /// The rounding error of the product of two numbers: exact, so the same with a fused multiply-add where that is one
    /// instruction.
    #[inline(always)]
    fn product_error(self, other: Self, product: Self) -> Self {
        product_error(self, other, product)
    }

    /// Runs an operation on double-doubles: in its place, or as a call where its code is long.
    #[inline(always)]
    fn run<A, R>(self, arguments: A, operation: impl Fn(A) -> R) -> R {
        operation(arguments)
    }

    /// `(k, m)` of positive normal numbers `2^k m`, m from 1 to 2.
    fn exponent_and_mantissa(self) -> (Self, Self);

    /// Three constants of a table: the row by the masks as digits of a binary number, one that is left out being 0; the column by
    /// how many of its masks are set, the second one only where the first one is.
    fn entry(self, table: &[[[f64; 3]; 3]; 4], row: (Self::Mask, Option<Self::Mask>), column: [Self::Mask; 2]) -> [Self; 3];
}

impl Doubles for f64 {
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        let bits = self.to_bits();
        // Below 2048.
        let exponent = (bits >> 52) as i32 - 1023;
        (Self::from(exponent), Self::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52)))
    }

    #[inline(always)]
    fn entry(self, table: &[[[f64; 3]; 3]; 4], (high, low): (bool, Option<bool>), [some, more]: [bool; 2]) -> [Self; 3] {
        table[2 * usize::from(high) + usize::from(low == Some(true))][usize::from(some) + usize::from(more)]
    }
}

/// `2^27 + 1`.
const SPLIT: f64 = 134_217_729.0;

/// Splits a double into two halves of at most 26 bits (Veltkamp 1968).
#[inline(always)]
fn split<T: Doubles>(a: T) -> (T, T) {
    let c = a.like(SPLIT) * a;
    let high = c - (c - a);
    (high, a - high)
}

/// The rounding error of the product p of two numbers, without a fused multiply-add (Dekker 1971). Of a double alone a fused
/// multiply-add would be shorter, but without the instruction it is a call of 25 ns, and the default x86-64 target has none.
#[inline(always)]
pub(crate) fn product_error<T: Doubles>(a: T, b: T, p: T) -> T {
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low
}
