//! PLY 1.0, as text or binary: polygons without materials, for form factors.
//!
//! Read are `x`, `y` and `z` of `vertex`, of any type of number, and the list `vertex_indices` (or `vertex_index`) of `face`; other
//! properties and elements are skipped. All faces are of one surface. The order of a face's vertices decides to which side it is lit.
//! The material is black.

use std::path::Path;

use radgrad_core::DVec3;

use crate::scene::Intake;
use crate::words::{Words, decode, quoted};
use crate::{Error, Position, Reading, Scene};

/// Reads a file.
///
/// # Errors
/// If it cannot be read, or something in it is wrong: with the line of the header, or the element counted from 0.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let (intake, material) = Intake::of_mesh(file, reading.into())?;
    let content = crate::open(file, intake.budget())?;
    parse_within(&content, intake, material)
}

/// Reads the content of a file, whose name is `file` in messages.
///
/// ```
/// use radgrad_scene::{Degenerate, ply};
/// let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
///             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n";
/// let scene = ply::parse(text.as_bytes(), "lid.ply".as_ref(), Degenerate::Refuse)?;
/// assert_eq!(scene.area_of(0), 1.0);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn parse(content: &[u8], file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let (intake, material) = Intake::of_mesh(file, reading.into())?;
    parse_within(content, intake, material)
}

fn parse_within(content: &[u8], mut intake: Intake, material: usize) -> Result<Scene, Error> {
    let (header, data) = Header::read(content, &intake)?;
    let mut numbers = Numbers { rest: data, format: header.format };
    let mut vertices: Vec<DVec3> = Vec::new();
    let surface = intake.surface("mesh")?;
    for element in &header.elements {
        if element.properties.is_empty() {
            let found = format!("none of `{}`", element.name);
            return Err(Error::expected("at least one property of each element", found).at(intake.place(Position::File)));
        }
        for index in 0..element.count {
            let place = || intake.place(Position::Member(format!("{}[{index}]", element.name)));
            match element.name.as_str() {
                "vertex" => {
                    vertices.push(element.vertex(&mut numbers).map_err(|error| error.at(place()))?);
                }
                "face" => {
                    let corners = element.face(&mut numbers, &vertices).map_err(|error| error.at(place()))?;
                    let place = place();
                    intake.add_face(surface, material, corners, place)?;
                }
                _ => element.each(&mut numbers, |_, _| Ok(())).map_err(|error| error.at(place()))?,
            }
        }
    }
    intake.finish()
}

/// A number, and the same as an integer if it was written as one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Number {
    real: f64,
    integer: Option<i64>,
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Text,
    Little,
    Big,
}

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

struct Property {
    name: String,
    /// The type of the length, of a list.
    length: Option<Type>,
    of: Type,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Header {
    format: Format,
    elements: Vec<Element>,
}

/// The numbers that are not read yet.
struct Numbers<'a> {
    rest: &'a [u8],
    format: Format,
}

impl Header {
    /// The header and the content after it.
    fn read<'a>(content: &'a [u8], intake: &Intake) -> Result<(Self, &'a [u8]), Error> {
        let (mut rest, mut format, mut elements) = (content, None, Vec::new());
        for line in 1.. {
            let place = intake.place(Position::Line(line));
            let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
                return Err(Error::expected("`end_header`", "the end of the file").at(place));
            };
            let text = decode(&rest[..end]).map_err(|error| error.at(place.clone()))?;
            rest = &rest[end + 1..];
            let is_end =
                Self::line(line, Words::new(text), &mut format, &mut elements).map_err(|error| error.at(place.clone()))?;
            if is_end {
                let format = format.ok_or_else(|| Error::expected("a line `format` before it", "none").at(place))?;
                return Ok((Self { format, elements }, rest));
            }
        }
        Err(Error::expected("`end_header`", "no end").at(intake.place(Position::File)))
    }

    /// Whether the line is the last.
    fn line(line: usize, mut words: Words<'_>, format: &mut Option<Format>, elements: &mut Vec<Element>) -> Result<bool, Error> {
        let word = words.next();
        match word {
            Some("ply") if line == 1 => {}
            _ if line == 1 => return Err(Error::expected("`ply`", quoted(word))),
            Some("comment" | "obj_info") | None => return Ok(false),
            Some("format") => {
                let name = words.next();
                *format = Some(match name {
                    Some("ascii") => Format::Text,
                    Some("binary_little_endian") => Format::Little,
                    Some("binary_big_endian") => Format::Big,
                    _ => return Err(Error::expected("ascii, binary_little_endian or binary_big_endian", quoted(name))),
                });
                words.next();
            }
            Some("element") => {
                let name = words.next().ok_or_else(|| Error::expected("the name of an element", quoted(None)))?.to_owned();
                let count = words.integer("how many there are")?;
                let count = u64::try_from(count).map_err(|_| Error::expected("a count", count.to_string()))?;
                elements.push(Element { name, count, properties: Vec::new() });
            }
            Some("property") => {
                let of = words.next();
                let length = if of == Some("list") { Some(Type::named(words.next())?) } else { None };
                let of = Type::named(if length.is_some() { words.next() } else { of })?;
                let name = words.next().ok_or_else(|| Error::expected("the name of a property", quoted(None)))?.to_owned();
                let element = elements.last_mut().ok_or_else(|| Error::expected("`element` before it", "none"))?;
                element.properties.push(Property { name, length, of });
            }
            Some("end_header") => return Ok(true),
            _ => return Err(Error::expected("format, element, property, comment or end_header", quoted(word))),
        }
        words.end()?;
        Ok(false)
    }
}

impl Type {
    fn named(word: Option<&str>) -> Result<Self, Error> {
        Ok(match word {
            Some("char" | "int8") => Self::Signed(1),
            Some("short" | "int16") => Self::Signed(2),
            Some("int" | "int32") => Self::Signed(4),
            Some("uchar" | "uint8") => Self::Unsigned(1),
            Some("ushort" | "uint16") => Self::Unsigned(2),
            Some("uint" | "uint32") => Self::Unsigned(4),
            Some("float" | "float32") => Self::Float(4),
            Some("double" | "float64") => Self::Float(8),
            _ => return Err(Error::expected("a type of number (float, double, uchar, int, ...)", quoted(word))),
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }
}

impl Element {
    /// Calls `take` with each property's name and value, of a list with each of its values.
    fn each(&self, numbers: &mut Numbers<'_>, mut take: impl FnMut(&str, Number) -> Result<(), Error>) -> Result<(), Error> {
        for property in &self.properties {
            let count = match property.length {
                None => 1,
                Some(of) => numbers.next(of)?.count("the length of a list")?,
            };
            for _ in 0..count {
                take(&property.name, numbers.next(property.of)?)?;
            }
        }
        Ok(())
    }

    fn vertex(&self, numbers: &mut Numbers<'_>) -> Result<DVec3, Error> {
        let mut found = [None; 3];
        self.each(numbers, |name, Number { real: number, .. }| {
            if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
                if !number.is_finite() {
                    return Err(Error::expected(format!("a finite number ({name})"), number.to_string()));
                }
                found[axis] = Some(number);
            }
            Ok(())
        })?;
        match found {
            [Some(x), Some(y), Some(z)] => Ok(DVec3::new(x, y, z)),
            _ => Err(Error::expected("properties x, y and z", "fewer")),
        }
    }

    fn face(&self, numbers: &mut Numbers<'_>, vertices: &[DVec3]) -> Result<Vec<DVec3>, Error> {
        let mut corners = Vec::with_capacity(4);
        self.each(numbers, |name, number| {
            if name == "vertex_indices" || name == "vertex_index" {
                let place = number.integer.and_then(|index| vertices.get(usize::try_from(index).ok()?));
                let expected = || format!("the index of one of the {} vertices before the faces", vertices.len());
                corners.push(*place.ok_or_else(|| Error::expected(expected(), number.real.to_string()))?);
            }
            Ok(())
        })?;
        Ok(corners)
    }
}

impl Number {
    fn count(self, what: &str) -> Result<u64, Error> {
        let count = self.integer.and_then(|count| u64::try_from(count).ok());
        count.ok_or_else(|| Error::expected(what, self.real.to_string()))
    }
}

impl<'a> Numbers<'a> {
    fn next(&mut self, of: Type) -> Result<Number, Error> {
        if self.format == Format::Text {
            self.rest = self.rest.trim_ascii_start();
            let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
            let (word, rest) = self.rest.split_at(end);
            self.rest = rest;
            let word = decode(word)?;
            let found = || if word.is_empty() { "the end of the file".to_owned() } else { quoted(Some(word)) };
            let real = word.parse().map_err(|_| Error::expected("a number", found()))?;
            return Ok(Number { real, integer: word.parse().ok() });
        }
        let end = || Error::expected("a number", "the end of the file");
        let (bytes, rest): (&'a [u8], _) = self.rest.split_at_checked(of.size()).ok_or_else(end)?;
        self.rest = rest;
        // The value in eight bytes, the most significant first.
        let mut value = [0; 8];
        for (place, &byte) in bytes.iter().enumerate() {
            value[8 - bytes.len() + if self.format == Format::Little { bytes.len() - 1 - place } else { place }] = byte;
        }
        let bits = u64::from_be_bytes(value);
        let integer = |value: i64| Number { real: value as f64, integer: Some(value) };
        let float = |real: f64| Number { real, integer: None };
        Ok(match of {
            Type::Float(4) => float(f64::from(f32::from_be_bytes([value[4], value[5], value[6], value[7]]))),
            Type::Float(_) => float(f64::from_bits(bits)),
            Type::Unsigned(_) => integer(bits.cast_signed()),
            Type::Signed(size) => {
                let unused = 64 - 8 * u32::try_from(size).unwrap_or(8);
                integer((bits << unused).cast_signed() >> unused)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 4\nproperty double x\nproperty double y\nproperty uchar red\nproperty double z\n\
                          element edge 1\nproperty short a\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn read(content: &[u8]) -> Result<Scene, Error> {
        parse(content, Path::new("a.ply"), crate::Degenerate::Refuse)
    }

    fn binary(little: bool, last: i32) -> Vec<u8> {
        let name = if little { "little" } else { "big" };
        let mut content = format!("ply\nformat binary_{name}_endian 1.0\ncomment a quad\n{HEADER}").into_bytes();
        let mut add = |bytes: &[u8]| content.extend_from_slice(bytes);
        let order = |mut bytes: Vec<u8>| {
            if little {
                bytes.reverse();
            }
            bytes
        };
        for [x, y] in [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0_f64]] {
            add(&order(x.to_be_bytes().to_vec()));
            add(&order(y.to_be_bytes().to_vec()));
            add(&[200]);
            add(&order(0.5_f64.to_be_bytes().to_vec()));
        }
        add(&order((-2_i16).to_be_bytes().to_vec()));
        add(&[4]);
        for index in [0, 1, 2, last] {
            add(&order(index.to_be_bytes().to_vec()));
        }
        content
    }

    #[test]
    fn text_and_both_binary_forms_say_the_same() {
        let text = format!("ply\nformat ascii 1.0\n{HEADER}0 0 9 .5\n2 0 9 .5\n2 1 9 .5\n0 1 9 .5\n-2\n4 0 1 2 3\n");
        for content in [text.into_bytes(), binary(true, 3), binary(false, 3)] {
            let scene = read(&content).unwrap();
            assert_eq!((scene.faces().len(), scene.area_of(0)), (1, 2.0));
            assert_eq!(scene.polygons().next().unwrap().vertices()[2], DVec3::new(2.0, 1.0, 0.5));
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let refused = |content: &[u8]| read(content).unwrap_err().to_string();
        assert_eq!(refused(b"plx\n"), "a.ply:1: expected `ply`, found `plx`");
        assert_eq!(refused(b"ply\nformat ascii 1.0\n"), "a.ply:3: expected `end_header`, found the end of the file");
        for little in [true, false] {
            let message = refused(&binary(little, -1));
            assert_eq!(message, "a.ply: face[0]: expected the index of one of the 4 vertices before the faces, found -1");
            let content = binary(little, 3);
            let message = refused(&content[..content.len() - 1]);
            assert_eq!(message, "a.ply: face[0]: expected a number, found the end of the file");
        }
        // A count that no file can hold costs no memory.
        let many = "ply\nformat ascii 1.0\nelement vertex 9000000000000\nproperty float x\nend_header\n";
        assert_eq!(refused(many.as_bytes()), "a.ply: vertex[0]: expected a number, found the end of the file");
    }
}
