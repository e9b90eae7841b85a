//! Wavefront OBJ with its MTL libraries, in double precision.
//!
//! Read: `v`, `f` with any number of vertices in the forms `v`, `v/vt`, `v//vn` and `v/vt/vn`, counted from 1 or backwards from -1;
//! `o`, `g`, `usemtl`, `mtllib`; `Kd` and `Ke` of materials; comments, lines continued by `\`, any end of line, UTF-8, UTF-16 with
//! its mark and Latin-1. `map_Kd` and `map_Ke` are textures, where faces have the coordinates `vt`. The order of a face's vertices
//! decides to which side it is lit, not its normals. A surface is a group: its name is that of `g`, or `o`, or `o/g` where both are
//! given; a name that comes again is the same surface.
//!
//! A file is refused where a face is not known: a vertex that is no three finite numbers, where a face uses it, an index of none, a
//! statement of numbers that is unknown, which may be a face. A material that is not known, or wrong, is refused by the first face
//! that has it, or taken as black where materials are optional ([`crate::Materials`]). All else is left out with a [`crate::Note`]:
//! libraries and textures that cannot be read, weights and colours of vertices, points, lines, free-form surfaces, words that are
//! no statement. Statements that say nothing of flat, diffuse faces are skipped: `vn`, `vp`, `s`, `mg`, and those about display.

mod map;
mod mtl;
mod statements;
#[cfg(test)]
mod tests;

use std::io;
use std::path::{Path, PathBuf};

use radgrad_core::DVec3;

use self::map::Textures;
use self::mtl::Library;
use self::statements::for_each_statement;
use crate::error::Error;
use crate::messages::{printable, quoted};
use crate::place::Position;
use crate::reading::{Budget, Folder, ReadFile, Reading};
use crate::scene::Scene;
use crate::scene::intake::Intake;
use crate::scene::outline::Outline;
use crate::scene::vertices::Vertices;
use crate::words::Words;

/// Reads a file and the material libraries that it names, which stand beside it.
///
/// # Errors
/// If a file cannot be read, or breaks the format: with file, line and the expected value.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    let text = crate::reading::open(file, &budget)?;
    let folder = Folder::beside(file, &reading, &budget);
    parse_within(&text, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut |name| folder.read(name))?
        .finish()
}

/// Reads the text of a file. `file` is its name in messages; `library` gives the content of a material library or a texture.
///
/// ```
/// use std::path::Path;
/// use radgrad_scene::{Degenerate, obj};
/// let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng floor\nusemtl grey\nf -4 -3 -2 -1\n";
/// let library = "newmtl grey\nKd 0.5 0.5 0.5\n";
/// let scene = obj::parse(text.as_bytes(), Path::new("floor.obj"), Degenerate::Refuse, |_| Ok(library.into()))?;
/// assert_eq!(scene.area_of(scene.surface_named("floor")?), 1.0);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn parse(
    text: &[u8],
    file: &Path,
    reading: impl Into<Reading>,
    mut library: impl FnMut(&Path) -> io::Result<Vec<u8>>,
) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    parse_within(text, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut library)?.finish()
}

fn parse_within(text: &[u8], mut intake: Intake, library: &mut ReadFile<'_>) -> Result<Intake, Error> {
    let file = intake.file();
    let text = intake.decode(text, &file)?;
    let mut reader = Reader {
        intake,
        vertices: Vertices::default(),
        coordinates: Vec::new(),
        materials: Library::default(),
        textures: Textures::default(),
        libraries: Vec::new(),
        missing: None,
        object: String::new(),
        group: String::new(),
        material: None,
        library,
    };
    for_each_statement(&text, |line, statement| {
        let result = reader.statement(line, statement);
        // An error in a library has its place already.
        result.map_err(
            |error| if error.place().is_some() { error } else { error.at_place(reader.intake.place(Position::Line(line))) },
        )
    })?;
    let Reader { mut intake, vertices, materials, .. } = reader;
    vertices.note_faults(&mut intake);
    for error in materials.faults.into_values() {
        intake.ignore_fault(error, "no face has the material");
    }
    Ok(intake)
}

struct Reader<'a> {
    intake: Intake,
    vertices: Vertices,
    /// `vt`, NaN where they are wrong.
    coordinates: Vec<[f64; 2]>,
    materials: Library,
    textures: Textures,
    libraries: Vec<PathBuf>,
    /// The first library that could not be read, and why.
    missing: Option<String>,
    object: String,
    group: String,
    material: Option<usize>,
    library: &'a mut ReadFile<'a>,
}

impl Reader<'_> {
    fn statement(&mut self, line: usize, text: &str) -> Result<(), Error> {
        let mut words = Words::new(text);
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            "v" => self.vertex(line, words)?,
            "vt" => self.coordinate(line, words)?,
            "f" | "fo" => self.face(line, words)?,
            "o" | "g" => {
                let name = Intake::checked_name(words.remainder())?.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
                if keyword == "o" {
                    self.object = name;
                    self.group.clear();
                } else {
                    self.group = name;
                }
            }
            "usemtl" => self.material = self.material_named(line, words.remainder())?,
            "mtllib" => self.read_libraries(line, words)?,
            "p" | "l" => self.ignore(line, format!("`{keyword}` is no surface: points and lines are left out")),
            "vn" | "vp" | "s" | "mg" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" | "maplib"
            | "usemap" => {}
            "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end"
            | "con" | "bzp" | "bsp" | "cdc" | "cdp" | "res" | "ctech" | "stech" => {
                self.ignore(line, "free-form curves and surfaces are left out: export them as polygons".to_owned());
            }
            _ if is_data(words) => {
                return Err(Error::expected("a statement of OBJ (v, f, o, g, usemtl, mtllib, ...)", quoted(Some(keyword))));
            }
            _ => self.ignore(line, "a line that is no statement of OBJ is not used".to_owned()),
        }
        Ok(())
    }

    fn ignore(&mut self, line: usize, what: String) {
        let place = self.intake.place(Position::Line(line));
        self.intake.ignore(place, what);
    }

    fn vertex(&mut self, line: usize, mut words: Words<'_>) -> Result<(), Error> {
        let read = words.coordinates(["x", "y", "z"]).map_err(|error| error.at_place(self.intake.place(Position::Line(line))));
        let mut further = words.clone();
        match (further.next().map(str::parse::<f64>), further.is_empty()) {
            (None | Some(Ok(1.0)), true) => {}
            _ if read.is_err() => {}
            (_, true) => self.ignore(line, "the weight of a vertex, its fourth number, is not used".to_owned()),
            _ => self.ignore(line, "the numbers after the coordinates of a vertex, such as its colour, are not used".to_owned()),
        }
        self.vertices.push(read, &self.intake)
    }

    /// `u`, and `v` where there is one; a third number is of no use on a surface.
    fn coordinate(&mut self, line: usize, mut words: Words<'_>) -> Result<(), Error> {
        self.intake.budget().take_many("texture coordinates", 1, 2 * size_of::<[f64; 2]>())?;
        let u = words.number("u");
        let v = if words.is_empty() { Ok(0.0) } else { words.number("v") };
        let coordinates = match (u, v) {
            (Ok(u), Ok(v)) => [u, v],
            (Err(error), _) | (_, Err(error)) => {
                self.ignore(line, format!("{error}: the texture coordinate is not used"));
                [f64::NAN; 2]
            }
        };
        self.coordinates.push(coordinates);
        Ok(())
    }

    fn face(&mut self, line: usize, mut words: Words<'_>) -> Result<(), Error> {
        let (mut vertices, mut corners) = (Vec::with_capacity(4), Vec::with_capacity(4));
        while let Some(word) = words.next() {
            self.intake.budget().take_many("corners of faces", 1, size_of::<DVec3>() + size_of::<&str>())?;
            vertices.push(self.corner(line, word)?);
            corners.push(word);
        }
        let material = self.material_index(line)?;
        if let Some(error) = self.materials.faults.get(&material) {
            return Err(error.clone());
        }
        let Self { textures, intake, library, .. } = self;
        textures.load(material, intake, library)?;
        let surface = match (self.object.as_str(), self.group.as_str()) {
            ("", "") => self.intake.surface("default")?,
            ("", name) | (name, "") => self.intake.surface(name)?,
            (object, group) => self.intake.surface(&format!("{object}/{group}"))?,
        };
        let coordinates = self.coordinates_of(line, material, &corners)?;
        let place = self.intake.place(Position::Line(line));
        self.intake.add_textured_face(surface, material, Outline { vertices, coordinates }, place)
    }

    /// Texture coordinates at the corners of a face of a material with textures.
    fn coordinates_of(&mut self, line: usize, material: usize, corners: &[&str]) -> Result<[Option<Vec<[f64; 2]>>; 2], Error> {
        let mappings = self.textures.mappings(material);
        if mappings.iter().all(Option::is_none) {
            return Ok([None, None]);
        }
        let coordinates = self.known_coordinates(line, corners);
        let uv = match coordinates {
            Ok(Some(uv)) => uv,
            Ok(None) => return Ok([None, None]),
            Err(error) if self.intake.needs_materials() => return Err(error),
            Err(error) => {
                self.ignore(line, format!("{error}: the face has no texture"));
                return Ok([None, None]);
            }
        };
        Ok(mappings.map(|mapping| mapping.map(|mapping| uv.iter().map(|&uv| mapping.apply(uv)).collect())))
    }

    /// The `vt` of a face's corners; none where a corner has none.
    fn known_coordinates(&mut self, line: usize, corners: &[&str]) -> Result<Option<Vec<[f64; 2]>>, Error> {
        let mut uv = Vec::with_capacity(corners.len());
        for word in corners {
            let texture = word.split('/').nth(1).filter(|texture| !texture.is_empty());
            let Some(index) = texture.and_then(|texture| texture.parse::<i64>().ok()) else {
                self.ignore(line, "faces without `vt` have no texture: `Kd` and `Ke` hold all over them".to_owned());
                return Ok(None);
            };
            let count = self.coordinates.len();
            let coordinates = place_of(index, count).map(|place| self.coordinates[place]).ok_or_else(|| {
                Error::expected(format!("the index of one of the {count} `vt` before this line"), quoted(Some(word)))
            })?;
            if coordinates[0].is_nan() {
                return Err(Error::expected("the index of a `vt` of finite numbers", quoted(Some(word))));
            }
            uv.push(coordinates);
        }
        Ok(Some(uv))
    }

    /// The vertex of one word of a face: `7`, `7/1`, `7//3` or `7/1/3`, or the same with negative numbers, or with nothing after
    /// a slash. The part after the first is not needed, and noted where it is no index.
    fn corner(&mut self, line: usize, word: &str) -> Result<DVec3, Error> {
        let mut parts = word.split('/');
        let index = parts.next().and_then(|index| index.parse::<i64>().ok());
        let wrong = || Error::expected("a vertex of a face (`v`, `v/vt`, `v//vn` or `v/vt/vn`)", quoted(Some(word)));
        let index = index.ok_or_else(wrong)?;
        if parts.clone().count() > 2 || parts.any(|part| !part.is_empty() && part.parse::<i64>().is_err()) {
            self.ignore(line, format!("{}: what follows the vertex is not used", wrong()));
        }
        let count = self.vertices.len();
        let corner = place_of(index, count).map(|place| self.vertices.corner(place, &mut self.intake)).transpose()?;
        corner.flatten().ok_or_else(|| {
            let range = if count == 0 { "no vertices stand".to_owned() } else { format!("1 to {count} or -1 to -{count} stand") };
            Error::expected(format!("the index of a vertex: {range} before this line"), quoted(Some(word)))
        })
    }

    /// The material in use; black where none is.
    fn material_index(&mut self, line: usize) -> Result<usize, Error> {
        if let Some(material) = self.material {
            return Ok(material);
        }
        let black = self.intake.add_material("", &[0.0; 3], &[0.0; 3])?;
        self.ignore(line, "faces before the first `usemtl` have no material: taken as black".to_owned());
        self.material = Some(black);
        Ok(black)
    }

    /// The material of a name, none of no name.
    fn material_named(&mut self, line: usize, name: &str) -> Result<Option<usize>, Error> {
        if let Some(&material) = self.materials.names.get(name) {
            return Ok(Some(material));
        }
        if name.is_empty() {
            self.ignore(line, "`usemtl` without a name: the faces after it have no material".to_owned());
            return Ok(None);
        }
        let candidates = match &self.missing {
            Some(missing) => missing.clone(),
            None => self.materials.candidates(name),
        };
        let missing = Error::Missing { what: "material", which: quoted(Some(name)), known: candidates };
        let place = self.intake.place(Position::Line(line));
        self.materials.add_unknown(name, missing.at_place(place), &mut self.intake).map(Some)
    }

    /// One library whose name may have spaces, or else several.
    fn read_libraries(&mut self, line: usize, words: Words<'_>) -> Result<(), Error> {
        let whole = words.remainder().trim_matches('"');
        if whole.is_empty() {
            self.ignore(line, "`mtllib` without a name is not used".to_owned());
            return Ok(());
        }
        match (self.library)(Path::new(whole)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound && whole.contains(['\\', ' ', '\t']) => {
                // Windows parts folders by backslashes.
                let slashed = whole.replace('\\', "/");
                match (self.library)(Path::new(&slashed)) {
                    Err(error) if error.kind() == io::ErrorKind::NotFound && slashed.contains([' ', '\t']) => {
                        slashed.split_ascii_whitespace().try_for_each(|name| {
                            let content = (self.library)(Path::new(name));
                            self.take_library(line, name, content)
                        })
                    }
                    content => self.take_library(line, &slashed, content),
                }
            }
            content => self.take_library(line, whole, content),
        }
    }

    fn take_library(&mut self, line: usize, name: &str, content: io::Result<Vec<u8>>) -> Result<(), Error> {
        if self.libraries.iter().any(|known| known == Path::new(name)) {
            return Ok(());
        }
        let content = match content {
            Ok(content) => content,
            Err(error) => {
                let unreadable = Error::Unreadable { file: name.into(), reason: error.to_string() };
                if error.kind() == io::ErrorKind::FileTooLarge && self.intake.needs_materials() {
                    return Err(self.intake.budget().exceeded(&format!("`{}`", printable(name))));
                }
                self.ignore(line, unreadable.to_string());
                self.missing.get_or_insert(unreadable.to_string());
                return Ok(());
            }
        };
        if let Err(error) = mtl::parse(&content, Path::new(name), &mut self.intake, &mut self.materials, &mut self.textures) {
            if matches!(error.fault(), Error::Budget { .. }) {
                return Err(error);
            }
            self.missing.get_or_insert(error.to_string());
            self.intake.ignore_fault(error, "the library is not used");
        }
        self.libraries.push(name.into());
        Ok(())
    }
}

/// Whether the words after an unknown keyword are numbers or indices all, so that it may be a face or a vertex.
fn is_data(mut words: Words<'_>) -> bool {
    std::iter::from_fn(|| words.next()).all(|word| word.split('/').all(|part| part.is_empty() || part.parse::<f64>().is_ok()))
}

/// The place in a list of an index from 1, or from -1 backwards.
fn place_of(index: i64, count: usize) -> Option<usize> {
    let place = match index {
        1.. => usize::try_from(index - 1).ok(),
        _ => usize::try_from(index.unsigned_abs()).ok().filter(|&back| back > 0).and_then(|back| count.checked_sub(back)),
    };
    place.filter(|&place| place < count)
}
