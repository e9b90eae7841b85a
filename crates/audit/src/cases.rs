//! Randomised cases in named families: how they are drawn, named, made smaller, and kept.

pub mod condition;
pub mod family;
mod lattice;
pub mod name;
pub mod regression;
pub mod sampler;
pub mod shrink;
