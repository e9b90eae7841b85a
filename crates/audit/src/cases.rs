//! Randomised cases in named families: how they are drawn, named and made smaller.

pub mod family;
mod lattice;
pub mod name;
pub mod sampler;
pub mod shrink;
