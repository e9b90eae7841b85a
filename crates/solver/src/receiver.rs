//! One receiver in given light: where to sample it, with the gradient as the judge (N. Holzschuch and F. X. Sillion 1995, 3.2).
//!
//! ```text
//! Lighting -> Sample            lighting: radiosity and gradient at a point, each with its bound
//! Emitter  -> Maximum           maximum: the one place where a convex emitter is brightest, by Newton's method
//! Sample(s) -> is it enough?    criteria: constant and linear elements, and where to look next
//! -> ConstantMesh, LinearMesh   constant_mesh, linear_mesh: divided where a criterion says so, brightest place first
//! ```
//!
//! The criteria are estimates, not bounds: they see what the samples see. They are fooled where all samples lie around a peak that
//! none of them sees, in the flat parts on its sides, or where the only one lies on top of it (the paper's Fig. 3); a sample at
//! the maximum of each emitter, taken first, resolves both. Shadows can still hide between samples, which [`Refinement::longest`]
//! limits.

mod constant_mesh;
mod criteria;
mod lighting;
mod linear_mesh;
mod maximum;

use crate::Error;

pub use constant_mesh::{ConstantElement, ConstantMesh, refine_constant};
pub use criteria::{Departure, departure, variation};
pub use lighting::{Lighting, Sample};
pub use linear_mesh::{LinearMesh, refine_linear};
pub use maximum::{Maximum, brightest};

/// How far a receiver is to be refined.
///
/// ```
/// use radgrad_solver::receiver::Refinement;
/// let refinement = Refinement { error: 0.01, ..Refinement::default() };
/// assert!(refinement.maximum_first);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// What an element may be off, by the criterion, in the unit of the radiosity.
    pub error: f64,
    /// Sides of elements longer than this are divided whatever a criterion says: what is smaller may be missed, as a shadow.
    pub longest: f64,
    /// Elements beyond which none is divided any more.
    pub most_elements: usize,
    /// Sample the brightest place of each emitter before all else.
    pub maximum_first: bool,
}

impl Refinement {
    fn check(&self) -> Result<(), Error> {
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
