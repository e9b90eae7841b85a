//! A scene as it is drawn: faces with materials, points, and an exact solution if it has one; and its forms for solver and
//! oracle.

use std::f64::consts::PI;
use std::fmt::Write;

use glam::DVec3;
use radgrad_core::Polygon;
use radgrad_oracle::scene as oracle;
use radgrad_oracle::scene::known::FacingRectangles;
use radgrad_scene::{Quantity, Scene, Texture, fnv1a};
use radgrad_solver::Marking;

use crate::cases::sampler::Sampler;

use super::written::{self, Lies, Written};

/// Values on a grid over a parallelogram, whose corners have the coordinates (0, 0), (1, 0), (1, 1) and (0, 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Factors on the face's own values, row by row, at most 1; the same in every channel.
    pub texels: Vec<f64>,
    /// The quantity that it varies.
    pub quantity: Quantity,
}

/// A face.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Counter-clockwise seen from the side that gives and takes light.
    pub corners: Vec<DVec3>,
    /// Reflectance in each channel; the largest where a grid varies it.
    pub reflectance: Vec<f64>,
    /// Emitted radiosity in each channel; the largest where a grid varies it.
    pub emitted: Vec<f64>,
    /// Textures: at most one a quantity.
    pub grids: Vec<Grid>,
    /// Where it lies on another face: to be cut out of that one.
    pub lies: Option<Lies>,
}

/// A point to ask at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Index of the face.
    pub part: usize,
    /// A point of it.
    pub position: DVec3,
}

/// The exact solution of a scene, which needs no walks.
#[derive(Debug, Clone, PartialEq)]
pub enum Exact {
    /// Nothing.
    Nothing,
    /// The radiosity is this everywhere.
    Even(f64),
    /// Two rectangles, moved by nothing.
    Facing(FacingRectangles),
}

/// The outcome that is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expected {
    /// An answer.
    Answer,
    /// No answer.
    Refusal,
    /// An answer that is right, or none.
    Either,
}

/// Why there is no truth.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A face is no polygon.
    #[error("a face is no polygon: {0}")]
    Polygon(#[from] radgrad_core::Error),
    /// The oracle refuses the scene or the question.
    #[error("the oracle: {0}")]
    Oracle(#[from] radgrad_oracle::Error),
}

/// How a scene is changed before it is asked for; the truth is that of the unchanged one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Not at all.
    None,
    /// Lengths times a power of two: every digit of the answer stays.
    Scale(f64),
    /// Shifted, exactly.
    Shift(DVec3),
    /// Turned, moved, and read from a file with rounded coordinates.
    File(Written),
}

/// A scene to be asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Its faces.
    pub parts: Vec<Part>,
    /// Points.
    pub probes: Vec<Probe>,
    /// Its exact solution.
    pub exact: Exact,
    /// The outcome that is right.
    pub expected: Expected,
    /// Whether every ray from a face ends on the lit side of another.
    pub closed: bool,
    /// How it is changed for the solver.
    pub change: Change,
    /// Relative error that the solver is asked for.
    pub error: f64,
    /// Degree of the polynomials on elements, if not that of the solver's choice.
    pub degree: Option<usize>,
    /// How else the solver is asked.
    pub ways: Ways,
}

/// Ways of the solver, other than its usual ones.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ways {
    /// The rule by which elements are divided.
    pub marking: Marking,
    /// Whether the points are served.
    pub for_points: bool,
    /// Whether it is given more effort than others.
    pub long: bool,
}

impl Probe {
    /// The index of the face and `[x, y]`, as [`FacingRectangles`] takes points.
    pub(super) const fn on_a_rectangle(&self) -> (usize, [f64; 2]) {
        (self.part, [self.position.x, self.position.y])
    }
}

impl Part {
    /// Without a texture, the same in every channel.
    #[must_use]
    pub fn new(corners: Vec<DVec3>, reflectance: f64, emitted: f64) -> Self {
        Self { corners, reflectance: vec![reflectance], emitted: vec![emitted], grids: Vec::new(), lies: None }
    }
}

impl Model {
    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.parts.first().map_or(1, |part| part.reflectance.len())
    }

    /// Gives a scene of one channel three that differ.
    pub(crate) fn colour(&mut self, s: &mut Sampler) {
        for part in &mut self.parts {
            let (rho, emitted) = (part.reflectance[0], part.emitted[0]);
            part.reflectance = vec![rho, rho * s.between(0.1, 1.0), rho * s.between(0.1, 1.0)];
            part.emitted = vec![emitted, emitted * s.between(0.1, 1.0), emitted * s.between(0.1, 1.0)];
        }
    }

    /// The scene as it is given to the solver: a surface `f{index}` for each face, but for those that a reader leaves out.
    ///
    /// # Errors
    /// If a face or a material is refused.
    pub fn scene(&self) -> Result<Scene, radgrad_scene::Error> {
        if let Change::File(_) = self.change {
            return written::read(self);
        }
        let mut scene = Scene::new((0..self.channels()).map(|channel| format!("c{channel}")))?;
        for (index, part) in self.parts.iter().enumerate() {
            let radiance: Vec<f64> = part.emitted.iter().map(|emitted| emitted / PI).collect();
            let material = scene.add_material(format!("m{index}"), part.reflectance.clone(), radiance)?;
            let surface = scene.add_surface(format!("f{index}"));
            let corners = part.corners.iter().map(|&corner| self.change.apply(corner)).collect();
            let polygon = Polygon::new(corners).map_err(radgrad_scene::Error::Face)?;
            for grid in &part.grids {
                let channels = self.channels();
                let texel = |column: usize, row: usize| vec![grid.texels[row * grid.size[0] + column]; channels];
                scene.set_texture(material, grid.quantity, Texture::from_fn("grid", grid.size, channels, texel)?)?;
            }
            match part.grids[..] {
                [] => scene.add_face(surface, material, polygon, None)?,
                _ => scene.add_textured_face(surface, material, polygon, &UNIT, None)?,
            };
        }
        Ok(scene)
    }

    /// The probes as they are given to the solver: positions and normals.
    ///
    /// # Errors
    /// If a face is no polygon.
    pub fn asked(&self) -> Result<Vec<(DVec3, DVec3)>, radgrad_core::Error> {
        let placed = |probe: &Probe| {
            let normal = Polygon::new(self.parts[probe.part].corners.clone())?.normal();
            Ok((self.change.apply(probe.position), self.change.turned(normal)))
        };
        self.probes.iter().map(placed).collect()
    }

    /// The visible pieces of each face where others lie on it: its index, and the outline of each piece.
    #[must_use]
    pub fn visible_pieces(&self) -> Vec<(usize, Vec<DVec3>)> {
        written::visible_pieces(&self.parts)
    }

    /// A channel of the unchanged scene as the oracle takes it: a face for each of [`Self::visible_pieces`].
    ///
    /// # Errors
    /// If a face is no polygon, or a value out of range.
    pub fn oracle(&self, channel: usize) -> Result<oracle::Scene, Error> {
        let face = |(index, outline): (usize, Vec<DVec3>)| {
            let part = &self.parts[index];
            let polygon = Polygon::new(outline)?;
            let [reflectance, emitted] = [part.reflectance[channel], part.emitted[channel]];
            let pattern = (!part.grids.is_empty()).then(|| {
                let (origin, sides) = (part.corners[0], [part.corners[1] - part.corners[0], part.corners[3] - part.corners[0]]);
                let grids = part.grids.clone();
                oracle::Pattern::new(move |at| {
                    let place = along(at - origin, sides);
                    grids.iter().fold([reflectance, emitted], |[reflectance, emitted], grid| match grid.quantity {
                        Quantity::Reflectance => [reflectance * grid.value_at(place), emitted],
                        Quantity::Radiance => [reflectance, emitted * grid.value_at(place)],
                    })
                })
            });
            Ok(oracle::Face { polygon, reflectance, emitted, exchanges: true, pattern })
        };
        let faces: Result<Vec<_>, radgrad_core::Error> = self.visible_pieces().into_iter().map(face).collect();
        Ok(oracle::Scene::new(faces?)?)
    }

    /// A seed for random numbers that is that of the scene's numbers, however it is changed.
    #[must_use]
    pub(crate) fn seed(&self) -> u64 {
        let corners = self.parts.iter().flat_map(|part| part.corners.iter().flat_map(|corner| corner.to_array()));
        let values = self.parts.iter().flat_map(|part| part.reflectance.iter().chain(&part.emitted).copied());
        fnv1a(corners.chain(values).flat_map(|number| number.to_bits().to_le_bytes()))
    }

    /// Whether any face has a texture of this quantity.
    #[must_use]
    pub(crate) fn has_grid(&self, quantity: Quantity) -> bool {
        self.parts.iter().flat_map(|part| &part.grids).any(|grid| grid.quantity == quantity)
    }

    /// As Wavefront OBJ and its MTL library, of the scene as it is given to the solver, without textures: `name` is that of the
    /// library's file.
    #[must_use]
    pub fn to_obj(&self, name: &str) -> [String; 2] {
        let (mut obj, mut mtl) = (format!("mtllib {name}\n"), String::new());
        // Writing to a string does not fail.
        for (index, part) in self.parts.iter().enumerate() {
            let value = |values: &[f64], unit: f64| {
                let written_value = |channel: usize| format!("{:?}", values[channel.min(values.len() - 1)] * unit);
                [0, 1, 2].map(written_value).join(" ")
            };
            let (kd, ke) = (value(&part.reflectance, 1.0), value(&part.emitted, 1.0 / PI));
            let _ = writeln!(mtl, "newmtl m{index}\nKd {kd}\nKe {ke}");
            let _ = writeln!(obj, "g f{index}\nusemtl m{index}");
            let corners = part.corners.iter().map(|&corner| self.change.apply(corner));
            obj += &written::vertices(corners, |coordinate| self.change.text(coordinate));
            let places: Vec<String> = (1..=part.corners.len()).rev().map(|place| format!("-{place}")).collect();
            let _ = writeln!(obj, "f {}", places.join(" "));
        }
        [obj, mtl]
    }

    /// The probes as JSON Lines, as `radgrad solve --points` reads them.
    #[must_use]
    pub fn to_points(&self) -> String {
        let line = |(index, (at, normal)): (usize, (DVec3, DVec3))| {
            format!("{{\"id\":\"{index}\",\"position\":{:?},\"normal\":{:?}}}\n", at.to_array(), normal.to_array())
        };
        self.asked().map_or_else(|_| String::new(), |asked| asked.into_iter().enumerate().map(line).collect())
    }
}

/// Texture coordinates of the corners of a parallelogram.
const UNIT: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Coordinates of a vector along two others.
fn along(at: DVec3, [a, b]: [DVec3; 2]) -> [f64; 2] {
    let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
    let (pa, pb) = (at.dot(a), at.dot(b));
    let determinant = aa * bb - ab * ab;
    [(pa * bb - pb * ab) / determinant, (pb * aa - pa * ab) / determinant]
}

impl Grid {
    fn value_at(&self, place: [f64; 2]) -> f64 {
        let texel = |axis: usize| {
            let count = self.size[axis];
            (0..count).rev().find(|&k| place[axis] * count as f64 >= k as f64).unwrap_or(0)
        };
        self.texels[texel(1) * self.size[0] + texel(0)]
    }
}

impl Change {
    /// Where a point of the changed scene is in the unchanged one: exact where the change is.
    #[must_use]
    pub(crate) fn undone(self, point: DVec3) -> DVec3 {
        match self {
            Self::None => point,
            Self::Scale(factor) => point / factor,
            Self::Shift(by) => point - by,
            Self::File(written) => written.undone(point),
        }
    }

    fn apply(self, point: DVec3) -> DVec3 {
        match self {
            Self::None => point,
            Self::Scale(factor) => point * factor,
            Self::Shift(by) => point + by,
            Self::File(written) => written.placed(point),
        }
    }

    fn turned(self, direction: DVec3) -> DVec3 {
        if let Self::File(written) = self { written.turned(direction) } else { direction }
    }

    /// A coordinate in a file.
    fn text(self, coordinate: f64) -> String {
        if let Self::File(written) = self { written.rounding.text(coordinate) } else { format!("{coordinate:?}") }
    }
}
