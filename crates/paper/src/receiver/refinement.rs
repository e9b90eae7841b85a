//! How far a receiver is to be refined.

use crate::error::Error;

/// How far a receiver is to be refined.
///
/// ```
/// use radgrad_paper::receiver::Refinement;
/// let refinement = Refinement { error: 0.01, ..Refinement::default() };
/// assert!(refinement.maximum_first);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// Allowed error of an element, by the criterion, in the unit of the radiosity.
    pub error: f64,
    /// Sides of elements longer than this are divided whatever a criterion says: samples may miss a smaller feature, such as a
    /// shadow.
    pub longest: f64,
    /// Elements beyond which none is divided any more.
    pub most_elements: usize,
    /// Sample the brightest place of each emitter before all else.
    pub maximum_first: bool,
}

impl Refinement {
    pub(super) fn check(&self) -> Result<(), Error> {
        if !(self.error > 0.0 && self.error.is_finite()) {
            return Err(Error::Allowed { value: self.error });
        }
        if self.longest > 0.0 { Ok(()) } else { Err(Error::Longest { value: self.longest }) }
    }
}

impl Default for Refinement {
    fn default() -> Self {
        Self { error: 0.01, longest: f64::INFINITY, most_elements: 10_000, maximum_first: true }
    }
}
