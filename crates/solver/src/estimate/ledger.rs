//! Where the error comes from (J. Arvo, K. Torrance and B. Smits 1994; M. Lischinski, B. Smits and D. Greenberg 1994).

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

use crate::bytes::bytes_of;

/// An estimate of an error, by its sources. Unit: that of the radiosity.
///
/// ```
/// use radgrad_solver::Ledger;
/// let ledger = Ledger { discretisation: 0.5, visibility: 0.25, ..Ledger::default() };
/// assert_eq!((ledger + ledger).total(), 1.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Deviation of the computed model from the given one: on an element a texture's detail gives way to a polynomial. It is
    /// known.
    pub modelling: f64,
    /// The radiosity is not a polynomial on an element: from samples of the residual (module `residual`) with the detail of textures, which
    /// is known.
    pub discretisation: f64,
    /// Light that links neglect, quadrature and rounding; taken between nodes as at them.
    pub computation: f64,
    /// Errors of evaluations with occlusion, in the same sense.
    pub visibility: f64,
    /// The linear system is not solved to the last digit.
    pub solver: f64,
}

impl Ledger {
    /// The whole: the sum of all entries.
    #[must_use]
    pub const fn total(&self) -> f64 {
        self.modelling + self.discretisation + self.computation + self.visibility + self.solver
    }

    /// The entries, in the order of their names.
    #[must_use]
    pub const fn entries(&self) -> [f64; 5] {
        [self.modelling, self.discretisation, self.computation, self.visibility, self.solver]
    }

    /// Names of the entries.
    pub const NAMES: [&'static str; 5] = ["modelling", "discretisation", "computation", "visibility", "solver"];

    pub(crate) const fn from_entries(e: [f64; 5]) -> Self {
        Self { modelling: e[0], discretisation: e[1], computation: e[2], visibility: e[3], solver: e[4] }
    }

    /// The same with each entry changed.
    pub(crate) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::from_entries(self.entries().map(f))
    }

    /// Entry by entry, the result of `f`.
    pub(crate) fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self.entries(), other.entries());
        Self::from_entries([0, 1, 2, 3, 4].map(|i| f(a[i], b[i])))
    }
}

impl Add for Ledger {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sum for Ledger {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

impl AddAssign for Ledger {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for Ledger {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.map(|entry| entry * factor)
    }
}

bytes_of!(Ledger { modelling, discretisation, computation, visibility, solver });
