//! Independent truth for radiosity integrals.

mod arithmetic;
mod astro;
mod ball;
mod double_double;
mod error;
mod exact;
mod interval;
mod legendre;

pub use arithmetic::Arithmetic;
pub use error::{Error, Reached};
pub use interval::Interval;
