//! Radiosity of curved patches without tessellating them, beside polygons (H. Zatz 1993).
//!
//! On patches over parameters ([`Patch`]) the irradiance `H = G(E + rho H)` is approximated by polynomials of the parameters, `H_h`,
//! on rectangles of these; E and rho enter the integrals as they are, so that the radiosity `E + rho H_h` has all their detail and
//! only the irradiance, which is smooth, is projected (R. Gershbein, P. Schroeder and P. Hanrahan 1993). This is a solver of its own
//! beside [`radgrad_solver::solve()`]: kernels come from cubature, with an estimate of its error instead of a bound.
//!
//! ```text
//! CurvedScene -> PatchPart     part: rectangles of parameters, elements of polygons; patch: position, normal, element of area
//!   -> rows                transport: G(rho phi_k) and G(E) at nodes, cubature; sight: occlusion
//!   -> H_h, residual       the linear system by Gauss-Seidel, q = G(E + rho H_h) - H_h from samples as in the solver's `residual`
//! CurvedSolution -> gather
//! ```
//!
//! # The bound
//! `H - H_h = G rho (H - H_h) + q` and `G 1 <= 1`, so `|H - H_h| <= sup|q| / (1 - max rho) = W`, and the radiosity from one more
//! gather, `B_g = E + rho G(E + rho H_h)`, errs by no more than `rho W G(rho)`. Estimated are q between the nodes of a part, and
//! the errors of cubature, which are added. Values known exactly are inside.
//!
//! # Supported patches
//! Patches hide each other by their true shape: a polygon, and parts of spheres, of cylinders and bilinear patches may be anywhere.
//! Where one is in the way the integrand is broken and cubature slow: the bound then counts whole every cell that a shadow crosses,
//! or may slip through. A Bezier patch is accepted where it hides nothing, concave to its lit side with all the scene on that side
//! of it, and refused elsewhere.
//! Convex patches seen from their lit side have their own horizon: the part of a patch that faces away gives nothing.

mod cubature;
mod error;
mod part;
mod patch;
mod scene;
mod sight;
mod solution;
mod transport;
mod value;

pub use error::Error;
pub use patch::{Patch, Side};
pub use scene::CurvedScene;
pub use solution::{CurvedAnswer, CurvedOptions, CurvedSolution, solve};
pub use value::Value;
