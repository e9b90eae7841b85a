//! x
pub mod lattice;
pub mod sampler;
