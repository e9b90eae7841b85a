//! The audit: randomised case families, each case measured against truth, error tables, and the gates they must stay within.

pub mod agreement;
pub mod condition;
pub mod decade;
pub mod distribution;
pub mod family;
pub mod gates;
pub mod lattice;
pub mod measure;
pub mod mutants;
pub mod regression;
pub mod run;
pub mod sampler;
pub mod shard;
pub mod shrink;
pub mod table;
pub mod truth;
