//! Links: the transfer from an element to a point, and the elements and clusters from which a receiver gathers.

pub(crate) mod cell;
pub(crate) mod cluster;
pub(crate) mod direct;
pub(crate) mod gatherer;
pub(crate) mod link;
mod neglected;
pub(crate) mod rays;
pub(crate) mod refine;
pub(crate) mod station;
pub(crate) mod transfer;
pub(crate) mod visible;
