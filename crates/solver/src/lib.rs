//! Global radiosity of a scene with an estimate of its error.
//!
//! The radiosity of diffuse surfaces obeys `B = E + rho G B` with `G B(x) = (1/pi) int B(y) (n1.r)(-n2.r)/|r|^4 dA` over all
//! that x sees (N. Holzschuch and F. X. Sillion 1995, Eq. 1, summed over all surfaces). [`solve`] approximates B by a polynomial
//! on each element of a mesh ([`Basis`]: H. Zatz 1993), whose light at any point is known, occlusion included. So
//! the residual of an approximation can be computed at any point, and an estimate of the error follows from it and from the fact
//! that light gets less with each reflection. Radiosities and irradiances are pi times the unit of the scene's radiances: the guide's page
//! `docs/guide/units.md` sets them side by side.
//!
//! ```text
//! Scene -> Mesh        mesh, element, contact: trees of parallelograms and triangles; basis, rule: polynomials and nodes
//!                      shadow, partition: faces cut along shadow lines, where that is asked for
//!   -> direct light    direct: light of lamps at the nodes of leaves; leaves are divided until little is left out
//!   -> links           link, refine: sources of a receiver, and the light that they neglect; transfer, visible, cell: rules,
//!                      closed forms; cluster: boxes of many faces, where there are many, for far or hidden light
//!   -> Field           field, gathering: the linear system, solved in sweeps; sums pulled up the trees
//!   -> ErrorEstimate   estimate: residual, mean(z |r|) with the importance z, and errors at points; ledger: its sources
//!   -> divide, again   solve, marking: elements that make up most of the error, or are off most by samples and gradients
//! Solution -> gather   gather: E + rho G B_h at a point, with its estimate
//! ```
//!
//! Faces may have textures: reflection multiplies the irradiance, which is projected by itself, with texels (modules `surfaces`,
//! `texture`; R. Gershbein, P. Schroeder and P. Hanrahan 1993). Curved patches have a solver of their own, the crate `radgrad-curved`.
//!
//! # Estimate
//! With every answer goes an estimate of its error. It follows the samples, as if light had no feature smaller than the elements
//! that their samples do not see, but for lamps that no node of an element sees and that may shine on it, which count in it in
//! full. It is no bound. [`Options::error`] is the bound on it at which the solution ends.
//!
//! Radiosities are pi times the radiance of the scene's materials, in its unit. `examples/two_squares.rs` shows the error, its
//! estimate and their ratio as the mesh is refined.

mod bytes;
mod clock;
mod error;
mod estimate;
mod field;
mod gathering;
mod links;
mod mesh;
mod once;
#[doc(hidden)]
pub mod parts;
mod picture;
mod solve;
mod system;

pub use error::Error;
pub use estimate::ledger::Ledger;
pub use mesh::Mesh;
pub use mesh::basis::{Basis, MAX_DEGREE};
pub use mesh::element::Element;
pub use mesh::rule::{Node, rectangular};
pub use mesh::shape::Shape;
pub use picture::{NonNegative, PictureGathers};
pub use solve::by_surface::SurfaceRadiosity;
pub use solve::derivative::{Derivative, WeightedPoint, WeightedSum};
pub use solve::gather::{Gathered, Irradiance};
pub use solve::gradient::{Gradient, SurfaceGradient};
pub use solve::gradient_rounds::GradientRounds;
pub use solve::options::{Marking, Next, Options, Progress};
pub use solve::solution::Solution;
pub use solve::{solve, solve_for, solve_from};
