//! The 1995 paper as it is written, for comparison with the project's forms: N. Holzschuch and F. X. Sillion, "Accurate
//! Computation of the Radiosity Gradient for Constant and Linear Emitters" (HS95).
//!
//! - [`appendix`] is its Appendix A, as printed and as corrected: a second implementation of the closed forms of `radgrad-core`, with its
//!   misprints one by one, so that an audit can be seen to find them.
//! - [`receiver`] refines one receiver in given light by the criteria of its section 3.2, which the gradient makes possible.

pub mod appendix;
mod error;
pub mod receiver;

pub use error::Error;
