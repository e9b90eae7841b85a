//! Independent truth for radiosity integrals.

mod arithmetic;
mod astro;
mod ball;
mod cell;
mod double_double;
mod enclosure;
mod error;
mod exact;
mod integral;
mod interval;
mod legendre;
mod source;
mod surface;
mod triangulation;

pub use arithmetic::Arithmetic;
pub use enclosure::{Enclosure, Request, enclose, enclose_source};
pub use error::{Error, Reached};
pub use interval::Interval;
pub use source::{Polynomial, Source};
