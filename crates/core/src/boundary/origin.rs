//! The lines of the input that the arcs of the visible boundary are on.

use crate::boundary::edge_name::EdgeName;

/// The line that generates an arc. Of edges that lie exactly on one line in space it is the one that the visible part was bounded by
/// first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// None: the receiver's horizon.
    Horizon,
    /// The edge of the emitter, or of the occluder of that number.
    Edge { occluder: Option<usize>, edge: EdgeName },
    /// The line in which the occluder of that number meets the emitter's plane.
    Waterline(usize),
}
