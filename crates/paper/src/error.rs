//! Errors of a refinement.

use radgrad_core::DVec3;

/// Every way in which a refinement is refused. Messages give the value, its place and the rule it breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The receiver cannot be cut into triangles.
    #[error("the receiver cannot be cut into triangles: its outline touches itself")]
    Outline,
    /// A sample cannot be computed.
    #[error("the radiosity at {position}: {source}")]
    Sample {
        /// The point.
        position: DVec3,
        /// The rule that it breaks.
        source: radgrad_core::Error,
    },
    /// A refinement asks for no error that elements can have.
    #[error("elements may be off {value}: it must be above 0 and finite, in the unit of the radiosity")]
    Allowed {
        /// The value given.
        value: f64,
    },
    /// A refinement allows no side that elements can have.
    #[error("sides may be {value} long: it must be above 0, in the unit of length")]
    Longest {
        /// The value given.
        value: f64,
    },
}
