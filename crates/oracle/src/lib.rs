//! Independent truth for the radiosity of polygonal emitters and its gradient.

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
mod region;
mod sampling;
mod silhouette;
mod sobol;
mod source_function;
mod triangle_rule;
mod visibility;

pub use error::Error;
pub use source_function::Source;
