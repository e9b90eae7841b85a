//! What the readers have in common: faces that come as lists of vertices, surfaces and materials that come by name.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use radgrad_core::{DVec3, Polygon};

use super::{Note, Scene, split};
use crate::texture::Chart;
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

/// A face that is being read: its vertices, and at each of them the coordinates of the textures of its reflectance and of its
/// radiance, where it has these.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outline {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) coordinates: [Option<Vec<[f64; 2]>>; 2],
}

impl Outline {
    /// Some of the vertices.
    fn part(&self, kept: &[usize]) -> Self {
        let coordinates = self.coordinates.each_ref().map(|of| of.as_ref().map(|of| kept.iter().map(|&i| of[i]).collect()));
        Self { vertices: kept.iter().map(|&i| self.vertices[i]).collect(), coordinates }
    }

    fn charts(&self, polygon: &Polygon) -> Result<[Option<Chart>; 2], Error> {
        let [reflectance, radiance] = &self.coordinates;
        let chart = |of: &Option<Vec<[f64; 2]>>| of.as_ref().map(|of| Chart::new(polygon, of)).transpose();
        Ok([chart(reflectance)?, chart(radiance)?])
    }
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
    pub(crate) fn add_face(&mut self, surface: usize, material: usize, vertices: Vec<DVec3>, place: Place) -> Result<(), Error> {
        self.add_textured_face(surface, material, Outline { vertices, ..Outline::default() }, place)
    }

    /// The same with texture coordinates.
    pub(crate) fn add_textured_face(
        &mut self,
        surface: usize,
        material: usize,
        mut outline: Outline,
        place: Place,
    ) -> Result<(), Error> {
        if self.degenerate == Degenerate::Drop {
            self.leave_out_repeated(&mut outline, &place);
        }
        let polygon = match Polygon::new(outline.vertices.clone()) {
            Ok(polygon) => polygon,
            Err(error @ radgrad_core::Error::NotPlanar { distance, size, .. }) => {
                let Some(split) = split::triangles(&outline.vertices) else { return self.refuse(error, place, Error::Warped) };
                let triangles = self.add_triangles(surface, material, &outline, &split, &place)?;
                let surface = self.scene.surfaces[surface].name.clone();
                self.scene.notes.push(Note::Split { place, surface, triangles, distance, size });
                return Ok(());
            }
            Err(error) => return self.refuse(error, place, Error::Face),
        };
        match outline.charts(&polygon) {
            Ok(charts) => {
                let added = self.scene.add_charted_face(surface, material, polygon, Some(place.clone()), charts);
                added.map(|_| ()).map_err(|error| error.at(place))
            }
            Err(Error::Chart { off, .. }) => {
                let Some(split) = split::triangles(&outline.vertices) else {
                    return Err(Error::expected("a face that can be cut into triangles", "one that touches itself").at(place));
                };
                let triangles = self.add_triangles(surface, material, &outline, &split, &place)?;
                let surface = self.scene.surfaces[surface].name.clone();
                self.scene.notes.push(Note::SplitForTexture { place, surface, triangles, off });
                Ok(())
            }
            Err(error) => Err(error.at(place)),
        }
    }

    /// Adds triangles of an outline and returns how many there are.
    fn add_triangles(
        &mut self,
        surface: usize,
        material: usize,
        outline: &Outline,
        split: &[[usize; 3]],
        place: &Place,
    ) -> Result<usize, Error> {
        for triangle in split {
            let part = outline.part(triangle);
            let polygon = Polygon::new(part.vertices.clone()).map_err(|error| Error::Face(error).at(place.clone()))?;
            let charts = part.charts(&polygon).map_err(|error| error.at(place.clone()))?;
            let added = self.scene.add_charted_face(surface, material, polygon, Some(place.clone()), charts);
            added.map_err(|error| error.at(place.clone()))?;
        }
        Ok(split.len())
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

    fn leave_out_repeated(&mut self, outline: &mut Outline, place: &Place) {
        let given = &outline.vertices;
        let count = given.len();
        let repeats = |&vertex: &usize| count > 1 && given[vertex] == given[(vertex + count - 1) % count];
        let (left_out, kept): (Vec<usize>, Vec<usize>) = (0..count).partition(repeats);
        for vertex in left_out {
            self.scene.notes.push(Note::RepeatedVertex { place: place.clone(), vertex });
        }
        *outline = outline.part(&kept);
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
