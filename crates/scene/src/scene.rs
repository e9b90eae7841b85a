//! A scene: named surfaces of one-sided polygons, each of a material.
//!
//! A [`Face`] is one polygon, lit and seen on the side from which it is counter-clockwise; it is opaque from both. A [`Surface`]
//! has a name and one or more faces. A [`Material`] has a diffuse reflectance and an emitted radiance in each channel of the scene;
//! channels are names (`r`, `g`, `b`; `grey`; wavelengths), and mean nothing here. Lengths are in one unit of the file's choice.
//!
//! Everything in a scene is valid: polygons are those of `radgrad-core`, reflectances are in [0, 1], radiances are finite and
//! not negative, and every index in it exists.

pub(crate) mod arrays;
mod assembly;
mod bytes;
mod healing;
mod indexed;
pub(crate) mod intake;
mod keyhole;
pub(crate) mod material;
pub(crate) mod note;
pub(crate) mod outline;
pub(crate) mod overlaps;
pub(crate) mod prepared;
mod replaced;
pub(crate) mod seams;
pub(crate) mod split;
pub(crate) mod vertices;

use std::f64::consts::PI;
use std::sync::Arc;

use radgrad_core::{DVec3, Polygon};
use serde::Serialize;

use self::indexed::Indexed;
use self::material::Material;
use self::note::Note;
use self::split::triangles;
use crate::error::Error;
use crate::messages::{candidates, printable};
use crate::place::Place;
use crate::texture::chart::Chart;
use crate::texture::{Quantity, Texture};

/// Named surfaces of polygons with materials.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// use radgrad_scene::Scene;
/// let mut scene = Scene::new(["grey"])?;
/// let white = scene.add_material("white", [0.8], [0.0])?;
/// let lamp = scene.add_material("lamp", [0.0], [10.0])?;
/// let [floor, ceiling] = ["floor", "ceiling"].map(|name| scene.add_surface(name));
/// let square = |z: f64| [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec3::new(x, y, z));
/// let (up, mut down) = (square(0.0).to_vec(), square(1.0).to_vec());
/// down.reverse(); // counter-clockwise from below
/// scene.add_face(floor, white, Polygon::new(up).unwrap(), None)?;
/// scene.add_face(ceiling, lamp, Polygon::new(down).unwrap(), None)?;
/// assert_eq!(scene.area_of(ceiling), 4.0);
/// assert_eq!(scene.emitted_power(0), 40.0 * std::f64::consts::PI);
/// assert_eq!(scene.surface_named("floor")?, floor);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    title: Option<String>,
    enclosure: Option<bool>,
    channels: Vec<String>,
    materials: Vec<Material>,
    surfaces: Vec<Surface>,
    faces: Vec<Face>,
    notes: Vec<Note>,
    modelling: Modelling,
    indexed: Indexed,
}

/// How far a scene may be from the one that its file was meant to describe: the rounding of its coordinates, and changes on
/// reading.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Modelling {
    /// By how much a coordinate may be off, in the unit of the scene; 0 where coordinates are exact.
    pub precision: f64,
    /// The largest distance by which a vertex was moved.
    pub distance: f64,
    /// The part of the area that was left out, or that edges swept when they were moved, at most.
    pub share: f64,
}

/// A named part of a scene: one or more faces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Surface {
    name: String,
    faces: Vec<usize>,
    exchanges: bool,
}

impl Surface {
    /// Its name. Not every format makes names unique.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Indices of its faces in [`Scene::faces`], ascending.
    #[must_use]
    pub fn faces(&self) -> &[usize] {
        &self.faces
    }

    /// Whether it gives and takes light, and so has a row among the form factors; else it only hides others.
    #[must_use]
    pub const fn exchanges(&self) -> bool {
        self.exchanges
    }
}

/// One polygon of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    polygon: Polygon,
    surface: usize,
    material: usize,
    place: Option<Place>,
    /// Where it has the textures of its material: of the reflectance and of the radiance.
    charts: [Option<Chart>; 2],
    /// The largest distance by which reading moved one of its vertices.
    moved: f64,
}

impl Face {
    /// The polygon, counter-clockwise seen from the side that gives and takes light.
    #[must_use]
    pub const fn polygon(&self) -> &Polygon {
        &self.polygon
    }

    /// Index of its surface.
    #[must_use]
    pub const fn surface(&self) -> usize {
        self.surface
    }

    /// Index of its material.
    #[must_use]
    pub const fn material(&self) -> usize {
        self.material
    }

    /// Where it was read.
    #[must_use]
    pub const fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }

    /// The largest distance by which reading moved one of its vertices.
    #[must_use]
    pub const fn moved(&self) -> f64 {
        self.moved
    }

    /// Where it has a texture of its material; without a chart the material's own values hold all over it.
    #[must_use]
    pub const fn chart(&self, quantity: Quantity) -> Option<&Chart> {
        self.charts[quantity as usize].as_ref()
    }
}

impl Scene {
    /// A scene without faces, whose materials have one value in each of `channels`.
    ///
    /// # Errors
    /// If there is no channel, or two have one name.
    pub fn new<C: Into<String>>(channels: impl IntoIterator<Item = C>) -> Result<Self, Error> {
        let channels: Vec<String> = channels.into_iter().map(Into::into).collect();
        if channels.is_empty() {
            return Err(Error::Count { what: "channels", found: 0, expected: 1 });
        }
        if let Some(twice) = channels.iter().enumerate().find(|(i, name)| channels[..*i].contains(name)) {
            return Err(Error::expected("channels of different names", format!("`{}` twice", twice.1)));
        }
        let (materials, surfaces, faces, notes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let modelling = Modelling::default();
        Ok(Self {
            title: None,
            enclosure: None,
            channels,
            materials,
            surfaces,
            faces,
            notes,
            modelling,
            indexed: Indexed::default(),
        })
    }

    /// Adds a material and returns its index. One value a channel: `reflectance` in [0, 1], `radiance` finite and not negative.
    ///
    /// # Errors
    /// If the number of values differs from that of the channels, or a value is out of range.
    pub fn add_material(
        &mut self,
        name: impl Into<String>,
        reflectance: impl Into<Vec<f64>>,
        radiance: impl Into<Vec<f64>>,
    ) -> Result<usize, Error> {
        self.materials.push(Material::new(name.into(), reflectance.into(), radiance.into(), &self.channels)?);
        Ok(self.materials.len() - 1)
    }

    /// Gives a material a texture, by whose texels its reflectance or its radiance is multiplied on faces with texture
    /// coordinates.
    ///
    /// # Errors
    /// If there is no such material, texels have another number of values than the scene has channels, or a product is out of
    /// range.
    pub fn set_texture(&mut self, material: usize, quantity: Quantity, texture: impl Into<Arc<Texture>>) -> Result<(), Error> {
        let (channels, count) = (&self.channels, self.materials.len());
        let material = self.materials.get_mut(material).ok_or_else(|| missing("material", material, count))?;
        material.set_texture(quantity, texture.into(), channels)
    }

    /// Makes no reflectance larger than `most`, with a [`Note`] for each material that had a larger one. A material with a texture is
    /// darkened as a whole, so that the texture's largest value is `most`.
    ///
    /// ```
    /// use radgrad_scene::Scene;
    /// let mut scene = Scene::new(["grey"])?;
    /// let white = scene.add_material("white", [1.0], [0.0])?;
    /// scene.cap_reflectance(0.95);
    /// assert_eq!(scene.materials()[white].reflectance(), [0.95]);
    /// assert_eq!(scene.notes()[0].to_string(), "material `white` reflects more than 0.95: capped, as was asked");
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    pub fn cap_reflectance(&mut self, most: f64) {
        for material in &mut self.materials {
            if material.cap_reflectance(most) {
                self.notes.push(Note::Capped { material: material.name().to_owned(), most });
            }
        }
    }

    /// Adds a surface without faces and returns its index.
    pub fn add_surface(&mut self, name: impl Into<String>) -> usize {
        self.surfaces.push(Surface { name: name.into(), faces: Vec::new(), exchanges: true });
        self.surfaces.len() - 1
    }

    /// Adds a surface that only hides others, without faces, and returns its index.
    pub fn add_obstruction(&mut self, name: impl Into<String>) -> usize {
        self.surfaces.push(Surface { name: name.into(), faces: Vec::new(), exchanges: false });
        self.surfaces.len() - 1
    }

    /// Adds a face and returns its index.
    ///
    /// # Errors
    /// If there is no such surface or material.
    pub fn add_face(&mut self, surface: usize, material: usize, polygon: Polygon, place: Option<Place>) -> Result<usize, Error> {
        self.add_charted_face(surface, material, polygon, place, [None, None])
    }

    /// Adds a face with texture coordinates `(u, v)` at its vertices and returns its index.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::{Quantity, Scene, Texture};
    /// let mut scene = Scene::new(["grey"])?;
    /// let tiles = scene.add_material("tiles", [0.8], [0.0])?;
    /// let board = Texture::from_fn("board", [2, 2], 1, |column, row| vec![if column == row { 1.0 } else { 0.25 }])?;
    /// scene.set_texture(tiles, Quantity::Reflectance, board)?;
    /// let floor = scene.add_surface("floor");
    /// let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
    /// let square = Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap();
    /// let face = scene.add_textured_face(floor, tiles, square, &corners.map(|(x, y)| [0.5 * x, 0.5 * y]), None)?;
    /// assert_eq!(scene.value_at(face, Quantity::Reflectance, DVec3::new(0.5, 0.5, 0.0)), [0.8]);
    /// assert_eq!(scene.value_at(face, Quantity::Reflectance, DVec3::new(1.5, 0.5, 0.0)), [0.2]);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there is no such surface or material, or the coordinates are no affine function of the position.
    pub fn add_textured_face(
        &mut self,
        surface: usize,
        material: usize,
        polygon: Polygon,
        coordinates: &[[f64; 2]],
        place: Option<Place>,
    ) -> Result<usize, Error> {
        let chart = Chart::new(&polygon, coordinates)?;
        self.add_charted_face(surface, material, polygon, place, [Some(chart); 2])
    }

    pub(crate) fn add_charted_face(
        &mut self,
        surface: usize,
        material: usize,
        polygon: Polygon,
        place: Option<Place>,
        charts: [Option<Chart>; 2],
    ) -> Result<usize, Error> {
        let textured = self.materials.get(material).ok_or_else(|| missing("material", material, self.materials.len()))?;
        let mut used = [None; 2];
        for quantity in Quantity::ALL {
            if let (Some(texture), Some(chart)) = (textured.texture(quantity), charts[quantity as usize]) {
                chart.check(&polygon, texture)?;
                used[quantity as usize] = Some(chart);
            }
        }
        let index = self.faces.len();
        let count = self.surfaces.len();
        self.surfaces.get_mut(surface).ok_or_else(|| missing("surface", surface, count))?.faces.push(index);
        self.faces.push(Face { polygon, surface, material, place, charts: used, moved: 0.0 });
        Ok(index)
    }

    /// Whether a reflectance or a radiance varies over any face.
    #[must_use]
    pub fn is_textured(&self) -> bool {
        self.faces.iter().any(|face| face.charts.iter().any(Option::is_some))
    }

    /// Reflectance or radiance at a point of a face, in each channel; none if there is no such face.
    #[must_use]
    pub fn value_at(&self, face: usize, quantity: Quantity, point: DVec3) -> Vec<f64> {
        let Some(face) = self.faces.get(face) else { return Vec::new() };
        let material = &self.materials[face.material];
        let factors = material.factors(quantity);
        match (material.texture(quantity), face.chart(quantity)) {
            (Some(texture), Some(chart)) => {
                factors.iter().zip(texture.value_at(chart.coordinates(point))).map(|(f, t)| f * t).collect()
            }
            _ => factors.to_vec(),
        }
    }

    /// Mean of a quantity over a face in a channel, exact up to rounding; 0 if there is no such face or channel.
    #[must_use]
    pub fn mean_over(&self, face: usize, quantity: Quantity, channel: usize) -> f64 {
        let Some(face) = self.faces.get(face) else { return 0.0 };
        let material = &self.materials[face.material];
        let Some(&factor) = material.factors(quantity).get(channel) else { return 0.0 };
        let (Some(texture), Some(chart)) = (material.texture(quantity), face.chart(quantity)) else { return factor };
        let vertices = face.polygon.vertices();
        let (mut sum, mut area) = (0.0, 0.0);
        for [a, b, c] in triangles(vertices).unwrap_or_default() {
            let (origin, axes) = (vertices[a], [vertices[b] - vertices[a], vertices[c] - vertices[a]]);
            let scale = axes[0].cross(axes[1]).length();
            let coordinates = |[s, t]: [f64; 2]| chart.coordinates(origin + axes[0] * s + axes[1] * t);
            texture.cut(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], coordinates, |piece| {
                let part = scale * area_of(&piece.corners);
                sum += part * piece.values[channel];
                area += part;
            });
        }
        factor * sum / area
    }

    /// Title, where the file has one.
    #[must_use]
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// Whether the surfaces enclose a room, where the file says so.
    #[must_use]
    pub const fn enclosure(&self) -> Option<bool> {
        self.enclosure
    }

    /// Names of the channels.
    #[must_use]
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Materials.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Surfaces, in the order of the file.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Faces, in the order of the file.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The polygons of the faces, in their order.
    pub fn polygons(&self) -> impl ExactSizeIterator<Item = &Polygon> {
        self.faces.iter().map(Face::polygon)
    }

    /// Changes and omissions: those of the reader, in the order of the file, and then those of faces.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// How far it may be from the scene that its file was meant to describe.
    #[must_use]
    pub const fn modelling(&self) -> Modelling {
        self.modelling
    }

    /// Index of the surface of this name.
    ///
    /// # Errors
    /// If there is none, or more than one.
    pub fn surface_named(&self, name: &str) -> Result<usize, Error> {
        let mut indices = self.surfaces_named(name);
        match (indices.next(), indices.next()) {
            (Some(index), None) => Ok(index),
            (Some(first), Some(second)) => Err(Error::Missing {
                what: "single surface",
                which: format!("`{name}`"),
                known: format!("surfaces {first} and {second} (from 0) have that name"),
            }),
            (None, _) => {
                let known = candidates(name, self.surfaces.iter().map(|surface| surface.name.as_str()));
                Err(Error::Missing { what: "surface", which: format!("`{}`", printable(name)), known })
            }
        }
    }

    /// Indices of the surfaces of this name, ascending.
    pub fn surfaces_named(&self, name: &str) -> impl Iterator<Item = usize> {
        self.surfaces.iter().enumerate().filter(move |(_, surface)| surface.name == name).map(|(index, _)| index)
    }

    /// Area of a surface; 0 if there is none of this index.
    #[must_use]
    pub fn area_of(&self, surface: usize) -> f64 {
        let faces = self.surfaces.get(surface).map_or(&[][..], |s| &s.faces);
        faces.iter().map(|&face| self.faces[face].polygon.area()).sum()
    }

    /// Power emitted by all faces in a channel: the sum of area times pi times radiance. 0 if there is no such channel.
    #[must_use]
    pub fn emitted_power(&self, channel: usize) -> f64 {
        let power = |(index, face): (usize, &Face)| face.polygon.area() * PI * self.mean_over(index, Quantity::Radiance, channel);
        self.faces.iter().enumerate().map(power).sum()
    }

    /// Lowest and highest coordinates of all faces, if there are any.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let mut vertices = self.polygons().flat_map(Polygon::vertices).copied();
        let first = vertices.next()?;
        Some(vertices.fold((first, first), |(low, high), v| (low.min(v), high.max(v))))
    }
}

fn missing(what: &'static str, index: usize, count: usize) -> Error {
    Error::Missing { what, which: index.to_string(), known: format!("they are numbered from 0, and there are {count}") }
}

fn area_of(corners: &[[f64; 2]]) -> f64 {
    let across = |i: usize| {
        let [a, b, c] = [corners[0], corners[i], corners[i + 1]];
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    0.5 * (1..corners.len() - 1).map(across).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64) -> Polygon {
        Polygon::new([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]].map(DVec3::from).to_vec()).unwrap()
    }

    #[test]
    fn a_scene_takes_only_what_its_channels_and_indices_allow() {
        assert!(matches!(Scene::new([""; 0]), Err(Error::Count { .. })));
        assert!(matches!(Scene::new(["r", "g", "r"]), Err(Error::Expected { .. })));
        let mut scene = Scene::new(["r", "g"]).unwrap();
        assert_eq!(scene.add_material("m", [0.5], [0.0, 0.0]), Err(Error::Count { what: "reflectances", found: 1, expected: 2 }));
        for value in [1.1, -0.1, f64::NAN] {
            let error = scene.add_material("m", [0.5, value], [0.0, 0.0]).unwrap_err().to_string();
            assert!(error.starts_with("material `m`: reflectance is ") && error.contains("channel `g`"), "{error}");
        }
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(scene.add_material("m", [0.5, 0.5], [0.0, value]).is_err());
        }
        let material = scene.add_material("m", [0.5, 0.5], [0.0, 1e9]).unwrap();
        let surface = scene.add_surface("s");
        assert!(matches!(scene.add_face(surface, 7, square(0.0), None), Err(Error::Missing { what: "material", .. })));
        assert!(matches!(scene.add_face(7, material, square(0.0), None), Err(Error::Missing { what: "surface", .. })));
        assert!(scene.faces().is_empty(), "a refused face leaves nothing behind");
        assert_eq!(scene.add_face(surface, material, square(0.0), None), Ok(0));
        assert_eq!(scene.bounds(), Some((DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0))));
    }

    #[test]
    fn a_name_that_two_surfaces_have_is_not_taken_for_one() {
        let mut scene = Scene::new(["grey"]).unwrap();
        for name in ["wall", "floor", "wall"] {
            scene.add_surface(name);
        }
        assert_eq!(scene.surface_named("floor"), Ok(1));
        assert_eq!(scene.surfaces_named("wall").collect::<Vec<_>>(), [0, 2]);
        assert!(scene.surface_named("wall").unwrap_err().to_string().contains("surfaces 0 and 2"));
        assert!(scene.surface_named("roof").unwrap_err().to_string().contains("there are `wall`, `floor`, `wall`"));
    }

    #[test]
    fn emitted_power_counts_every_lamp_in_its_channel() {
        let mut scene = Scene::new(["r", "g"]).unwrap();
        let lamp = scene.add_material("lamp", [0.0, 0.0], [2.0, 3.0]).unwrap();
        let dark = scene.add_material("dark", [0.9, 0.9], [0.0, 0.0]).unwrap();
        let surface = scene.add_surface("all");
        for (material, z) in [(lamp, 0.0), (dark, 1.0), (lamp, 2.0)] {
            scene.add_face(surface, material, square(z), None).unwrap();
        }
        assert_eq!([0, 1, 2].map(|channel| scene.emitted_power(channel)), [4.0 * PI, 6.0 * PI, 0.0]);
        assert_eq!(scene.area_of(surface), 3.0);
        assert_eq!(scene.area_of(9), 0.0);
    }
}
