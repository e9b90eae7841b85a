//! The index of a scene's faces, shared by scenes of the same ones.

use std::fmt;
use std::sync::{Arc, Mutex};

use radgrad_core::Polygon;

use crate::occluders::Occluders;

/// The index that was built last of the faces of a scene or of one that was made from it: those with the same faces share it. Scenes are
/// compared without it.
#[derive(Clone, Default)]
pub(super) struct Indexed(pub(super) Arc<Mutex<Option<Known>>>);

/// An index, and the faces that it is of, with their surfaces, none of which overlap to this precision.
pub(super) struct Known {
    pub(super) faces: Vec<(Polygon, usize, bool)>,
    pub(super) precision: f64,
    pub(super) index: Arc<Occluders>,
}

impl PartialEq for Indexed {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Indexed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Indexed")
    }
}
