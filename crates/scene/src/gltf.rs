//! glTF 2.0, `.gltf` and `.glb`: triangles of meshes under their nodes' transformations, base colour and emission.
//!
//! Positions are single precision in the file; they are widened and transformed in double precision, so that neighbouring
//! triangles of one node keep exactly common vertices. A triangle is lit on its front, counter-clockwise, also under a mirroring
//! transformation; a material that is double-sided gives every triangle a twin that faces the other way. Triangles are not
//! merged into larger polygons.
//!
//! The reflectance is `baseColorFactor`, whatever the metalness; the radiance is `emissiveFactor` times the strength of
//! `KHR_materials_emissive_strength`. Their textures are read from PNG, without a filter; a sampler's rule of repeating holds, and
//! so does `KHR_texture_transform`. A surface is a node with a mesh: its name is the node's, else the mesh's, else `node 7`.
//!
//! Noted, and not used: textures of other formats, transparency, skins, morph targets, points and lines, optional extensions.
//! Refused: versions before 2.0, extensions that the file says are required, sparse accessors, and files that break the format;
//! errors name the member, as in `accessors[3].bufferView`. A position that is not finite, and a material of wrong values, are
//! refused where a triangle uses them.

mod accessor;
mod buffer;
mod document;
mod maps;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, DVec4};

use self::accessor::Accessors;
use self::document::{Document, Fault, Material, Node, Primitive};
use self::maps::Maps;
use crate::error::Error;
use crate::extremes::largest;
use crate::messages::quoted;
use crate::place::Position;
use crate::precision::{Written, WrittenPrecision, seems_single};
use crate::reading::{Budget, Folder, ReadFile, Reading};
use crate::scene::Scene;
use crate::scene::intake::Intake;
use crate::scene::outline::Outline;

/// Reads a file, and the buffers beside it that it names.
///
/// # Errors
/// If a file cannot be read, or breaks the format: with file, member and the expected value.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    let content = crate::reading::open(file, &budget)?;
    let folder = Folder::beside(file, &reading, &budget);
    parse_within(&content, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut |name| folder.read(name))?
        .finish()
}

/// Reads the content of a file, JSON or binary. `file` is its name in messages; `buffer` gives the content of a file that a
/// buffer's URI names.
///
/// # Errors
/// As [`read`].
pub fn parse(
    content: &[u8],
    file: &Path,
    reading: impl Into<Reading>,
    mut buffer: impl FnMut(&Path) -> io::Result<Vec<u8>>,
) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    parse_within(content, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut buffer)?.finish()
}

fn parse_within(content: &[u8], mut intake: Intake, buffer: &mut ReadFile<'_>) -> Result<Intake, Error> {
    let whole = intake.place(Position::File);
    let (json, binary) = buffer::chunks(content).map_err(|error| error.at_place(whole.clone()))?;
    let file = intake.file();
    let json = intake.decode(json, &file)?;
    let memory = document::memory_of(json.as_bytes());
    intake.budget().take("the document", memory).map_err(|error| error.at_place(whole.clone()))?;
    let document: Document = serde_json::from_str(&json).map_err(|error| {
        if let Some(version) = document::version_other_than_2(&json) {
            return document::other_version(&version).at_place(intake.place(Position::Member("asset.version".to_owned())));
        }
        let place = if binary.is_some() { whole.clone() } else { intake.place(Position::Line(error.line())) };
        Error::from(error).at_place(place)
    })?;
    let fault = |intake: &Intake, (member, error): Fault| error.at_place(intake.place(Position::Member(member)));
    document.check().map_err(|error| fault(&intake, error))?;
    note_unused(&document, &mut intake);
    let buffers = buffer::contents(&document, binary, intake.budget(), buffer).map_err(|error| fault(&intake, error))?;
    let (materials, faults) = materials(&document, &mut intake)?;
    let maps = maps::of_materials(&document, &buffers, &materials, &mut intake, buffer)?;
    let mut reader = Reader { document: &document, buffers: &buffers, materials, faults, maps, intake };
    for (node, transformation) in document.placed_nodes().map_err(|error| fault(&reader.intake, error))? {
        reader.node(node, transformation)?;
    }
    let Reader { mut intake, faults, .. } = reader;
    for error in faults.into_values().map(|error| fault(&intake, error)).collect::<Vec<_>>() {
        intake.ignore_fault(error, "no triangle has the material");
    }
    Ok(intake)
}

fn note_unused(document: &Document, intake: &mut Intake) {
    let mut note = |member: &str, what: String| {
        let place = intake.place(Position::Member(member.to_owned()));
        intake.ignore(place, what);
    };
    for extension in document.extensions_used.iter().filter(|name| !document::USED.contains(&name.as_str())) {
        note("extensionsUsed", format!("extension {} is not used", quoted(Some(extension))));
    }
    if document.nodes.iter().any(|node| node.skin.is_some()) {
        note("skins", "skins are not used: meshes keep the shape in which they are stored".to_owned());
    }
    if document.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| !primitive.targets.is_empty()) {
        note("meshes", "morph targets are not used: meshes keep the shape in which they are stored".to_owned());
    }
}

/// The index in the scene of each material of the file, and last of the one that holds where a primitive names none; and the
/// faults of those that are black for want of their values.
fn materials(document: &Document, intake: &mut Intake) -> Result<(Vec<usize>, BTreeMap<usize, Fault>), Error> {
    let fallback = Material::default();
    let (mut all, mut faults) = (Vec::new(), BTreeMap::new());
    for (index, material) in document.materials.iter().chain([&fallback]).enumerate() {
        let member = format!("materials[{index}]");
        let place = intake.place(Position::Member(member.clone()));
        let surface = material.pbr_metallic_roughness.as_ref();
        let [red, green, blue, alpha] = surface.map_or([1.0; 4], |surface| surface.base_color_factor);
        if alpha != 1.0 && material.alpha_mode.is_some() {
            intake.ignore(place.clone(), "transparency is not used: every face is opaque".to_owned());
        }
        let strength = material.extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
        let radiance = material.emissive_factor.map(|factor| factor * strength);
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        let added = match intake.add_material(&name, &[red, green, blue], &radiance) {
            Err(error @ Error::Material { .. }) => {
                if intake.needs_materials() {
                    faults.insert(index, (member, error));
                } else {
                    intake.ignore_fault(error.at_place(place.clone()), "taken as black");
                }
                intake.add_material(&name, &[0.0; 3], &[0.0; 3])
            }
            added => added,
        };
        all.push(added.map_err(|error| error.at_place(place))?);
    }
    Ok((all, faults))
}

struct Reader<'a> {
    document: &'a Document,
    buffers: &'a [Cow<'a, [u8]>],
    materials: Vec<usize>,
    /// Faults of materials of the file: the first triangle of one is refused.
    faults: BTreeMap<usize, Fault>,
    /// Of each material of the file: where its textures lie.
    maps: Vec<Maps>,
    intake: Intake,
}

/// The triangles of a primitive.
struct PrimitiveTriangles {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
    material: usize,
    double_sided: bool,
    /// Of the textures of the reflectance and of the radiance.
    coordinates: [Option<Vec<[f64; 2]>>; 2],
}

impl Reader<'_> {
    fn accessors(&self) -> Accessors<'_> {
        Accessors { document: self.document, buffers: self.buffers, budget: self.intake.budget() }
    }

    fn fault(&self, (member, error): Fault) -> Error {
        error.at_place(self.intake.place(Position::Member(member)))
    }

    fn node(&mut self, index: usize, transformation: Transformation) -> Result<(), Error> {
        let node = &self.document.nodes[index];
        let Some(mesh_index) = node.mesh else { return Ok(()) };
        let Some(mesh) = self.document.meshes.get(mesh_index) else {
            let error = document::no_such("mesh", mesh_index, self.document.meshes.len());
            return Err(self.fault((format!("nodes[{index}].mesh"), error)));
        };
        let name = node.name.as_ref().or(mesh.name.as_ref());
        let surface = self.intake.add_surface(&name.cloned().unwrap_or_else(|| format!("node {index}")), true);
        let surface = surface.map_err(|error| self.fault((format!("nodes[{index}]"), error)))?;
        for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
            let member = format!("meshes[{mesh_index}].primitives[{primitive_index}]");
            match self.part(&member, primitive).map_err(|fault| self.fault(fault))? {
                Ok(part) => self.add([mesh_index, primitive_index], &part, surface, transformation)?,
                Err(why) => {
                    let place = self.intake.place(Position::Member(member));
                    self.intake.ignore(place, format!("{why}: left out"));
                }
            }
        }
        Ok(())
    }

    /// The triangles of a primitive, or why it has none.
    fn part(&mut self, member: &str, primitive: &Primitive) -> Result<Result<PrimitiveTriangles, &'static str>, Fault> {
        let fault = |error| (member.to_owned(), error);
        let Some(position) = primitive.attributes.position else { return Ok(Err("a primitive without positions")) };
        let positions = self.accessors().positions(position)?;
        let indices = match primitive.indices {
            Some(indices) => self.accessors().indices(indices, positions.len())?,
            None => (0..positions.len()).collect(),
        };
        let Some(triangles) = triangles(primitive.mode, &indices).map_err(fault)? else {
            return Ok(Err("points and lines are no surfaces"));
        };
        let last = self.materials.len() - 1;
        let (material, double_sided) = match primitive.material {
            None => (self.materials[last], false),
            Some(index) if index < last => (self.materials[index], self.document.materials[index].double_sided),
            Some(index) => return Err(fault(document::no_such("material", index, last))),
        };
        if let Some(fault) = primitive.material.and_then(|index| self.faults.get(&index)) {
            return Err(fault.clone());
        }
        let mut coordinates = [None, None];
        let maps = primitive.material.and_then(|material| self.maps.get(material));
        for (map, coordinates) in maps.into_iter().flatten().zip(&mut coordinates) {
            let Some(map) = map else { continue };
            match primitive.attributes.others.get(&format!("TEXCOORD_{}", map.set)) {
                Some(&accessor) => match self.coordinates(accessor, positions.len()) {
                    Ok(uv) => *coordinates = Some(uv.into_iter().map(|uv| map.apply(uv)).collect()),
                    Err((of, error)) => {
                        let error = (of.unwrap_or_else(|| member.to_owned()), error);
                        if self.intake.needs_materials() {
                            return Err(error);
                        }
                        let error = self.fault(error);
                        self.intake.ignore_fault(error, "the primitive has no texture");
                    }
                },
                None => {
                    let place = self.intake.place(Position::Member(member.to_owned()));
                    let what = "primitives without texture coordinates have no texture: factors hold all over them";
                    self.intake.ignore(place, what.to_owned());
                }
            }
        }
        Ok(Ok(PrimitiveTriangles { positions, triangles, material, double_sided, coordinates }))
    }

    /// Texture coordinates of as many vertices; an error comes with the accessor in which it is.
    fn coordinates(&self, accessor: usize, count: usize) -> Result<Vec<[f64; 2]>, (Option<String>, Error)> {
        let uv = self.accessors().coordinates(accessor).map_err(|(member, error)| (Some(member), error))?;
        if uv.len() == count {
            return Ok(uv);
        }
        Err((None, Error::expected("texture coordinates of all positions", format!("{} of {count} positions", uv.len()))))
    }

    fn add(
        &mut self,
        [mesh, primitive]: [usize; 2],
        part: &PrimitiveTriangles,
        surface: usize,
        transformation: Transformation,
    ) -> Result<(), Error> {
        let points: Vec<DVec3> = part.positions.iter().map(|&p| transformation.matrix.transform_point3(p)).collect();
        let mirrored = transformation.matrix.determinant() < 0.0;
        self.intake.written().at_least(transformation.rounding(part));
        for (triangle, corners) in part.triangles.iter().enumerate() {
            let place = self.intake.place(Position::Triangle { mesh, primitive, triangle });
            let &[a, b, c] = corners;
            if let Some(wrong) = corners.iter().find(|&&corner| !points[corner].is_finite()) {
                let given = format!("{} at index {wrong}, {} in the world", part.positions[*wrong], points[*wrong]);
                return Err(Error::expected("finite positions", given).at_place(place));
            }
            let (front, back) = if mirrored { ([c, b, a], [a, b, c]) } else { ([a, b, c], [c, b, a]) };
            let outline = |corners: [usize; 3]| Outline {
                vertices: corners.map(|corner| points[corner]).to_vec(),
                coordinates: part.coordinates.each_ref().map(|of| of.as_ref().map(|of| corners.map(|c| of[c]).to_vec())),
            };
            self.intake.add_textured_face(surface, part.material, outline(front), place.clone())?;
            if part.double_sided {
                self.intake.add_textured_face(surface, part.material, outline(back), place)?;
            }
        }
        Ok(())
    }
}

/// Corners of each triangle by the primitive's mode; `None` for points and lines. The triangles of a strip turn in turns, and
/// those with a repeated corner only join its parts.
fn triangles(mode: u64, indices: &[usize]) -> Result<Option<Vec<[usize; 3]>>, Error> {
    match mode {
        0..=3 => Ok(None),
        4 => {
            let (triangles, rest) = indices.as_chunks::<3>();
            if rest.is_empty() {
                Ok(Some(triangles.to_vec()))
            } else {
                Err(Error::expected("three indices a triangle", format!("{} indices", indices.len())))
            }
        }
        5 => {
            let strip = indices.windows(3).enumerate();
            let turned = strip.map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
            Ok(Some(turned.filter(|[a, b, c]| a != b && b != c && c != a).collect()))
        }
        6 => Ok(Some(indices.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], indices[0]]).collect())),
        _ => Err(Error::expected("a mode from 0 to 6", mode.to_string())),
    }
}

/// The transformation from a node to the world.
#[derive(Debug, Clone, Copy)]
struct Transformation {
    matrix: DMat4,
    /// Whether numbers in it seem to be rounded to single precision.
    is_single: bool,
}

impl Transformation {
    /// The rounding of the coordinates in the world: that of the positions, made longer, and that of the transformation itself.
    fn rounding(self, part: &PrimitiveTriangles) -> f64 {
        const SINGLE: f64 = 1.0 / 16_777_216.0;
        let (mut written, mut most) = (WrittenPrecision::new(), 0.0);
        for &corner in part.triangles.iter().flatten() {
            for coordinate in part.positions[corner].to_array() {
                written.add(Written::Single, coordinate);
                most = largest(most, coordinate.abs());
            }
        }
        let [x, y, z] = [self.matrix.x_axis, self.matrix.y_axis, self.matrix.z_axis].map(|axis| axis.truncate().abs());
        let longest = (x + y + z).max_element();
        let moved = self.matrix.w_axis.truncate().abs().max_element();
        let of_itself = if self.is_single { SINGLE * (longest * most + moved) } else { 0.0 };
        longest * written.rounding() + of_itself
    }
}

impl Document {
    /// The nodes of the scene shown first, with the transformation from each to the world.
    fn placed_nodes(&self) -> Result<Vec<(usize, Transformation)>, Fault> {
        let roots = self.roots()?;
        let world = Transformation { matrix: DMat4::IDENTITY, is_single: false };
        let mut open: Vec<(usize, Transformation)> = roots.into_iter().rev().map(|node| (node, world)).collect();
        let (mut placed, mut seen) = (Vec::new(), vec![false; self.nodes.len()]);
        while let Some((index, parent)) = open.pop() {
            let Some(node) = self.nodes.get(index) else {
                return Err(("nodes".to_owned(), document::no_such("node", index, self.nodes.len())));
            };
            let member = format!("nodes[{index}]");
            if std::mem::replace(&mut seen[index], true) {
                return Err((member, Error::expected("a node with one parent", "one that is reached twice")));
            }
            let local = node.transformation().ok_or_else(|| {
                (
                    member,
                    Error::expected("an affine transformation of finite numbers, with a rotation that is not zero", "another"),
                )
            })?;
            let is_single = parent.is_single || node.numbers().any(|&number| seems_single(number));
            let world = Transformation { matrix: parent.matrix * local, is_single };
            placed.push((index, world));
            open.extend(node.children.iter().rev().map(|&child| (child, world)));
        }
        Ok(placed)
    }

    /// Roots of the scene shown first; of all trees where the file has no scenes.
    fn roots(&self) -> Result<Vec<usize>, Fault> {
        match (self.scene, self.scenes.first()) {
            (None, Some(first)) => Ok(first.nodes.clone()),
            (Some(index), _) => {
                let scene = self.scenes.get(index);
                scene
                    .map(|s| s.nodes.clone())
                    .ok_or_else(|| ("scene".to_owned(), document::no_such("scene", index, self.scenes.len())))
            }
            (None, None) => {
                let mut is_root = vec![true; self.nodes.len()];
                for &child in self.nodes.iter().flat_map(|node| &node.children) {
                    if let Some(is_root) = is_root.get_mut(child) {
                        *is_root = false;
                    }
                }
                Ok((0..self.nodes.len()).filter(|&index| is_root[index]).collect())
            }
        }
    }
}

impl Node {
    /// The numbers of its transformation.
    fn numbers(&self) -> impl Iterator<Item = &f64> {
        self.matrix.iter().flatten().chain(&self.translation).chain(&self.rotation).chain(&self.scale)
    }

    /// From the node to its parent: its matrix, or scale, then rotation, then translation.
    fn transformation(&self) -> Option<DMat4> {
        let matrix = match self.matrix {
            Some(columns) => DMat4::from_cols_array(&columns),
            None => {
                let rotation = DQuat::from_array(self.rotation);
                let rotation = rotation / rotation.length();
                DMat4::from_scale_rotation_translation(self.scale.into(), rotation, self.translation.into())
            }
        };
        (matrix.is_finite() && matrix.row(3) == DVec4::W).then_some(matrix)
    }
}
