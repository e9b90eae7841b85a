//! Faces that a receiver sees little past: those that fill most of its view, and those that have hidden most so far, from behind
//! too.

use radgrad_core::DVec3;
use radgrad_scene::largest;

use crate::mesh::Mesh;

/// Most faces of either kind.
const MOST: usize = 16;

/// The faces.
#[derive(Debug, Clone, Default)]
pub(crate) struct Screens {
    /// The largest part of the hemisphere that something of a face fills: the largest first.
    filling: Vec<(f64, usize)>,
    /// How many things a face has hidden: the most first.
    hiding: Vec<(usize, usize)>,
}

impl Screens {
    /// Something of a face fills a part of the hemisphere.
    pub(crate) fn fill(&mut self, face: usize, part: f64) {
        match self.filling.iter_mut().find(|screen| screen.1 == face) {
            Some(screen) => screen.0 = largest(screen.0, part),
            None => self.filling.push((part, face)),
        }
        self.filling.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        self.filling.truncate(MOST);
    }

    /// A face hides something.
    pub(crate) fn hide(&mut self, face: usize) {
        match self.hiding.iter_mut().find(|screen| screen.1 == face) {
            Some(screen) => screen.0 += 1,
            None => self.hiding.push((1, face)),
        }
        self.hiding.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    }

    fn faces(&self) -> impl Iterator<Item = usize> {
        let filling = self.filling.iter().map(|screen| screen.1);
        let hiding = self.hiding.iter().take(MOST).map(|screen| screen.1);
        hiding.clone().chain(filling.filter(move |face| hiding.clone().all(|other| other != *face)))
    }

    /// Their convex parts.
    pub(crate) fn polygons<'a>(&self, mesh: &'a Mesh) -> Vec<&'a [DVec3]> {
        self.faces().flat_map(|face| mesh.convex_parts(face)).map(|part| &part[..]).collect()
    }

    /// The face that alone hides some points, and all between them, from others, if there is one.
    pub(crate) fn between(&self, mesh: &Mesh, ends: [&[DVec3]; 2]) -> Option<usize> {
        self.faces().find(|&face| mesh.hides(face, ends))
    }
}
