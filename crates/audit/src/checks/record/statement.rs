//! The statements of a record about a subject, and the largest allowed distance of today's from them.

use serde::{Deserialize, Serialize};

/// A bound may be another one than it was by this share of it: other processors add in another order.
pub const ROUNDINGS: f64 = 1e-6;

/// A value may move by this share of its bound, and by no more than a thousandth of that and two units of its last place.
pub const MOVED: f64 = 1e-3;

/// The cost class of a subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Core.
    Core,
    /// The oracle.
    Oracle,
    /// Form factors and fields of scenes.
    Scenes,
    /// The solver, and certificates.
    Solver,
}

/// A value, of one component or more, with the bound on the norm of its error. Without a value a figure of its own: evaluations that
/// a bound takes, 1 for a tolerance that is met.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statement {
    /// The components.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub value: Vec<f64>,
    /// The bound.
    pub bound: f64,
}

/// The answer recorded for a subject.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recorded {
    /// The statements.
    pub statements: Vec<Statement>,
    /// The statements that truth contradicts.
    pub wrong: Vec<String>,
}

impl Recorded {
    /// Of values, each with its bound.
    pub(super) fn of_pairs(pairs: &[(f64, f64)]) -> Self {
        Self { statements: pairs.iter().map(|&(value, bound)| Statement::new(&[value], bound)).collect(), wrong: Vec::new() }
    }
}

impl Statement {
    pub(super) fn new(value: &[f64], bound: f64) -> Self {
        Self { value: value.to_vec(), bound }
    }

    /// The distance of two values over the sum of their bounds: above 1 they have no point in common.
    #[must_use]
    pub fn apart(&self, other: &Self) -> f64 {
        let distances: Vec<f64> = self.value.iter().zip(&other.value).map(|(a, b)| (a - b).abs()).collect();
        let room = (self.bound + other.bound) * (1.0 + ROUNDINGS);
        if distances.iter().all(|distance| *distance == 0.0) {
            return 0.0;
        }
        // Each over the room, since squares may leave the range of a double.
        distances.iter().map(|distance| (distance / room) * (distance / room)).sum::<f64>().sqrt()
    }

    /// Whether the value is another one: by [`MOVED`] of the bounds, or by a thousandth of that where it is more than rounding.
    #[must_use]
    pub fn has_moved(&self, other: &Self) -> bool {
        let apart = self.apart(other);
        let is_more = |(a, b): (&f64, &f64)| (a - b).abs() > 2.0 * f64::EPSILON * a.abs();
        apart > MOVED || (apart > 1e-3 * MOVED && self.value.iter().zip(&other.value).any(is_more))
    }
}
