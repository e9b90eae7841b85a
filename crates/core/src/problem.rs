//! The problem as stated: receiver, polygon and emission. A value of these types is always valid.

pub(crate) mod affine;
pub(crate) mod emission;
pub(crate) mod fan;
pub(crate) mod polygon;
pub(crate) mod polynomial;
pub(crate) mod receiver;
pub(crate) mod triangulate;
