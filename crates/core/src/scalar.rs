//! Numbers: double precision, double-double, arbitrary precision, balls with a running bound, and their functions.

pub(crate) mod arc_tangent;
pub(crate) mod arithmetic;
pub(crate) mod ball;
#[cfg(feature = "arbitrary-precision")]
pub(crate) mod big;
pub(crate) mod dilogarithm;
pub(crate) mod double_double;
pub(crate) mod exact;
pub(crate) mod logarithm;
pub(crate) mod number;
pub(crate) mod offset;
pub(crate) mod power;
pub(crate) mod radius;
pub(crate) mod real;
pub(crate) mod series;
pub(crate) mod vec3;
