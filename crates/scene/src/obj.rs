//! Wavefront OBJ with its MTL libraries, in double precision.
//!
//! Read: `v` (a fourth number and vertex colours are skipped), `f` with any number of vertices in the forms `v`, `v/vt`, `v//vn`
//! and `v/vt/vn`, counted from 1 or backwards from -1; `o`, `g`, `usemtl`, `mtllib`; `Kd` and `Ke` of materials; comments, lines
//! continued by `\`, either end of line. `map_Kd` and `map_Ke` are textures, where faces have the
//! coordinates `vt`. The order of a face's vertices decides to which side it is lit, not its normals. A
//! surface is a group: its name is that of `g`, or `o`, or `o/g` where both are given; a name that comes again is the same
//! surface.
//!
//! A library that cannot be read is noted; a material that is then not known is refused where it is used, or taken as black
//! where materials are optional ([`crate::Materials`]).
//!
//! Statements that say nothing of flat, diffuse faces are skipped: `vn`, `vp`, `s`, `mg`, and statements about display. Points and
//! lines are skipped with a [`crate::Note`]. Free-form surfaces, and any statement that is unknown, are refused: they may be faces.

mod map;
mod mtl;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use radgrad_core::DVec3;

use self::map::Textures;
use crate::reading::{Budget, Folder, ReadFile};
use crate::scene::{Intake, Outline};
use crate::words::{Words, decode, printable, quoted, without_mark};
use crate::{Error, Position, Reading, Scene};

/// Reads a file and the material libraries that it names, which stand beside it.
///
/// # Errors
/// If a file cannot be read, or breaks the format: with file, line and the expected value.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    let text = crate::open(file, &budget)?;
    let folder = Folder::of(file, &reading, &budget);
    parse_within(&text, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut |name| folder.read(name))
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
    parse_within(text, Intake::new(Scene::new(["r", "g", "b"])?, file, reading, &budget), &mut library)
}

fn parse_within(text: &[u8], intake: Intake, library: &mut ReadFile<'_>) -> Result<Scene, Error> {
    let mut reader = Reader {
        intake,
        vertices: Vec::new(),
        coordinates: Vec::new(),
        materials: HashMap::new(),
        textures: Textures::default(),
        libraries: Vec::new(),
        missing: None,
        object: String::new(),
        group: String::new(),
        material: None,
        library,
    };
    for_each_statement(text, |line, statement| {
        let result = decode(statement).and_then(|statement| reader.statement(line, statement));
        // An error in a library has its place already.
        result.map_err(|error| if error.place().is_some() { error } else { error.at(reader.intake.place(Position::Line(line))) })
    })?;
    reader.intake.finish()
}

/// Calls `take` with the number of each statement's first line and with its text: comments cut off, continued lines joined,
/// blank ones left out.
fn for_each_statement(text: &[u8], mut take: impl FnMut(usize, &[u8]) -> Result<(), Error>) -> Result<(), Error> {
    let text = without_mark(text);
    let (mut first, mut joined) = (0, Vec::new());
    for (index, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let comment = (0..line.len()).find(|&i| line[i] == b'#' && (i == 0 || line[i - 1].is_ascii_whitespace()));
        let line = line[..comment.unwrap_or(line.len())].trim_ascii_end();
        if joined.is_empty() {
            first = index + 1;
        }
        if let Some(line) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(line);
            joined.push(b' ');
            continue;
        }
        joined.extend_from_slice(line);
        if !joined.trim_ascii().is_empty() {
            take(first, &joined)?;
        }
        joined.clear();
    }
    if joined.is_empty() { Ok(()) } else { take(first, &joined) }
}

struct Reader<'a> {
    intake: Intake,
    vertices: Vec<DVec3>,
    /// `vt`.
    coordinates: Vec<[f64; 2]>,
    /// Index of each material by its name.
    materials: HashMap<String, usize>,
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
            "v" => self.vertex(words)?,
            "vt" => self.coordinate(words)?,
            "f" | "fo" => self.face(line, words)?,
            "o" | "g" => {
                let name = Intake::checked_name(words.rest())?.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
                if keyword == "o" {
                    self.object = name;
                    self.group.clear();
                } else {
                    self.group = name;
                }
            }
            "usemtl" => self.material = Some(self.material_named(line, words.rest())?),
            "mtllib" => self.read_libraries(line, words)?,
            "p" | "l" => self.ignore(line, format!("`{keyword}` is no surface: points and lines are left out")),
            "vn" | "vp" | "s" | "mg" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" | "maplib"
            | "usemap" => {}
            "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end"
            | "con" | "bzp" | "bsp" | "cdc" | "cdp" | "res" | "ctech" | "stech" => {
                return Err(Error::Unsupported {
                    what: format!("the free-form statement `{keyword}`"),
                    instead: "export the surfaces as polygons",
                });
            }
            _ => return Err(Error::expected("a statement of OBJ (v, f, o, g, usemtl, mtllib, ...)", quoted(Some(keyword)))),
        }
        Ok(())
    }

    fn ignore(&mut self, line: usize, what: String) {
        let place = self.intake.place(Position::Line(line));
        self.intake.ignore(place, what);
    }

    fn vertex(&mut self, mut words: Words<'_>) -> Result<(), Error> {
        let vertex = DVec3::new(words.number("x")?, words.number("y")?, words.number("z")?);
        // A weight or a colour may follow, or both.
        for further in ["w or red", "green", "blue", "alpha"] {
            if words.is_empty() {
                break;
            }
            words.number(further)?;
        }
        words.end()?;
        self.intake.budget().take_many("vertices", 1, 2 * size_of::<DVec3>())?;
        self.vertices.push(vertex);
        Ok(())
    }

    /// `u`, and `v` where there is one; a third number is of no use on a surface.
    fn coordinate(&mut self, mut words: Words<'_>) -> Result<(), Error> {
        let u = words.number("u")?;
        let v = if words.is_empty() { 0.0 } else { words.number("v")? };
        if !words.is_empty() {
            words.number("w")?;
        }
        words.end()?;
        self.intake.budget().take_many("texture coordinates", 1, 2 * size_of::<[f64; 2]>())?;
        self.coordinates.push([u, v]);
        Ok(())
    }

    fn face(&mut self, line: usize, mut words: Words<'_>) -> Result<(), Error> {
        let (mut vertices, mut corners) = (Vec::with_capacity(4), Vec::with_capacity(4));
        while let Some(word) = words.next() {
            self.intake.budget().take_many("corners of faces", 1, size_of::<DVec3>() + size_of::<&str>())?;
            vertices.push(self.corner(word)?);
            corners.push(word);
        }
        let material = self.material_index(line)?;
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
        let mut uv = Vec::with_capacity(corners.len());
        for word in corners {
            let texture = word.split('/').nth(1).filter(|texture| !texture.is_empty());
            let Some(index) = texture.and_then(|texture| texture.parse::<i64>().ok()) else {
                self.ignore(line, "faces without `vt` have no texture: `Kd` and `Ke` hold all over them".to_owned());
                return Ok([None, None]);
            };
            let place = place_of(index, self.coordinates.len());
            uv.push(place.map(|place| self.coordinates[place]).ok_or_else(|| {
                let count = self.coordinates.len();
                Error::expected(format!("the index of one of the {count} `vt` before this line"), quoted(Some(word)))
            })?);
        }
        Ok(mappings.map(|mapping| mapping.map(|mapping| uv.iter().map(|&uv| mapping.apply(uv)).collect())))
    }

    /// The vertex of one word of a face: `7`, `7/1`, `7//3` or `7/1/3`, or the same with negative numbers.
    fn corner(&self, word: &str) -> Result<DVec3, Error> {
        let wrong = || Error::expected("a vertex of a face (`v`, `v/vt`, `v//vn` or `v/vt/vn`)", quoted(Some(word)));
        let is_integer = |part: &str| part.parse::<i64>().is_ok();
        let (index, attributes) = word.split_once('/').map_or((word, None), |(index, rest)| (index, Some(rest)));
        let index: i64 = index.parse().map_err(|_| wrong())?;
        let well_formed = attributes.is_none_or(|attributes| match attributes.split_once('/') {
            None => is_integer(attributes),
            Some((texture, normal)) => (texture.is_empty() || is_integer(texture)) && is_integer(normal),
        });
        if !well_formed {
            return Err(wrong());
        }
        let count = self.vertices.len();
        place_of(index, count).map(|place| self.vertices[place]).ok_or_else(|| {
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

    /// The material of a name. One that is not known is black where materials are optional.
    fn material_named(&mut self, line: usize, name: &str) -> Result<usize, Error> {
        if let Some(&material) = self.materials.get(name) {
            return Ok(material);
        }
        let known = match &self.missing {
            Some(missing) => missing.clone(),
            None => format!("{} are known from {} libraries", self.materials.len(), self.libraries.len()),
        };
        let missing = Error::Missing { what: "material", which: quoted(Some(name)), known };
        if self.intake.needs_materials() {
            return Err(missing);
        }
        self.ignore(line, format!("{missing}: taken as black"));
        let black = self.intake.add_material(name, &[0.0; 3], &[0.0; 3])?;
        self.materials.insert(name.to_owned(), black);
        Ok(black)
    }

    /// One library whose name may have spaces, or else several.
    fn read_libraries(&mut self, line: usize, words: Words<'_>) -> Result<(), Error> {
        let whole = words.rest();
        if whole.is_empty() {
            return Err(Error::expected("the name of a material library", quoted(None)));
        }
        match (self.library)(Path::new(whole)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound && whole.contains(|c: char| c.is_ascii_whitespace()) => {
                whole.split_ascii_whitespace().try_for_each(|name| {
                    let content = (self.library)(Path::new(name));
                    self.take_library(line, name, content)
                })
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
                if error.kind() == io::ErrorKind::FileTooLarge {
                    return Err(self.intake.budget().exceeded(&format!("`{}`", printable(name))));
                }
                self.ignore(line, unreadable.to_string());
                self.missing.get_or_insert(unreadable.to_string());
                return Ok(());
            }
        };
        mtl::parse(&content, Path::new(name), &mut self.intake, &mut self.materials, &mut self.textures)?;
        self.libraries.push(name.into());
        Ok(())
    }
}

/// The place in a list of an index from 1, or from -1 backwards.
fn place_of(index: i64, count: usize) -> Option<usize> {
    let place = match index {
        1.. => usize::try_from(index - 1).ok(),
        _ => usize::try_from(index.unsigned_abs()).ok().filter(|&back| back > 0).and_then(|back| count.checked_sub(back)),
    };
    place.filter(|&place| place < count)
}
