//! A scene from arrays in memory: each face a list of vertices, the name of its surface, its reflectance and its emission.
//!
//! The same rules hold as for files, but that a face without area is refused with its index unless it is to be dropped, that faces in one
//! plane stay as they are, and that coordinates are exact unless a precision is given: who gives arrays counts on their indices.

use std::collections::HashMap;
use std::path::Path;

use radgrad_core::DVec3;

use super::Scene;
use super::intake::Intake;
use super::note::Note;
use crate::error::Error;
use crate::place::Position;
use crate::reading::{Budget, Degenerate, Reading};

/// Stands in the place of a file's name.
const FILE: &str = "arrays";

/// A face in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenFace {
    /// Its vertices, counter-clockwise seen from the side that gives and takes light.
    pub vertices: Vec<DVec3>,
    /// Name of its surface: faces with one name are of one surface.
    pub surface: String,
    /// Reflectance in each channel, in [0, 1].
    pub reflectance: Vec<f64>,
    /// Emitted radiance in each channel: 1/pi of the emitted radiosity.
    pub radiance: Vec<f64>,
}

impl Scene {
    /// A scene with these faces.
    ///
    /// ```
    /// use radgrad_core::DVec3;
    /// use radgrad_scene::{Degenerate, GivenFace, Scene};
    /// let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    /// let face = |z: f64| GivenFace {
    ///     vertices: corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec(),
    ///     surface: "shelves".to_owned(),
    ///     reflectance: vec![0.5],
    ///     radiance: vec![0.0],
    /// };
    /// let scene = Scene::from_faces(["grey"], [face(0.0), face(1.0)], Degenerate::Refuse)?;
    /// assert_eq!((scene.faces().len(), scene.surfaces().len(), scene.materials().len()), (2, 1, 1));
    /// let warped = GivenFace { vertices: vec![DVec3::ZERO, DVec3::X], ..face(0.0) };
    /// let error = Scene::from_faces(["grey"], [face(0.0), warped], Degenerate::Refuse).unwrap_err().to_string();
    /// assert!(error.contains("faces[1]") && error.contains("at least 3 vertices"), "{error}");
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there is no face, one is no polygon and [`Reading::degenerate`] does not drop it, or a reflectance or radiance is out of range.
    pub fn from_faces<C: Into<String>>(
        channels: impl IntoIterator<Item = C>,
        faces: impl IntoIterator<Item = GivenFace>,
        reading: impl Into<Reading>,
    ) -> Result<Self, Error> {
        let reading = reading.into();
        // Data in memory already need no other budget.
        let mut intake = Intake::new(Self::new(channels)?, Path::new(FILE), reading, &Budget::new(Reading::UNLIMITED));
        let mut materials: HashMap<Vec<u64>, usize> = HashMap::new();
        for (index, face) in faces.into_iter().enumerate() {
            let place = intake.place(Position::Member(format!("faces[{index}]")));
            let values = face.reflectance.iter().chain(&face.radiance).map(|value| value.to_bits()).collect();
            let material = match materials.get(&values) {
                Some(material) => *material,
                None => {
                    let name = format!("{FILE}: faces[{index}]");
                    let added = intake.add_material(&name, &face.reflectance, &face.radiance);
                    let added = added.map_err(|error| error.at_place(place.clone()))?;
                    materials.insert(values, added);
                    added
                }
            };
            let surface = intake.surface(&face.surface).map_err(|error| error.at_place(place.clone()))?;
            intake.add_face(surface, material, face.vertices, place)?;
        }
        let scene = intake.assembled()?;
        let left_out = scene.notes.iter().find_map(|note| match note {
            Note::LeftOut { place, reason, .. } => Some((place.clone(), reason.clone())),
            _ => None,
        });
        match (left_out, reading.degenerate) {
            (Some((place, Some(reason))), Degenerate::Refuse) => Err(Error::Face(reason).at_place(place)),
            (Some((place, None)), Degenerate::Refuse) => {
                Err(Error::expected("a face that is wider than its precision", "one that is not").at_place(place))
            }
            _ => Ok(scene),
        }
    }
}
