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
//! Refused: extensions that the file says are required, sparse accessors, and files that break the format; errors name the member,
//! as in `accessors[3].bufferView`.

mod accessor;
mod buffer;
mod document;
mod maps;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::io;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, DVec4};

use self::accessor::Accessors;
use self::document::{Document, Material, Node, Primitive};
use self::maps::Maps;
use crate::reading::{Budget, Folder, ReadFile};
use crate::scene::{Intake, Outline};
use crate::words::quoted;
use crate::{Error, Position, Reading, Scene};

/// Reads a file, and the buffers beside it that it names.
///
/// # Errors
/// If a file cannot be read, or breaks the format: with file, member and the expected value.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    let content = crate::open(file, &budget)?;
    let folder = Folder::of(file, &reading, &budget);
    parse_within(&content, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut |name| folder.read(name))
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
    parse_within(content, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut buffer)
}

fn parse_within(content: &[u8], mut intake: Intake, buffer: &mut ReadFile<'_>) -> Result<Scene, Error> {
    let whole = intake.place(Position::File);
    let (json, binary) = buffer::chunks(content).map_err(|error| error.at(whole.clone()))?;
    let memory = document::memory_of(json);
    intake.budget().take("the document", memory).map_err(|error| error.at(whole.clone()))?;
    let document: Document = serde_json::from_slice(json).map_err(|error| {
        let place = if binary.is_some() { whole.clone() } else { intake.place(Position::Line(error.line())) };
        Error::from(error).at(place)
    })?;
    let fault = |intake: &Intake, (member, error): Fault| error.at(intake.place(Position::Member(member)));
    document.check().map_err(|error| fault(&intake, error))?;
    note_unused(&document, &mut intake);
    let buffers = buffer::contents(&document, binary, intake.budget(), buffer).map_err(|error| fault(&intake, error))?;
    let materials = materials(&document, &mut intake)?;
    let maps = maps::of_materials(&document, &buffers, &materials, &mut intake, buffer)?;
    let mut reader = Reader { document: &document, buffers: &buffers, materials, maps, intake };
    for (node, transformation) in document.placed_nodes().map_err(|error| fault(&reader.intake, error))? {
        reader.node(node, transformation)?;
    }
    reader.intake.finish()
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

/// The index in the scene of each material of the file, and last of the one that holds where a primitive names none.
fn materials(document: &Document, intake: &mut Intake) -> Result<Vec<usize>, Error> {
    let fallback = Material::default();
    let all = document.materials.iter().chain([&fallback]).enumerate();
    let add = |(index, material): (usize, &Material)| {
        let member = format!("materials[{index}]");
        let place = intake.place(Position::Member(member));
        let surface = material.pbr_metallic_roughness.as_ref();
        let [red, green, blue, alpha] = surface.map_or([1.0; 4], |surface| surface.base_color_factor);
        if alpha != 1.0 && material.alpha_mode.is_some() {
            intake.ignore(place.clone(), "transparency is not used: every face is opaque".to_owned());
        }
        let strength = material.extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
        let radiance = material.emissive_factor.map(|factor| factor * strength);
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        intake.add_material(&name, &[red, green, blue], &radiance).map_err(|error| error.at(place))
    };
    all.map(add).collect()
}

/// An error, with the member in which it is.
type Fault = (String, Error);

struct Reader<'a> {
    document: &'a Document,
    buffers: &'a [Cow<'a, [u8]>],
    materials: Vec<usize>,
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
        error.at(self.intake.place(Position::Member(member)))
    }

    fn node(&mut self, index: usize, transformation: DMat4) -> Result<(), Error> {
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
        let mut coordinates = [None, None];
        let maps = primitive.material.and_then(|material| self.maps.get(material));
        for (map, coordinates) in maps.into_iter().flatten().zip(&mut coordinates) {
            let Some(map) = map else { continue };
            match primitive.attributes.others.get(&format!("TEXCOORD_{}", map.set)) {
                Some(&accessor) => {
                    let uv = self.accessors().coordinates(accessor)?;
                    if uv.len() != positions.len() {
                        let found = format!("{} of {} positions", uv.len(), positions.len());
                        return Err(fault(Error::expected("texture coordinates of all positions", found)));
                    }
                    *coordinates = Some(uv.into_iter().map(|uv| map.apply(uv)).collect());
                }
                None => {
                    let place = self.intake.place(Position::Member(member.to_owned()));
                    let what = "primitives without texture coordinates have no texture: factors hold all over them";
                    self.intake.ignore(place, what.to_owned());
                }
            }
        }
        Ok(Ok(PrimitiveTriangles { positions, triangles, material, double_sided, coordinates }))
    }

    fn add(
        &mut self,
        [mesh, primitive]: [usize; 2],
        part: &PrimitiveTriangles,
        surface: usize,
        transformation: DMat4,
    ) -> Result<(), Error> {
        let points: Vec<DVec3> = part.positions.iter().map(|&p| transformation.transform_point3(p)).collect();
        let mirrored = transformation.determinant() < 0.0;
        for (triangle, corners) in part.triangles.iter().enumerate() {
            let place = self.intake.place(Position::Triangle { mesh, primitive, triangle });
            let &[a, b, c] = corners;
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

impl Document {
    /// The nodes of the scene shown first, with the transformation from each to the world.
    fn placed_nodes(&self) -> Result<Vec<(usize, DMat4)>, Fault> {
        let roots = self.roots()?;
        let mut open: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
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
            let world = parent * local;
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
