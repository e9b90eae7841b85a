//! Independent truth for the radiosity of polygonal emitters and its gradient.

mod adaptive;
mod compensated;
mod contour;
pub mod cubature;
mod ear_clipping;
mod error;
mod gauss_kronrod;
mod integrand;
mod piece;
mod region;
mod source_function;
mod triangle_rule;

pub use error::Error;
pub use source_function::Source;
