//! The closed form of a polynomial emission.

pub(crate) mod moments;
pub(crate) mod parameters;
pub(crate) mod segment;
pub(crate) mod sum;
pub(crate) mod within;
