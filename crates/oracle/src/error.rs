//! What the oracle refuses.

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
    Budget {
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
    /// The receiver touches the emitter: the integrand has no finite variance and the integral no value at that point.
    #[error(
        "the receiver is at height 0 over the emitter's plane and at distance {distance} from its lit part: it touches it, no sample mean has a finite variance"
    )]
    Touching {
        /// Distance from the polygon, in units of the largest distance of a vertex.
        distance: f64,
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
