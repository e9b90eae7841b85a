//! Coefficients of series, in double and in double-double.

pub(crate) mod clausen;
pub(crate) mod sine;
