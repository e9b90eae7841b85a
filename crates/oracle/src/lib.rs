//! Independent truth for the radiosity of polygonal emitters and its gradient.

mod adaptive;
mod compensated;
pub mod cubature;
mod ear_clipping;
mod error;
mod integrand;
mod region;
mod source_function;
mod triangle_rule;

pub use error::Error;
pub use source_function::Source;
