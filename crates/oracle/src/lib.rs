//! Independent truth for the radiosity of a point due to a polygonal emitter (HS95 Eq. 1) and for its gradient.
//!
//! Nothing here is a closed form, and of `radgrad-core` only the problem types are used: a receiver, an emitter, polygons. The way of
//! the data: [`SourceFunction`] (any emission `B(y)`) and the receiver give the region that is seen, as triangles and edges of the emitter's plane;
//! an integrand is evaluated on it by
//! - [`cubature`]: adaptive, in three forms (Eq. 1 and its kernel differentiated; Eqs. 6 and 9 as corrected; the visible
//!   boundary), with an estimate of the error and a status that says whether it can be relied on;
//! - [`monte_carlo`]: past any occluders, with intervals at a stated confidence ([`confidence`]).
//!
//! [`enclose`] decides: product Gauss rules with an a-priori bound, evaluated in ball arithmetic to the digits asked for, so that its answer is an
//! enclosure, not an estimate. The other two may not contradict it.
//!
//! Units: radiosity in the unit of the emission, the gradient in that unit over the unit of length.

mod adaptive;
mod arithmetic;
mod astro;
mod ball;
mod cell;
mod compensated;
pub mod confidence;
mod contour;
pub mod cubature;
mod double_double;
mod ear_clipping;
mod enclosure;
mod error;
mod exact;
mod gauss_kronrod;
mod integral;
mod integrand;
mod interval;
mod legendre;
pub mod monte_carlo;
#[cfg(feature = "mpfr")]
mod mpfr;
mod outline;
mod pass;
mod piece;
mod plane;
mod region;
mod sampling;
mod silhouette;
mod sobol;
mod source;
mod source_function;
mod surface;
mod triangle_rule;
mod triangulation;
mod visibility;

pub use arithmetic::Arithmetic;
pub use enclosure::{Enclosure, Request, enclose, enclose_source};
pub use error::{Error, Reached};
pub use interval::Interval;
pub use source::{Polynomial, Source};
pub use source_function::SourceFunction;
