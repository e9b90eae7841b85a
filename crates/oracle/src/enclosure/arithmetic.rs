//! The number types an enclosure can be computed with, behind one trait.
//!
//! An operation returns its rounded result and a proven bound on its rounding error; [`crate::enclosure::ball::Ball`] composes
//! them.

use std::fmt::Debug;

use crate::enclosure::exact::Exact;
use crate::enclosure::legendre::Rules;

/// Which arithmetic computes an enclosure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Arithmetic {
    /// Pairs of doubles, about 31 digits inside: 15 to 24 digits of the result.
    DoubleDouble,
    /// 192 to 512 bits kept on the stack, then as [`Self::Astro`].
    Limbs,
    /// Any number of bits, in Rust: `astro-float`, round to nearest.
    Astro,
    /// Any number of bits, MPFR through `rug`: the same bits as [`Self::Astro`], sooner.
    #[cfg(feature = "mpfr")]
    Mpfr,
}

/// A floating-point number that knows the rounding error of its operations.
pub(crate) trait Real: Clone + Debug + Send + Sync + 'static {
    /// A double that is 0 or normal, exactly.
    fn from_f64(value: f64, bits: usize) -> Self;
    /// The number nearest or next to a dyadic rational, and a bound on the difference.
    fn from_exact(exact: &Exact, bits: usize) -> (Self, f64);
    /// The value, exactly.
    fn to_exact(&self) -> Exact;
    /// Sum and bound.
    fn add(&self, other: &Self) -> (Self, f64);
    /// Difference and bound.
    fn subtract(&self, other: &Self) -> (Self, f64);
    /// Product and bound.
    fn multiply(&self, other: &Self) -> (Self, f64);
    /// Quotient and bound.
    fn divide(&self, other: &Self) -> (Self, f64);
    /// The opposite number, exactly.
    fn negated(&self) -> Self;
    /// Zero, with the same number of bits.
    fn zero(&self) -> Self;
    /// One, with the same number of bits.
    fn one(&self) -> Self;
    /// About the square root; how near is for the caller to prove.
    fn approximate_root(&self) -> Self;
    /// A double within one part in 2^50 of the number.
    fn leading(&self) -> f64;
    /// Gauss-Legendre rules computed so far.
    fn rules() -> &'static Rules<Self>;
}
