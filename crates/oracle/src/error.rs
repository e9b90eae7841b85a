//! What the oracle refuses.

use glam::DVec3;

/// Every way in which an oracle refuses a question; a question it cannot answer well enough gets a status instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A relative tolerance must be positive.
    #[error("tolerance is {value}: a relative tolerance must be positive and finite")]
    Tolerance {
        /// As given.
        value: f64,
    },
    /// The budget does not allow the first pass.
    #[error("the budget is {budget} evaluations: the first pass alone needs {needed}")]
    Evaluations {
        /// Evaluations allowed.
        budget: usize,
        /// Evaluations of the first pass.
        needed: usize,
    },
    /// A confidence level must be between 0 and 1.
    #[error("confidence is {value}: it must be above 0 and below 1")]
    Confidence {
        /// As given.
        value: f64,
    },
    /// Too few samples for a standard error.
    #[error("{what} is {value}: at least {least} are needed for an interval")]
    TooFewSamples {
        /// Which number.
        what: &'static str,
        /// As given.
        value: usize,
        /// The least allowed.
        least: usize,
    },
    /// The receiver touches the emitter or an edge: a sample's contribution has no finite variance there.
    #[error("the receiver at {position} touches {what}: no mean of samples has a finite variance")]
    Touching {
        /// Position of the receiver.
        position: DVec3,
        /// What it touches.
        what: &'static str,
    },
    /// The polygon could not be triangulated.
    #[error("no ear found among the last {remaining} vertices of the polygon: it is not simple as seen in its plane")]
    Triangulation {
        /// Vertices not yet cut off.
        remaining: usize,
    },
    /// A result or an integrand is not a finite number.
    #[error("{quantity} is {value}: not representable, or the source function gave it")]
    NotFinite {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
}
