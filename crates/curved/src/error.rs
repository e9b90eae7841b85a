//! The errors of curved scenes and of requests.

use radgrad_core::DVec3;

/// Every way in which this crate refuses an input. Messages give the value, its place and the rule it breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A patch, or a point of one, is none.
    #[error("{what}: {rule}")]
    Patch {
        /// The kind of patch, or `point`.
        what: &'static str,
        /// The value found and the values allowed.
        rule: String,
    },
    /// A reflectance or an emission of a patch is out of range.
    #[error("{quantity} of patch {patch} is {value} at {point}: it must be from 0 to {largest}, for a reflectance below 1")]
    Value {
        /// Index of the patch, from 0.
        patch: usize,
        /// `reflectance` or `emission`.
        quantity: &'static str,
        /// The value.
        value: f64,
        /// Where.
        point: DVec3,
        /// The largest value that was stated.
        largest: f64,
    },
    /// A Bezier patch may be between others.
    #[error("Bezier patch {patch} may hide a part of the scene: it must be concave to its lit side with all others on that side")]
    Hides {
        /// Index of the patch, from 0.
        patch: usize,
    },
    /// The requested error is not positive.
    #[error("the error is {value}: it must be above 0 and at most 1, relative to the largest radiosity")]
    Tolerance {
        /// The value given.
        value: f64,
    },
    /// A radiosity cannot be represented.
    #[error("a radiosity on patch {patch}: {source}")]
    Evaluation {
        /// Index of the patch that receives, from 0.
        patch: usize,
        /// The error of its polygon.
        source: radgrad_core::Error,
    },
    /// A polygon cannot be cut into elements; its face is the patch of that index.
    #[error(transparent)]
    Polygon(#[from] radgrad_solver::Error),
}
