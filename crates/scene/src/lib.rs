//! What `radgrad` reads and writes: single cases as JSON Lines, in [`case`].
//!
//! Everything read here passes through the types of `radgrad-core`, so a [`case::Problem`] that exists is valid.

pub mod case;
mod error;

pub use error::Error;
