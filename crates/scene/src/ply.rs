//! PLY 1.0, as text or binary: polygons without materials, for form factors.
//!
//! Read are `x`, `y` and `z` of `vertex`, of any type of number, and the list `vertex_indices` (or `vertex_index`) of `face`; other
//! properties are skipped. All faces are of one surface. The order of a face's vertices decides to which side it is lit. The
//! material is black.
//!
//! Noted are other elements, lines of the header that are no statement, bytes after the last element, and, in a text with a line
//! for each element, numbers that the header does not tell of. A vertex that is no three finite numbers is refused where a face
//! uses it.

use std::path::Path;

use radgrad_core::DVec3;

use crate::error::Error;
use crate::messages::quoted;
use crate::place::Position;
use crate::precision::{Coordinates, Digits, Written};
use crate::reading::Reading;
use crate::scene::Scene;
use crate::scene::intake::Intake;
use crate::scene::vertices::Vertices;
use crate::words;
use crate::words::{Words, without_mark};

/// Reads a file.
///
/// # Errors
/// If it cannot be read, or something in it is wrong: with the line of the header, or the element counted from 0.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let (intake, material) = Intake::of_mesh(file, reading.into())?;
    let content = crate::reading::open(file, intake.budget())?;
    parse_within(&content, intake, material)?.finish()
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
    parse_within(content, intake, material)?.finish()
}

fn parse_within(content: &[u8], mut intake: Intake, material: usize) -> Result<Intake, Error> {
    let file = intake.file();
    let is_utf_16 = content.starts_with(b"\xff\xfe") || content.starts_with(b"\xfe\xff");
    let text = if is_utf_16 { Some(intake.decode(content, &file)?) } else { None };
    let (header, data) = Header::read(text.as_ref().map_or(without_mark(content), |text| text.as_bytes()), &mut intake)?;
    let by_lines = header.format == Format::Text && header.stands_in_lines(data);
    let mut numbers = Numbers { rest: data, format: header.format, row: by_lines.then_some(b"") };
    let mut vertices = Vertices::default();
    let surface = intake.surface("mesh")?;
    for element in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            let given = format!("none of {}", quoted(Some(&element.name)));
            return Err(Error::expected("at least one property of each element", given).at_place(intake.place(Position::File)));
        }
        if !matches!(element.name.as_str(), "vertex" | "face") {
            let place = intake.place(Position::File);
            intake.ignore(place, format!("the elements {} are not used", quoted(Some(&element.name))));
        }
        for index in 0..element.count {
            let place = |intake: &Intake| intake.place(Position::Member(format!("{}[{index}]", element.name)));
            numbers.start();
            let read = match element.name.as_str() {
                "vertex" => element.vertex(&mut numbers).and_then(|vertex| {
                    let vertex = vertex.map_err(|error| error.at_place(place(&intake)));
                    vertices.push(vertex, &intake)
                }),
                "face" => element.face(&mut numbers, &mut vertices, &mut intake).and_then(|corners| {
                    let place = place(&intake);
                    intake.add_face(surface, material, corners, place)
                }),
                _ => element.each(&mut numbers, |_, _| Ok(())),
            };
            read.map_err(|error| if error.place().is_some() { error } else { error.at_place(place(&intake)) })?;
            if numbers.row.is_some_and(|row| !row.trim_ascii().is_empty()) {
                let place = place(&intake);
                intake.ignore(place, format!("numbers of {} that the header does not tell of are not used", element.name));
            }
        }
    }
    if !numbers.is_at_end() {
        let place = intake.place(Position::File);
        intake.ignore(place, "what follows the last element is not read".to_owned());
    }
    vertices.note_faults(&mut intake);
    Ok(intake)
}

/// A number, and the same as an integer if it was written as one. A word that is no number is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Number<'a> {
    real: f64,
    integer: Option<i64>,
    word: Option<&'a str>,
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

/// The kind of a line of the header.
enum Line {
    Statement,
    Last,
    Other,
}

struct Header {
    format: Format,
    elements: Vec<Element>,
}

/// The numbers that are not read yet.
struct Numbers<'a> {
    rest: &'a [u8],
    format: Format,
    /// The rest of the line, of a text with a line for each element.
    row: Option<&'a [u8]>,
}

impl Header {
    /// The header and the content after it.
    fn read<'a>(content: &'a [u8], intake: &mut Intake) -> Result<(Self, &'a [u8]), Error> {
        // The first line tells how lines end: after the last, any byte may be one of a number.
        let first = content.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(content.len());
        let ends_with_return = content.get(first) == Some(&b'\r') && content.get(first + 1) != Some(&b'\n');
        let end_of_line = if ends_with_return { b'\r' } else { b'\n' };
        let (mut rest, mut format, mut elements) = (content, None, Vec::new());
        for line in 1.. {
            let place = intake.place(Position::Line(line));
            let Some(end) = rest.iter().position(|&byte| byte == end_of_line) else {
                return Err(Error::expected("`end_header`", "the end of the file").at_place(place));
            };
            let text = String::from_utf8_lossy(&rest[..end]);
            rest = &rest[end + 1..];
            intake.budget().take_many("the header", 1, size_of::<Element>() + size_of::<Property>())?;
            match Self::line(line, Words::new(&text), &mut format, &mut elements)
                .map_err(|error| error.at_place(place.clone()))?
            {
                Line::Statement => {}
                Line::Other => intake.ignore(place, "a line of the header that is no statement of PLY is not used".to_owned()),
                Line::Last => {
                    let format = format.ok_or_else(|| Error::expected("a line `format` before it", "none").at_place(place))?;
                    return Ok((Self { format, elements }, rest));
                }
            }
        }
        Err(Error::expected("`end_header`", "no end").at_place(intake.place(Position::File)))
    }

    /// Whether each element of a text has a line of its own that holds all its numbers.
    fn stands_in_lines(&self, data: &[u8]) -> bool {
        let mut lines = data.split(|byte| matches!(byte, b'\n' | b'\r')).filter(|line| !line.trim_ascii().is_empty());
        let mut has_line = |element: &Element| {
            let Some(line) = lines.next() else { return false };
            let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            element.properties.iter().all(|property| {
                let word = words.next();
                let count = || std::str::from_utf8(word?).ok()?.parse::<usize>().ok();
                match property.length {
                    None => word.is_some(),
                    Some(_) => count().is_some_and(|count| count == 0 || words.nth(count - 1).is_some()),
                }
            })
        };
        self.elements.iter().all(|element| (0..element.count).all(|_| has_line(element)))
    }

    /// Takes a line, unless it is no statement.
    fn line(line: usize, mut words: Words<'_>, format: &mut Option<Format>, elements: &mut Vec<Element>) -> Result<Line, Error> {
        let word = words.next();
        match word {
            Some("ply") if line == 1 => {}
            _ if line == 1 => return Err(Error::expected("`ply`", quoted(word))),
            Some("comment" | "obj_info") | None => {}
            Some("format") => {
                let name = words.next();
                *format = Some(match name {
                    Some("ascii") => Format::Text,
                    Some("binary_little_endian") => Format::Little,
                    Some("binary_big_endian") => Format::Big,
                    _ => return Err(Error::expected("ascii, binary_little_endian or binary_big_endian", quoted(name))),
                });
            }
            Some("element") => {
                let name = words.next().ok_or_else(|| Error::expected("the name of an element", quoted(None)))?.to_owned();
                let count = words.integer("how many there are")?;
                let count = u64::try_from(count).map_err(|_| Error::expected("a count", count.to_string()))?;
                elements.push(Element { name, count, properties: Vec::new() });
            }
            Some("property") => {
                let first = words.next();
                let length = if first == Some("list") { Some(Type::named(words.next())?) } else { None };
                let kind = Type::named(if length.is_some() { words.next() } else { first })?;
                let name = words.next().ok_or_else(|| Error::expected("the name of a property", quoted(None)))?.to_owned();
                let element = elements.last_mut().ok_or_else(|| Error::expected("`element` before it", "none"))?;
                element.properties.push(Property { name, length, of: kind });
            }
            Some("end_header") => return Ok(Line::Last),
            _ => return Ok(Line::Other),
        }
        Ok(Line::Statement)
    }
}

impl Type {
    fn named(word: Option<&str>) -> Result<Self, Error> {
        Ok(match word.map(str::to_ascii_lowercase).as_deref() {
            Some("char" | "int8") => Self::Signed(1),
            Some("short" | "int16") => Self::Signed(2),
            Some("int" | "int32") => Self::Signed(4),
            Some("uchar" | "uint8") => Self::Unsigned(1),
            Some("ushort" | "uint16") => Self::Unsigned(2),
            Some("uint" | "uint32") => Self::Unsigned(4),
            Some("long" | "int64") => Self::Signed(8),
            Some("ulong" | "uint64") => Self::Unsigned(8),
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
    /// Calls `take` with each property and its value, of a list with each of its values.
    fn each<'a>(
        &self,
        numbers: &mut Numbers<'a>,
        mut take: impl FnMut(&Property, Number<'a>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for property in &self.properties {
            let count = match property.length {
                None => 1,
                Some(of) => numbers.next(of)?.count("the length of a list")?,
            };
            for _ in 0..count {
                take(property, numbers.next(property.of)?)?;
            }
        }
        Ok(())
    }

    /// A vertex, or the fault of its coordinates; an error where its end is not known.
    fn vertex(&self, numbers: &mut Numbers<'_>) -> Result<Result<Coordinates, Error>, Error> {
        let (mut position, mut written, mut fault) = ([None; 3], [Written::Double; 3], None);
        self.each(numbers, |property, number| {
            let name = property.name.as_str();
            let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) else { return Ok(()) };
            position[axis] = Some(number.real);
            written[axis] = match (number.word, property.of) {
                (Some(word), _) => Written::Text(Digits::parse(word)),
                (None, Type::Float(4)) => Written::Single,
                (None, _) => Written::Double,
            };
            if !number.real.is_finite() {
                let error = match number.word {
                    Some(word) => words::number(Some(word), name).err(),
                    None => Some(Error::expected(format!("a finite number ({name})"), number.real.to_string())),
                };
                fault = fault.take().or(error);
            }
            Ok(())
        })?;
        let [Some(x), Some(y), Some(z)] = position else { return Err(Error::expected("properties x, y and z", "fewer")) };
        Ok(fault.map_or(Ok(([x, y, z], written)), Err))
    }

    fn face(&self, numbers: &mut Numbers<'_>, vertices: &mut Vertices, intake: &mut Intake) -> Result<Vec<DVec3>, Error> {
        let mut corners = Vec::with_capacity(4);
        self.each(numbers, |property, number| {
            if property.name == "vertex_indices" || property.name == "vertex_index" {
                intake.budget().take_many("corners of faces", 1, 2 * size_of::<DVec3>())?;
                let index = number.integer.and_then(|index| usize::try_from(index).ok());
                let corner = index.map(|index| vertices.corner(index, intake)).transpose()?.flatten();
                corners.push(corner.ok_or_else(|| {
                    let given = number.word.map_or_else(|| number.real.to_string(), |word| quoted(Some(word)));
                    Error::expected(format!("the index of one of the {} vertices before the faces", vertices.len()), given)
                })?);
            }
            Ok(())
        })?;
        Ok(corners)
    }
}

impl Number<'_> {
    fn count(self, what: &str) -> Result<u64, Error> {
        let count = self.integer.and_then(|count| u64::try_from(count).ok());
        count.ok_or_else(|| Error::expected(what, self.real.to_string()))
    }
}

impl<'a> Numbers<'a> {
    /// Goes to the next element.
    fn start(&mut self) {
        if self.row.is_some() {
            self.rest = self.rest.trim_ascii_start();
            let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(self.rest.len());
            let (row, rest) = self.rest.split_at(end);
            (self.row, self.rest) = (Some(row), rest);
        }
    }

    fn is_at_end(&self) -> bool {
        if self.format == Format::Text { self.rest.trim_ascii().is_empty() } else { self.rest.is_empty() }
    }

    fn next(&mut self, of: Type) -> Result<Number<'a>, Error> {
        if self.format == Format::Text {
            let from = self.row.as_mut().unwrap_or(&mut self.rest);
            let text = from.trim_ascii_start();
            let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let (word, rest) = text.split_at(end);
            *from = rest;
            if word.is_empty() {
                return Err(Error::expected("a number", "the end of the file"));
            }
            let word = std::str::from_utf8(word).unwrap_or("?");
            return Ok(Number { real: word.parse().unwrap_or(f64::NAN), integer: word.parse().ok(), word: Some(word) });
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
        let integer = |value: i64| Number { real: value as f64, integer: Some(value), word: None };
        let float = |real: f64| Number { real, integer: None, word: None };
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
        let many = "ply\nformat ascii 1.0\nelement vertex 9000000000000\nend_header\n";
        assert_eq!(refused(many.as_bytes()), "a.ply: expected at least one property of each element, found none of `vertex`");
    }

    const VERTICES: &str = "property Float x\nproperty float32 y\nproperty uint64 z\n";

    #[test]
    fn what_the_header_does_not_tell_of_is_noted() {
        let text = format!(
            "ply\r\nformat ascii 1.0 x\r\nMade without the word comment\r\nelement vertex 4\r\n{}comment b\u{e9}\r\nelement              material 0\r\nelement face 2\r\nproperty list uchar int vertex_index\r\nobj_info\r\nend_header \r\n0 0 0              9\r\n\r\n1 0 0 9\r\n0 1 0 9 red\r\n1 x 1\r\n3 0 1 2 255 255\r\n3 2 1 0 255 255\r\nThe end.\r\n",
            VERTICES.replace('\n', "\r\n")
        );
        let utf_16: Vec<u8> = "\u{feff}".chars().chain(text.chars()).flat_map(|c| (c as u16).to_be_bytes()).collect();
        let notes = [
            "a.ply:3: a line of the header that is no statement of PLY is not used",
            "a.ply: vertex[0]: numbers of vertex that the header does not tell of are not used",
            "a.ply: the elements `material` are not used",
            "a.ply: face[0]: numbers of face that the header does not tell of are not used",
            "a.ply: what follows the last element is not read",
            "a.ply: vertex[3]: expected a number (y), found `x`: of a vertex that no face uses",
        ];
        for content in [text.clone().into_bytes(), text.replace("\r\n", "\r").into_bytes(), utf_16] {
            let scene = read(&content).unwrap();
            assert_eq!((scene.faces().len(), scene.area_of(0)), (2, 1.0));
            let messages: Vec<String> = scene.notes().iter().map(ToString::to_string).collect();
            assert_eq!(messages[messages.len() - 6..], notes);
        }
        let used = read(text.replace("3 2 1 0", "3 3 1 0").as_bytes()).unwrap_err().to_string();
        assert_eq!(used, "a.ply: vertex[3]: expected a number (y), found `x`");
    }

    #[test]
    fn a_text_need_not_have_a_line_for_each_element() {
        let text = format!("ply\nformat ascii 1.0\nelement vertex 4\n{VERTICES}element face 1\n");
        let text =
            text + "property list uchar int vertex_index\nproperty int a\nend_header\n0 0 0 1 0 0\n1 1\n0 0 1 0\n4 0 1\n2 3 7";
        let scene = read(text.as_bytes()).unwrap();
        assert_eq!((scene.area_of(0), scene.notes().len()), (1.0, 0));
    }

    #[test]
    fn bytes_after_a_binary_file_are_noted_and_the_budget_holds_vertices() {
        let longer = [&binary(true, 3)[..], b"\n"].concat();
        let note = read(&longer).unwrap().notes().last().unwrap().to_string();
        assert_eq!(note, "a.ply: what follows the last element is not read");
        let many =
            format!("ply\nformat ascii 1.0\nelement vertex 100000\nproperty float x\nproperty float y\nproperty float z\n{}", "");
        let many = many + "end_header\n" + &"0 0 0\n".repeat(100_000);
        let small = Reading { budget: 1 << 20, ..Reading::default() };
        let error = parse(many.as_bytes(), Path::new("a.ply"), small).unwrap_err().to_string();
        assert!(error.contains("vertices: reading takes more than the 1 MiB"), "{error}");
    }
}
