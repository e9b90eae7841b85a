//! Independent truth for the radiosity of a point due to a polygonal emitter (HS95 Eq. 1) and for its gradient.
//!
//! Nothing here is a closed form, and of `radgrad-core` only the problem types are used: a receiver, an emitter, polygons. The way of
//! the data: [`SourceFunction`] (any emission `B(y)`) and the receiver give the region that is seen, as triangles and edges of the emitter's plane;
//! an integrand is evaluated on it by
//! - [`cubature`]: adaptive, in three forms (Eq. 1 and its kernel differentiated; Eqs. 6 and 9 as corrected; the visible
//!   boundary), with an estimate of the error and a status that says whether it can be relied on;
//! - [`monte_carlo`]: past any occluders, with intervals at a stated confidence ([`confidence`]).
//!
//! Units: radiosity in the unit of the emission, the gradient in that unit over the unit of length.

mod adaptive;
mod compensated;
pub mod confidence;
mod contour;
pub mod cubature;
mod ear_clipping;
mod error;
mod gauss_kronrod;
mod integrand;
pub mod monte_carlo;
mod piece;
mod plane;
mod region;
mod sampling;
mod silhouette;
mod sobol;
mod source_function;
mod triangle_rule;
mod visibility;

pub use error::Error;
pub use source_function::SourceFunction;
