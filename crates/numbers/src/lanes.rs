//! The same numbers on the lanes of a vector: several edges, receivers or emitters at a time.

pub mod angle;
pub mod arithmetic;
pub mod ball;
pub mod instruction_set;
pub mod lane;
pub mod vectors;
