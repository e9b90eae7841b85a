//! The parts common to all readers: faces that come as lists of vertices, surfaces and materials that come by name.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use radgrad_core::DVec3;

use super::assembly::Assembly;
use super::note::Note;
use super::outline::{Given, Outline, take_face};
use super::{Face, Scene, Surface, overlaps};
use crate::error::Error;
use crate::place::{Place, Position};
use crate::precision::WrittenPrecision;
use crate::reading::{Budget, Materials, Reading};
use crate::words;

/// Bytes that the name of a surface may have: every face of a group looks it up.
const LONGEST_NAME: usize = 1024;

/// A scene that is being read.
#[derive(Debug)]
pub(crate) struct Intake {
    scene: Scene,
    given: Vec<Given>,
    file: Arc<Path>,
    reading: Reading,
    budget: Rc<Budget>,
    surfaces: HashMap<String, usize>,
    /// The kinds of statements ignored so far: each is noted once.
    ignored: HashSet<String>,
    /// The first note that there was no room for.
    overdrawn: Option<Error>,
    written: WrittenPrecision,
}

impl Intake {
    pub(crate) fn new(scene: Scene, file: &Path, reading: Reading, budget: &Rc<Budget>) -> Self {
        let (budget, surfaces, ignored) = (Rc::clone(budget), HashMap::new(), HashSet::new());
        let (given, written) = (Vec::new(), WrittenPrecision::new());
        Self { scene, given, written, file: file.into(), reading, budget, surfaces, ignored, overdrawn: None }
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

    /// The coordinates as the file writes them.
    pub(crate) const fn written(&mut self) -> &mut WrittenPrecision {
        &mut self.written
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

    pub(crate) fn place(&self, position: Position) -> Place {
        Place::in_file(&self.file, position)
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
            Err(error) => self.overdrawn = Some(error.at_place(place)),
        }
    }

    /// Notes an error that does not matter: the substitute, or why nobody needs it.
    pub(crate) fn ignore_fault(&mut self, error: Error, why: &str) {
        match error {
            Error::At { place, fault } => self.ignore(place, format!("{fault}: {why}")),
            error => self.ignore(self.place(Position::File), format!("{error}: {why}")),
        }
    }

    /// The text of the file, or of one that it names: of one that is no UTF-8 the encoding is noted.
    pub(crate) fn decode<'a>(&mut self, content: &'a [u8], file: &Path) -> Result<Cow<'a, str>, Error> {
        let text = words::text_of(content);
        let (text, note) = text.map_err(|(line, error)| error.at_place(Place::new(file, Position::Line(line))))?;
        if let Cow::Owned(text) = &text {
            self.budget.take("text", text.len() as u64)?;
        }
        if let Some((line, note)) = note {
            self.ignore(Place::new(file, Position::Line(line)), note);
        }
        Ok(text)
    }

    /// The name of the file.
    pub(crate) fn file(&self) -> Arc<Path> {
        Arc::clone(&self.file)
    }

    /// Adds a face: its treatment is decided when all are known.
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
        if self.reading.flip {
            outline.vertices.reverse();
            outline.coordinates.iter_mut().flatten().for_each(|coordinates| coordinates.reverse());
        }
        take_face(&self.budget, outline.vertices.len()).map_err(|error| error.at_place(place.clone()))?;
        self.given.push(Given { surface, material, outline, place });
        Ok(())
    }

    /// The scene, if it has faces; surfaces that got none are left out.
    pub(crate) fn finish(self) -> Result<Scene, Error> {
        let (budget, overlaps) = (Rc::clone(&self.budget), self.reading.overlaps);
        let place = self.place(Position::File);
        let mut scene = self.assembled()?;
        let count = scene.faces.len();
        let rounding = scene.modelling.precision;
        let resolved = overlaps::resolve(&mut scene, rounding, overlaps);
        resolved.map_err(|error| if error.place().is_none() { error.at_place(place) } else { error })?;
        let added = scene.faces.len().saturating_sub(count);
        budget.take_many("pieces of faces", added, size_of::<Face>() + 40 * size_of::<DVec3>())?;
        scene.leave_out_empty_surfaces();
        Ok(scene)
    }

    /// The same with faces that overlap.
    pub(crate) fn assembled(self) -> Result<Scene, Error> {
        let place = self.place(Position::File);
        if let Some(error) = self.overdrawn {
            return Err(error);
        }
        let mut scene = self.scene;
        let rounding = self.reading.precision.unwrap_or_else(|| self.written.rounding());
        Assembly { scene: &mut scene, budget: &self.budget, degenerate: self.reading.degenerate }.add(self.given, rounding)?;
        if scene.faces.is_empty() {
            let first = scene.notes.iter().find_map(|note| match note {
                Note::LeftOut { place, reason, .. } => Some((place.clone(), reason)),
                _ => None,
            });
            let (place, found) = match first {
                Some((place, Some(reason))) => (place, format!("none: {reason}")),
                Some((place, None)) => (place, "none that is wider than its coordinates are rounded".to_owned()),
                None => (place, "none".to_owned()),
            };
            return Err(Error::expected("at least one face", found).at_place(place));
        }
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
