//! Independent truth for the radiosity of a point due to a polygonal emitter (HS95 Eq. 1) and for its gradient.
//!
//! Nothing here is a closed form, and of `radgrad-core` only the problem types are used: a receiver, an emitter, polygons. The
//! way of the data: [`SourceFunction`] (an emitter's emission, or any [`EmissionFunction`] `B(y)`) and the receiver give the
//! region that is seen, as triangles and edges of the emitter's plane; an integrand is evaluated on it by
//! - [`cubature`]: adaptive, in three forms (Eq. 1 and its kernel differentiated; Eqs. 6 and 9 as corrected; the visible
//!   boundary), with an estimate of the error and a status that says whether it can be relied on;
//! - [`monte_carlo`]: past any occluders, with intervals at a stated confidence ([`confidence`]).
//!
//! [`enclose`] decides, with occluders [`enclose_occluded`]: product Gauss rules with an a-priori bound, evaluated in ball arithmetic
//! to the requested digits, on pieces whose boundary is decided by exact signs, so that its answer is an enclosure, not an
//! estimate. The other two may not contradict it.
//!
//! [`enclose_moved`] moves the case first, without rounding, and [`slope_along`] differentiates enclosures along such a path.
//!
//! [`scene`] is the same for whole scenes, with all reflections: random walks with limits that hold whatever the distribution.
//!
//! Units: radiosity in the unit of the emission, the gradient in that unit over the unit of length.

pub mod confidence;
pub mod cubature;
mod emission_function;
mod enclosure;
mod error;
mod error_free;
pub mod monte_carlo;
mod region;
pub mod scene;
mod slope;
mod source_function;

pub use emission_function::{EmissionBounds, EmissionFunction};
pub use enclosure::arithmetic::Arithmetic;
pub use enclosure::interval::Interval;
pub use enclosure::source::{Polynomial, Source};
pub use enclosure::{
    Enclosure, Motion, Request, enclose, enclose_moved, enclose_occluded, enclose_source, enclose_source_occluded,
};
pub use error::{Error, Reached};
pub use slope::{Slope, slope_along};
pub use source_function::SourceFunction;
