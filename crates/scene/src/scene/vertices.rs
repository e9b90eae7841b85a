//! The vertices of a file, which many faces use and some none. One that is wrong is refused by the first face that uses it: where
//! none does, the geometry is known without it.

use std::collections::BTreeMap;

use radgrad_core::DVec3;

use super::intake::Intake;
use crate::error::Error;
use crate::precision::{Coordinates, Written};

#[derive(Debug)]
struct Vertex {
    position: DVec3,
    written: [Written; 3],
    used: bool,
}

/// The vertices read so far, in their order.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    all: Vec<Vertex>,
    /// Errors of the wrong ones, with their places.
    faults: BTreeMap<usize, Error>,
}

impl Vertices {
    pub(crate) const fn len(&self) -> usize {
        self.all.len()
    }

    /// Adds a vertex, or the error in its place, which has its place.
    pub(crate) fn push(&mut self, read: Result<Coordinates, Error>, intake: &Intake) -> Result<(), Error> {
        intake.budget().take_many("vertices", 1, 2 * size_of::<Vertex>())?;
        let (position, written) = match read {
            Ok(coordinates) => coordinates,
            Err(error) => {
                intake.budget().take_many("vertices", 1, 4 * size_of::<Error>())?;
                self.faults.insert(self.all.len(), error);
                ([0.0; 3], [Written::Single; 3])
            }
        };
        self.all.push(Vertex { position: position.into(), written, used: false });
        Ok(())
    }

    /// The vertex of an index, as a corner of a face; none where there is no such vertex.
    pub(crate) fn corner(&mut self, index: usize, intake: &mut Intake) -> Result<Option<DVec3>, Error> {
        let Some(vertex) = self.all.get_mut(index) else { return Ok(None) };
        if !vertex.used {
            if let Some(error) = self.faults.get(&index) {
                return Err(error.clone());
            }
            vertex.used = true;
            for (written, value) in vertex.written.into_iter().zip(vertex.position.to_array()) {
                intake.written().add(written, value);
            }
        }
        Ok(Some(vertex.position))
    }

    /// Notes the faults of vertices that no face uses.
    pub(crate) fn note_faults(self, intake: &mut Intake) {
        for error in self.faults.into_values() {
            intake.ignore_fault(error, "of a vertex that no face uses");
        }
    }
}
