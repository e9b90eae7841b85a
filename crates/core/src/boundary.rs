//! The visible part of an emitter: the arcs that bound it, seen from the receiver.

pub(crate) mod arc;
pub(crate) mod case;
pub(crate) mod edge_name;
pub(crate) mod horizon;
pub(crate) mod line;
pub(crate) mod origin;
pub(crate) mod plan;
pub(crate) mod traced;
pub(crate) mod visibility;
