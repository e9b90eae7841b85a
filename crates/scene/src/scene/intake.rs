//! The parts common to all readers: faces that come as lists of vertices, surfaces and materials that come by name.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use radgrad_core::{DVec3, Polygon};

use super::{Note, Scene, keyhole, overlaps, split};
use crate::reading::Budget;
use crate::texture::Chart;
use crate::{Error, Face, Materials, Place, Position, Reading, Surface};

/// Bytes that the name of a surface may have: every face of a group looks it up.
const LONGEST_NAME: usize = 1024;

/// The treatment of faces that are no polygon: without area, with repeated vertices or with fewer than three, crossing themselves.
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
    reading: Reading,
    budget: Rc<Budget>,
    surfaces: HashMap<String, usize>,
    /// The kinds of statements ignored so far: each is noted once.
    ignored: HashSet<String>,
    /// The first note that there was no room for.
    overdrawn: Option<Error>,
}

impl Intake {
    pub(crate) fn new(scene: Scene, file: &Path, reading: Reading, budget: &Rc<Budget>) -> Self {
        let (budget, surfaces, ignored) = (Rc::clone(budget), HashMap::new(), HashSet::new());
        Self { scene, file: file.into(), reading, budget, surfaces, ignored, overdrawn: None }
    }

    /// Of the file of a mesh without materials: black, and its index.
    pub(crate) fn of_mesh(file: &Path, reading: Reading) -> Result<(Self, usize), Error> {
        let mut scene = Scene::new(["grey"])?;
        let material = scene.add_material("", [0.0], [0.0])?;
        Ok((Self::new(scene, file, reading, &Budget::new(reading.budget)), material))
    }

    pub(crate) fn budget(&self) -> &Budget {
        &self.budget
    }

    /// Whether faces may do without the values of their material.
    pub(crate) fn needs_materials(&self) -> bool {
        self.reading.materials == Materials::Required
    }

    /// Adds a material and returns its index.
    pub(crate) fn add_material(&mut self, name: &str, reflectance: &[f64], radiance: &[f64]) -> Result<usize, Error> {
        self.budget.take_many("materials", 1, 2 * size_of::<super::Material>() + 2 * name.len())?;
        self.scene.add_material(name, reflectance, radiance)
    }

    /// A name that is not too long for a surface.
    pub(crate) fn checked_name(name: &str) -> Result<&str, Error> {
        if name.len() <= LONGEST_NAME {
            return Ok(name);
        }
        Err(Error::expected(format!("a name of at most {LONGEST_NAME} bytes"), format!("one of {} bytes", name.len())))
    }

    /// Adds a surface, or an obstruction that only hides others, and returns its index.
    pub(crate) fn add_surface(&mut self, name: &str, exchanges: bool) -> Result<usize, Error> {
        let name = Self::checked_name(name)?;
        self.budget.take_many("surfaces", 1, 2 * size_of::<Surface>() + 4 * name.len())?;
        Ok(if exchanges { self.scene.add_surface(name) } else { self.scene.add_obstruction(name) })
    }

    fn note(&mut self, note: Note) -> Result<(), Error> {
        self.budget.take_many("notes", 1, 2 * size_of::<Note>() + 2 * LONGEST_NAME / 8)?;
        self.scene.notes.push(note);
        Ok(())
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
    pub(crate) fn surface(&mut self, name: &str) -> Result<usize, Error> {
        if let Some(&index) = self.surfaces.get(name) {
            return Ok(index);
        }
        let index = self.add_surface(name, true)?;
        self.surfaces.insert(name.to_owned(), index);
        Ok(index)
    }

    /// Notes that something was not used, at the first place of each kind.
    pub(crate) fn ignore(&mut self, place: Place, what: String) {
        if self.overdrawn.is_some() || self.ignored.contains(&what) {
            return;
        }
        let room = self.budget.take_many("notes", 1, 2 * size_of::<Note>() + 3 * what.len());
        match room {
            Ok(()) => {
                self.ignored.insert(what.clone());
                self.scene.notes.push(Note::Ignored { place, what });
            }
            Err(error) => self.overdrawn = Some(error.at(place)),
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
        let count = outline.vertices.len();
        self.take_face(count).map_err(|error| error.at(place.clone()))?;
        if self.reading.degenerate == Degenerate::Drop {
            self.leave_out_repeated(&mut outline, &place)?;
        }
        let polygon = match Polygon::new(outline.vertices.clone()) {
            Ok(polygon) => polygon,
            Err(error @ radgrad_core::Error::NotPlanar { distance, size, .. }) => {
                let Some(split) = split::triangles(&outline.vertices) else { return self.refuse(error, place, Error::Warped) };
                let triangles = self.add_triangles(surface, material, &outline, &split, &place)?;
                let surface = self.scene.surfaces[surface].name.clone();
                return self.note(Note::Split { place, surface, triangles, distance, size });
            }
            Err(error @ radgrad_core::Error::NotSimple { .. }) => {
                let parts = keyhole(&outline.vertices, 0.0).filter(|_| outline.coordinates.iter().all(Option::is_none));
                let Some(parts) = parts else { return self.refuse(error, place, Error::Face) };
                return self.add_parts(surface, material, parts, place);
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
                self.note(Note::SplitForTexture { place, surface, triangles, off })
            }
            Err(error) => Err(error.at(place)),
        }
    }

    /// Adds the parts of a face that comes back to a vertex of its own.
    fn add_parts(&mut self, surface: usize, material: usize, parts: Vec<Vec<DVec3>>, place: Place) -> Result<(), Error> {
        let (count, name) = (parts.len(), self.scene.surfaces[surface].name.clone());
        for part in parts {
            self.take_face(part.len()).map_err(|error| error.at(place.clone()))?;
            let polygon = Polygon::new(part).map_err(|error| Error::Face(error).at(place.clone()))?;
            self.scene.add_face(surface, material, polygon, Some(place.clone())).map_err(|error| error.at(place.clone()))?;
        }
        self.note(Note::Bridged { place, surface: name, parts: count })
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
            self.take_face(3).map_err(|error| error.at(place.clone()))?;
            let part = outline.part(triangle);
            let polygon = Polygon::new(part.vertices.clone()).map_err(|error| Error::Face(error).at(place.clone()))?;
            let charts = part.charts(&polygon).map_err(|error| error.at(place.clone()))?;
            let added = self.scene.add_charted_face(surface, material, polygon, Some(place.clone()), charts);
            added.map_err(|error| error.at(place.clone()))?;
        }
        Ok(split.len())
    }

    fn refuse(&mut self, error: radgrad_core::Error, place: Place, fault: fn(radgrad_core::Error) -> Error) -> Result<(), Error> {
        match self.reading.degenerate {
            Degenerate::Refuse => Err(fault(error).at(place)),
            Degenerate::Drop => self.note(Note::Dropped { place, reason: error }),
        }
    }

    /// Takes the memory of a face of so many vertices.
    fn take_face(&self, vertices: usize) -> Result<(), Error> {
        // A polygon keeps more of an edge than its vertex: about ten times as much.
        let size = size_of::<Face>() + vertices.saturating_mul(10 * size_of::<DVec3>());
        self.budget.take_many("faces", 1, size)
    }

    fn leave_out_repeated(&mut self, outline: &mut Outline, place: &Place) -> Result<(), Error> {
        let given = &outline.vertices;
        let count = given.len();
        let repeats = |&vertex: &usize| count > 1 && given[vertex] == given[(vertex + count - 1) % count];
        let (left_out, kept): (Vec<usize>, Vec<usize>) = (0..count).partition(repeats);
        for vertex in left_out {
            self.note(Note::RepeatedVertex { place: place.clone(), vertex })?;
        }
        *outline = outline.part(&kept);
        Ok(())
    }

    /// The scene, if it has faces; surfaces that got none are left out.
    pub(crate) fn finish(self) -> Result<Scene, Error> {
        let (budget, overlaps) = (Rc::clone(&self.budget), self.reading.overlaps);
        let place = self.place(Position::File);
        let mut scene = self.assembled()?;
        let count = scene.faces.len();
        let resolved = overlaps::resolve(&mut scene, 0.0, overlaps);
        resolved.map_err(|error| if error.place().is_none() { error.at(place) } else { error })?;
        let added = scene.faces.len().saturating_sub(count);
        budget.take_many("pieces of faces", added, size_of::<Face>() + 40 * size_of::<DVec3>())?;
        scene.leave_out_empty_surfaces();
        Ok(scene)
    }

    /// The same with faces that overlap.
    pub(crate) fn assembled(self) -> Result<Scene, Error> {
        if let Some(error) = self.overdrawn {
            return Err(error);
        }
        if self.scene.faces.is_empty() {
            let left_out = self.scene.notes.iter().filter(|note| matches!(note, Note::Dropped { .. })).count();
            let found = if left_out == 0 { "none".to_owned() } else { format!("only the {left_out} that were left out") };
            return Err(Error::expected("at least one face", found).at(self.place(Position::File)));
        }
        let mut scene = self.scene;
        scene.leave_out_empty_surfaces();
        Ok(scene)
    }
}

impl Scene {
    fn leave_out_empty_surfaces(&mut self) {
        self.surfaces.retain(|surface| !surface.faces.is_empty());
        for (index, surface) in self.surfaces.iter().enumerate() {
            for &face in &surface.faces {
                self.faces[face].surface = index;
            }
        }
    }
}
