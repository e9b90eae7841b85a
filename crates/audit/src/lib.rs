//! The audit: randomised case families, each case measured against truth, error tables, and the gates they must stay within.

pub mod condition;
pub mod family;
pub mod lattice;
pub mod sampler;
