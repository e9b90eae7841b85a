//! Answers measured against truth, and the tables that the figures end in.

pub mod condition;
pub mod decade;
pub mod distribution;
pub mod leading;
pub mod measure;
pub mod run;
pub mod seen;
pub mod shard;
pub mod table;
pub mod tally;
pub mod truth;
