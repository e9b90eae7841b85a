//! Errors of a request.

use radgrad_core::DVec3;

/// Every way in which this crate refuses a request. Messages give the value, its place and the rule it breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The probability that an interval fails is none.
    #[error("an interval is to fail with probability {value}: it must be above 0 and below 1")]
    Delta {
        /// The value given.
        value: f64,
    },
    /// The requested half-width is not positive.
    #[error("the half-width of the interval is {value}: it must be above 0, relative to the mean radiosity that is reflected")]
    Width {
        /// The value given.
        value: f64,
    },
    /// A point is on no face, or has no direction.
    #[error("point {index} at {position}: {rule}")]
    Point {
        /// Index of the point, from 0.
        index: usize,
        /// The point.
        position: DVec3,
        /// The rule that it breaks.
        rule: String,
    },
    /// A walk brought more than the most that a walk may bring by its derivation, on which the limits rest. No scene is known in which one does.
    #[error("a walk brings {value}, at most {most} is derived: this is a fault of radgrad, please report it with the scene")]
    BeyondRange {
        /// The sum that it brought.
        value: f64,
        /// The most.
        most: f64,
    },
    /// The scene is refused.
    #[error(transparent)]
    Scene(#[from] radgrad_scene::Error),
}
