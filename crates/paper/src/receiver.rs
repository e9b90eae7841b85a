//! One receiver in given light: where to sample it, with the gradient as the judge (N. Holzschuch and F. X. Sillion 1995, 3.2).
//!
//! ```text
//! Lighting -> Sample            lighting: radiosity and gradient at a point, each with its bound
//! Emitter  -> Maximum           maximum: the one place where a convex emitter is brightest, by Newton's method
//! Sample(s) -> is it enough?    criteria: constant and linear elements, and where to look next
//! -> ConstantMesh, LinearMesh   constant_mesh, linear_mesh: divided where a criterion says so, brightest place first
//! ```
//!
//! The criteria are estimates, not bounds: they rest on the samples alone. They fail where all samples lie around a peak that
//! none of them sees, in the flat parts on its sides, or where the only one lies on top of it (the paper's Fig. 3); a sample at
//! the maximum of each emitter, taken first, resolves both. Shadows can still hide between samples, which [`Refinement::longest`]
//! limits.

mod constant_mesh;
mod criteria;
mod lighting;
mod linear_mesh;
mod maximum;
mod refinement;

pub use constant_mesh::{ConstantElement, ConstantMesh, refine_constant};
pub use criteria::{Departure, departure, variation};
pub use lighting::{Lighting, Sample};
pub use linear_mesh::{LinearMesh, refine_linear};
pub use maximum::{Maximum, brightest};
pub use refinement::Refinement;
