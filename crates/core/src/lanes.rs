//! The same numbers on the lanes of a vector: several edges, receivers or emitters at a time.

pub(crate) mod angle;
pub(crate) mod arithmetic;
pub(crate) mod instruction_set;
pub(crate) mod lane;
pub(crate) mod vectors;
