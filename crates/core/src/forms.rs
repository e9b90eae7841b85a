//! The closed forms: sums over the arcs, and derived bounds on their errors.

pub(crate) mod affine_weights;
pub(crate) mod constant;
pub(crate) mod constant_bound;
pub(crate) mod edge_lanes;
pub(crate) mod hats;
pub(crate) mod irradiance_and_gradient;
pub(crate) mod linear;
pub(crate) mod linear_bound;
pub(crate) mod polynomial;
pub(crate) mod second_derivatives;
pub(crate) mod segment;
