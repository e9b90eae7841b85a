//! What the readers have in common: faces that come as lists of vertices, surfaces and materials that come by name.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use radgrad_core::{DVec3, Polygon};

use super::{Note, Scene, split};
use crate::{Error, Place, Position};

/// What to do with faces that are no polygon: without area, with repeated vertices or with fewer than three, crossing themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Degenerate {
    /// Refuse the file, naming the face.
    #[default]
    Refuse,
    /// Leave out vertices that repeat their predecessor, then faces that are still no polygon; each gives a [`Note`].
    Drop,
}

/// A scene that is being read.
#[derive(Debug)]
pub(crate) struct Intake {
    scene: Scene,
    file: Arc<Path>,
    degenerate: Degenerate,
    surfaces: HashMap<String, usize>,
    /// What was ignored already: each kind is noted once.
    ignored: Vec<String>,
}

impl Intake {
    pub(crate) fn new(scene: Scene, file: &Path, degenerate: Degenerate) -> Self {
        Self { scene, file: file.into(), degenerate, surfaces: HashMap::new(), ignored: Vec::new() }
    }

    pub(crate) fn place(&self, position: Position) -> Place {
        Place::at(&self.file, position)
    }

    pub(crate) const fn scene(&mut self) -> &mut Scene {
        &mut self.scene
    }

    pub(crate) fn set_title(&mut self, title: String) {
        self.scene.title = Some(title);
    }

    pub(crate) const fn set_enclosure(&mut self, enclosure: bool) {
        self.scene.enclosure = Some(enclosure);
    }

    /// The surface of this name, made where there is none yet.
    pub(crate) fn surface(&mut self, name: &str) -> usize {
        if let Some(&index) = self.surfaces.get(name) {
            return index;
        }
        let index = self.scene.add_surface(name);
        self.surfaces.insert(name.to_owned(), index);
        index
    }

    /// Notes that something was not used, at the first place of each kind.
    pub(crate) fn ignore(&mut self, place: Place, what: String) {
        if !self.ignored.contains(&what) {
            self.ignored.push(what.clone());
            self.scene.notes.push(Note::Ignored { place, what });
        }
    }

    /// Adds the polygon through `vertices`, or the triangles it has to be split into, or nothing where that was asked for.
    pub(crate) fn add_face(
        &mut self,
        surface: usize,
        material: usize,
        mut vertices: Vec<DVec3>,
        place: Place,
    ) -> Result<(), Error> {
        if self.degenerate == Degenerate::Drop {
            self.leave_out_repeated(&mut vertices, &place);
        }
        match Polygon::new(vertices.clone()) {
            Ok(polygon) => self.scene.add_face(surface, material, polygon, Some(place)).map(|_| ()),
            Err(error @ radgrad_core::Error::NotPlanar { distance, size, .. }) => {
                let Some(split) = split::triangles(&vertices) else { return self.refuse(error, place, Error::Warped) };
                for triangle in &split {
                    match Polygon::new(triangle.map(|i| vertices[i]).to_vec()) {
                        Ok(polygon) => self.scene.add_face(surface, material, polygon, Some(place.clone()))?,
                        Err(error) => return Err(Error::Face(error).at(place)),
                    };
                }
                let surface = self.scene.surfaces[surface].name.clone();
                self.scene.notes.push(Note::Split { place, surface, triangles: split.len(), distance, size });
                Ok(())
            }
            Err(error) => self.refuse(error, place, Error::Face),
        }
    }

    fn refuse(&mut self, error: radgrad_core::Error, place: Place, fault: fn(radgrad_core::Error) -> Error) -> Result<(), Error> {
        match self.degenerate {
            Degenerate::Refuse => Err(fault(error).at(place)),
            Degenerate::Drop => {
                self.scene.notes.push(Note::Dropped { place, reason: error });
                Ok(())
            }
        }
    }

    fn leave_out_repeated(&mut self, vertices: &mut Vec<DVec3>, place: &Place) {
        let given = std::mem::take(vertices);
        let count = given.len();
        for (vertex, &v) in given.iter().enumerate() {
            if count > 1 && v == given[(vertex + count - 1) % count] {
                self.scene.notes.push(Note::RepeatedVertex { place: place.clone(), vertex });
            } else {
                vertices.push(v);
            }
        }
    }

    /// The scene, if it has faces; surfaces that got none are left out.
    pub(crate) fn finish(self) -> Result<Scene, Error> {
        if self.scene.faces.is_empty() {
            let left_out = self.scene.notes.iter().filter(|note| matches!(note, Note::Dropped { .. })).count();
            let found = if left_out == 0 { "none".to_owned() } else { format!("only the {left_out} that were left out") };
            return Err(Error::expected("at least one face", found).at(self.place(Position::File)));
        }
        let mut scene = self.scene;
        scene.surfaces.retain(|surface| !surface.faces.is_empty());
        for (index, surface) in scene.surfaces.iter().enumerate() {
            for &face in &surface.faces {
                scene.faces[face].surface = index;
            }
        }
        Ok(scene)
    }
}
