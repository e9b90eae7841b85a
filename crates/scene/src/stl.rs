//! STL, as text or binary: triangles without materials, for form factors.
//!
//! The text has `solid NAME`, facets of `facet normal x y z`, `outer loop`, three `vertex x y z`, `endloop`, `endfacet`, and
//! `endsolid`, in letters of either case; a file may have several solids, each of which is a surface. The binary form has 80 bytes of
//! anything, the number of triangles, and 50 bytes for each: a normal, three corners, single precision and little-endian, and two
//! bytes of anything. A file is binary if it is exactly as long as that, or has a byte 0 where a text has its first lines. The order
//! of the corners decides to which side a triangle is lit, not its normal. The material is black: STL has none.
//!
//! Noted are a `solid` or `endsolid` that is missing, statements such as `color` and words after the coordinates, and bytes after the last
//! triangle; a text that ends in a facet, and a binary file that is too short, are refused.

use std::path::Path;

use radgrad_core::DVec3;

use crate::error::Error;
use crate::messages::quoted;
use crate::place::Position;
use crate::precision::Written;
use crate::reading::Reading;
use crate::scene::Scene;
use crate::scene::intake::Intake;
use crate::words::{Words, lines};

/// Length of the header of a binary file, the number of triangles included, and of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads a file.
///
/// # Errors
/// If it cannot be read, or something in it is wrong: with the line, or the triangle counted from 0.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let (intake, material) = Intake::of_mesh(file, reading.into())?;
    let content = crate::reading::open(file, intake.budget())?;
    parse_within(&content, intake, material)?.finish()
}

/// Reads the content of a file, whose name is `file` in messages.
///
/// ```
/// use radgrad_scene::{Degenerate, stl};
/// let text = "solid lid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendloop\nendfacet\nendsolid lid\n";
/// let scene = stl::parse(text.as_bytes(), "lid.stl".as_ref(), Degenerate::Refuse)?;
/// assert_eq!(scene.area_of(scene.surface_named("lid")?), 1.0);
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
    if is_binary(content) {
        binary(content, material, &mut intake)?;
    } else {
        text(content, material, &mut intake)?;
    }
    Ok(intake)
}

/// The triangles of a binary file, by its count, and the bytes after its header.
fn counted(content: &[u8]) -> Option<(u64, &[u8])> {
    let (header, triangles) = content.split_at_checked(HEADER)?;
    let count = u32::from_le_bytes(header[80..].try_into().ok()?);
    Some((u64::from(count), triangles))
}

fn is_binary(content: &[u8]) -> bool {
    let is_exact = counted(content).is_some_and(|(count, triangles)| triangles.len() as u64 == count * TRIANGLE as u64);
    let has_mark = content.starts_with(b"\xff\xfe") || content.starts_with(b"\xfe\xff");
    is_exact || !has_mark && content[..content.len().min(HEADER + TRIANGLE)].contains(&0)
}

fn binary(content: &[u8], material: usize, intake: &mut Intake) -> Result<(), Error> {
    let whole = intake.place(Position::File);
    let needed = |count: u64| HEADER as u64 + count * TRIANGLE as u64;
    let (count, triangles) = counted(content).filter(|(count, _)| needed(*count) <= content.len() as u64).ok_or_else(|| {
        let expected = counted(content).map_or_else(
            || format!("the {HEADER} bytes with which binary STL begins"),
            |(count, _)| format!("{} bytes of binary STL for its {count} triangles", needed(count)),
        );
        Error::expected(expected, content.len().to_string()).at_place(whole.clone())
    })?;
    let (triangles, rest) = triangles.split_at(usize::try_from(count * TRIANGLE as u64).unwrap_or(triangles.len()));
    if !rest.is_empty() {
        intake.ignore(whole, format!("{} bytes after the {count} triangles of the file are not read", rest.len()));
    }
    let surface = intake.surface("solid")?;
    for (index, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        let place = intake.place(Position::Member(format!("triangles[{index}]")));
        let (numbers, _) = triangle[12..48].as_chunks::<4>();
        let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect();
        if let Some(wrong) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(Error::expected("a finite number", wrong.to_string()).at_place(place));
        }
        numbers.iter().for_each(|&number| intake.written().add(Written::Single, number));
        let corners = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        intake.add_face(surface, material, corners, place)?;
    }
    Ok(())
}

/// Where the reading of a text is.
struct Open {
    /// Name of the solid that is open.
    solid: Option<String>,
    /// First line and corners of the facet that is open.
    facet: Option<(usize, Vec<DVec3>)>,
}

fn text(content: &[u8], material: usize, intake: &mut Intake) -> Result<(), Error> {
    let file = intake.file();
    let content = intake.decode(content, &file)?;
    let mut reading = Open { solid: None, facet: None };
    for (index, line) in lines(&content).enumerate() {
        let place = intake.place(Position::Line(index + 1));
        let read = statement(Words::new(line), index + 1, material, &mut reading, intake);
        read.map_err(|error| if error.place().is_some() { error } else { error.at_place(place) })?;
    }
    let place = intake.place(Position::File);
    if let Some((line, _)) = reading.facet {
        return Err(Error::expected(format!("`endfacet` of the facet of line {line}"), "the end of the file").at_place(place));
    }
    if reading.solid.is_some() {
        intake.ignore(place, "the file ends without `endsolid`: it may have lost facets".to_owned());
    }
    Ok(())
}

fn statement(mut words: Words<'_>, line: usize, material: usize, reading: &mut Open, intake: &mut Intake) -> Result<(), Error> {
    let Some(word) = words.next() else { return Ok(()) };
    let mut keyword = word.to_ascii_lowercase();
    // Some write `end facet`, and `endsolidNAME`.
    if keyword == "end" {
        keyword.push_str(&words.next().unwrap_or_default().to_ascii_lowercase());
    } else if keyword.starts_with("endsolid") {
        keyword.truncate("endsolid".len());
    }
    match (keyword.as_str(), &mut reading.solid, &mut reading.facet) {
        ("solid", solid, None) => {
            let name = words.remainder();
            if solid.replace(if name.is_empty() { "solid".to_owned() } else { name.to_owned() }).is_some() {
                let place = intake.place(Position::Line(line));
                intake.ignore(place, "a solid begins before the `endsolid` of the one before it".to_owned());
            }
        }
        ("facet", solid, facet @ None) => {
            if solid.is_none() {
                let place = intake.place(Position::Line(line));
                intake.ignore(place, "a facet stands in no `solid`".to_owned());
                *solid = Some("solid".to_owned());
            }
            *facet = Some((line, Vec::with_capacity(3)));
        }
        ("outer" | "endloop", _, Some(_)) => {}
        ("vertex", _, Some((_, corners))) if corners.len() < 3 => {
            let (corner, written) = words.coordinates(["x", "y", "z"])?;
            corner.into_iter().zip(written).for_each(|(value, written)| intake.written().add(written, value));
            corners.push(corner.into());
            if !words.is_empty() {
                let place = intake.place(Position::Line(line));
                intake.ignore(place, "what follows the coordinates of a vertex is not used".to_owned());
            }
        }
        ("endfacet", Some(name), Some((first, corners))) if corners.len() == 3 => {
            let (surface, place) = (intake.surface(name)?, intake.place(Position::Line(*first)));
            intake.add_face(surface, material, std::mem::take(corners), place)?;
            reading.facet = None;
        }
        // Some write it twice.
        ("endsolid", solid, None) => *solid = None,
        (keyword, solid, facet)
            if line == 1 || matches!(keyword, "solid" | "facet" | "outer" | "vertex" | "endloop" | "endfacet" | "endsolid") =>
        {
            let next = match (solid, facet) {
                (None, _) => "`solid`, or the length of a binary file",
                (Some(_), None) => "`facet` or `endsolid`",
                (Some(_), Some((_, corners))) if corners.len() < 3 => "`vertex`",
                _ => "`endloop` or `endfacet`",
            };
            return Err(Error::expected(next, quoted(Some(word))));
        }
        _ => {
            let place = intake.place(Position::Line(line));
            intake.ignore(place, "a line that is no statement of STL is not used".to_owned());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n \
                        endfacet\nendsolid a b\nsolid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 1\nvertex 0 1 1\nvertex 1 0 1\n\
                        endloop\nendfacet\nendsolid\n";

    fn read(content: &[u8]) -> Result<Scene, Error> {
        parse(content, Path::new("a.stl"), crate::Degenerate::Refuse)
    }

    fn bytes(corners: &[[f32; 3]]) -> Vec<u8> {
        let mut content = b"solid is no sign of a text".to_vec();
        content.resize(80, 0);
        content.extend(u32::try_from(corners.len() / 3).unwrap().to_le_bytes());
        for triangle in corners.chunks(3) {
            content.extend([0; 12]);
            triangle.iter().flatten().for_each(|number| content.extend(number.to_le_bytes()));
            content.extend([0; 2]);
        }
        content
    }

    #[test]
    fn solids_are_surfaces_and_the_order_of_corners_decides() {
        let scene = read(TEXT.as_bytes()).unwrap();
        let names: Vec<&str> = scene.surfaces().iter().map(crate::Surface::name).collect();
        let up: Vec<f64> = scene.polygons().map(|polygon| polygon.normal().z).collect();
        assert_eq!((names, up), (vec!["a b", "solid"], vec![1.0, -1.0]));
    }

    #[test]
    fn a_binary_file_is_known_by_its_length() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        let content = bytes(&corners);
        let scene = read(&content).unwrap();
        assert_eq!(scene.polygons().map(radgrad_core::Polygon::area).collect::<Vec<_>>(), [0.75, 0.5]);
        let short = read(&content[..content.len() - 1]).unwrap_err().to_string();
        assert_eq!(short, "a.stl: expected 184 bytes of binary STL for its 2 triangles, found 183");
        let longer = read(&[&content[..], b"END"].concat()).unwrap();
        let note = longer.notes()[0].to_string();
        assert_eq!((longer.faces().len(), note.as_str()), (2, "a.stl: 3 bytes after the 2 triangles of the file are not read"));
        assert_eq!(
            read(b"solid\0").unwrap_err().to_string(),
            "a.stl: expected the 84 bytes with which binary STL begins, found 6"
        );
    }

    #[test]
    fn texts_are_read_as_they_are_written() {
        let facet = "FACET NORMAL nan 0 1\rOUTER LOOP\rVERTEX 0. 0 0\rVERTEX 1 0 0 # far\rVERTEX 0 .1E1 0\rEND LOOP\rEND FACET\r";
        let above = facet.replace("VERTEX 0. 0 0", "VERTEX 0. 0 1").replace("1 0 0 #", "1 0 1 #").replace(".1E1 0", ".1E1 1");
        let scene = read(format!("SOLID\r{facet}color 1 0 0\rsolid b\u{e9}\r{above}").as_bytes()).unwrap();
        let names: Vec<&str> = scene.surfaces().iter().map(crate::Surface::name).collect();
        assert_eq!((names, scene.area_of(1)), (vec!["solid", "b\u{e9}"], 0.5));
        let notes: Vec<String> = scene.notes().iter().map(ToString::to_string).collect();
        assert_eq!(
            notes,
            [
                "a.stl:5: what follows the coordinates of a vertex is not used",
                "a.stl:9: a line that is no statement of STL is not used",
                "a.stl:10: a solid begins before the `endsolid` of the one before it",
                "a.stl: the file ends without `endsolid`: it may have lost facets",
            ]
        );
        let doubled = format!("solid a\nsolid a\n{facet}endsolida\nendsolid\n{above}The end.\n").replace('\r', "\n");
        let scene = read(doubled.as_bytes()).unwrap();
        let notes: Vec<String> = scene.notes().iter().map(ToString::to_string).collect();
        assert_eq!((scene.faces().len(), scene.surfaces().len()), (2, 2));
        assert!(notes.iter().any(|note| note == "a.stl:12: a facet stands in no `solid`"), "{notes:?}");
        assert!(notes.iter().any(|note| note == "a.stl:19: a line that is no statement of STL is not used"), "{notes:?}");
        let latin: Vec<u8> = TEXT.replace("a b", "\u{1}").bytes().map(|byte| if byte == 1 { 0xe9 } else { byte }).collect();
        let utf_16: Vec<u8> = "\u{feff}".chars().chain(TEXT.chars()).flat_map(|c| (c as u16).to_le_bytes()).collect();
        for (content, name) in [(latin, "\u{e9}"), (utf_16, "a b")] {
            assert_eq!(read(&content).unwrap().surfaces()[0].name(), name);
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let cases = [
            ("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", "a.stl:4: expected a number (z), found `x`"),
            ("solid a\nvertex 0 0 0\n", "a.stl:2: expected `facet` or `endsolid`, found `vertex`"),
            ("solid a\nfacet\n", "a.stl: expected `endfacet` of the facet of line 2, found the end of the file"),
            ("solid a\n", "a.stl: expected at least one face, found none"),
            (
                "solid a\nfacet\nvertex 0 1,5 0\n",
                "a.stl:3: expected a number with a decimal point (y), found a decimal comma, `1,5`",
            ),
            ("solid a\nendsolid\n", "a.stl: expected at least one face, found none"),
        ];
        for (text, message) in cases {
            assert_eq!(read(text.as_bytes()).unwrap_err().to_string(), message);
        }
        let message = read(&bytes(&[[f32::NAN; 3]; 3])).unwrap_err().to_string();
        assert_eq!(message, "a.stl: triangles[0]: expected a finite number, found NaN");
        // No area.
        let message = read(&bytes(&[[0.0; 3]; 3])).unwrap_err().to_string();
        assert!(message.starts_with("a.stl: triangles[0]: expected at least one face, found none: "), "{message}");
    }
}
