//! Radiosity and its gradient at a receiver point due to a polygonal emitter, in closed form.

mod arc;
#[cfg(feature = "arbitrary-precision")]
mod big;
mod certify;
mod constant;
#[cfg(feature = "arbitrary-precision")]
mod digits;
mod dilogarithm;
mod double_double;
mod emission;
mod error;
mod evaluate;
mod exact;
mod gauss;
mod geometry;
mod hessian;
mod horizon;
mod ladder;
mod linear;
mod number;
pub mod paper;
mod plan;
mod polynomial;
mod radius;
mod real;
mod terms;
mod triangulate;
mod vec3;
mod visibility;

#[cfg(feature = "arbitrary-precision")]
pub use digits::{MOST_DIGITS, PreciseAnswer, evaluate_digits};
pub use emission::{Emission, Emitter, Linear};
pub use error::Error;
pub use evaluate::{
    Answer, DEFAULT_TOLERANCE, Method, evaluate, evaluate_to, gradient, irradiance_vector, radiosity, radiosity_and_gradient,
};
pub use geometry::{Polygon, Receiver};
pub use glam::{DMat3, DVec3};
pub use hessian::{Hessian, hessian, hessian_to};
pub use polynomial::{Monomial, Polynomial};
