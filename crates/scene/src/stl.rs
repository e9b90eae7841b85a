//! STL, as text or binary: triangles without materials, for form factors.
//!
//! The text has `solid NAME`, facets of `facet normal x y z`, `outer loop`, three `vertex x y z`, `endloop`, `endfacet`, and
//! `endsolid`; a file may have several solids, each of which is a surface. The binary form has 80 bytes of anything, the number of
//! triangles, and 50 bytes for each: a normal, three corners, single precision and little-endian, and two bytes of anything. A file is
//! binary if it is exactly as long as that. The order of the corners decides to which side a triangle is lit, not its normal. The
//! material is black: STL has none.

use std::path::Path;

use radgrad_core::DVec3;

use crate::scene::Intake;
use crate::words::{Words, decode, quoted, without_mark};
use crate::{Error, Position, Reading, Scene};

/// Length of the header of a binary file, the number of triangles included, and of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads a file.
///
/// # Errors
/// If it cannot be read, or something in it is wrong: with the line, or the triangle counted from 0.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let (intake, material) = Intake::of_mesh(file, reading.into())?;
    let content = crate::open(file, intake.budget())?;
    parse_within(&content, intake, material)
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
    parse_within(content, intake, material)
}

fn parse_within(content: &[u8], mut intake: Intake, material: usize) -> Result<Scene, Error> {
    match triangles(content) {
        Some(triangles) => binary(triangles, material, &mut intake)?,
        None => text(content, material, &mut intake)?,
    }
    intake.finish()
}

/// The triangles of a binary file.
fn triangles(content: &[u8]) -> Option<&[u8]> {
    let (header, triangles) = content.split_at_checked(HEADER)?;
    let count = u32::from_le_bytes(header[80..].try_into().ok()?);
    (triangles.len() as u64 == u64::from(count) * TRIANGLE as u64).then_some(triangles)
}

fn binary(triangles: &[u8], material: usize, intake: &mut Intake) -> Result<(), Error> {
    let surface = intake.surface("solid")?;
    for (index, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        let place = intake.place(Position::Member(format!("triangles[{index}]")));
        let mut numbers = triangle[12..48].chunks_exact(4).map(|bytes| {
            let number = f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
            if number.is_finite() { Ok(number) } else { Err(Error::expected("a finite number", number.to_string())) }
        });
        let mut next = || numbers.next().unwrap_or_else(|| Err(Error::expected("nine numbers", "fewer")));
        let mut corner = || Ok::<_, Error>(DVec3::new(next()?, next()?, next()?));
        let corners = (|| Ok(vec![corner()?, corner()?, corner()?]))().map_err(|error: Error| error.at(place.clone()))?;
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
    let mut reading = Open { solid: None, facet: None };
    for (index, line) in without_mark(content).split(|&byte| byte == b'\n').enumerate() {
        let place = intake.place(Position::Line(index + 1));
        let read = decode(line).and_then(|line| statement(Words::new(line), index + 1, material, &mut reading, intake));
        read.map_err(|error| if error.place().is_some() { error } else { error.at(place) })?;
    }
    if reading.solid.is_none() && reading.facet.is_none() {
        return Ok(());
    }
    Err(Error::expected("`endsolid`", "the end of the file").at(intake.place(Position::File)))
}

fn statement(mut words: Words<'_>, line: usize, material: usize, reading: &mut Open, intake: &mut Intake) -> Result<(), Error> {
    let Some(word) = words.next() else { return Ok(()) };
    match (word.to_ascii_lowercase().as_str(), &mut reading.solid, &mut reading.facet) {
        ("solid", solid @ None, _) => {
            let name = words.rest();
            *solid = Some(if name.is_empty() { "solid".to_owned() } else { name.to_owned() });
        }
        ("facet", Some(_), facet @ None) => *facet = Some((line, Vec::with_capacity(3))),
        ("outer" | "endloop", _, Some(_)) => {}
        ("vertex", _, Some((_, corners))) if corners.len() < 3 => {
            corners.push(DVec3::new(words.number("x")?, words.number("y")?, words.number("z")?));
            words.end()?;
        }
        ("endfacet", Some(name), Some((first, corners))) if corners.len() == 3 => {
            let (surface, place) = (intake.surface(name)?, intake.place(Position::Line(*first)));
            intake.add_face(surface, material, std::mem::take(corners), place)?;
            reading.facet = None;
        }
        ("endsolid", solid @ Some(_), None) => *solid = None,
        _ => {
            let next = match (&reading.solid, &reading.facet) {
                (None, _) => "`solid`, or the length of a binary file",
                (Some(_), None) => "`facet` or `endsolid`",
                (Some(_), Some((_, corners))) if corners.len() < 3 => "`vertex`",
                _ => "`endloop` or `endfacet`",
            };
            return Err(Error::expected(next, quoted(Some(word))));
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
        assert!(short.starts_with("a.stl:1: "), "{short}");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let cases = [
            ("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", "a.stl:4: expected a number (z), found `x`"),
            ("solid a\nvertex 0 0 0\n", "a.stl:2: expected `facet` or `endsolid`, found `vertex`"),
            ("solid a\n", "a.stl: expected `endsolid`, found the end of the file"),
            ("solid a\nendsolid\n", "a.stl: expected at least one face, found none"),
        ];
        for (text, message) in cases {
            assert_eq!(read(text.as_bytes()).unwrap_err().to_string(), message);
        }
        let message = read(&bytes(&[[f32::NAN; 3]; 3])).unwrap_err().to_string();
        assert_eq!(message, "a.stl: triangles[0]: expected a finite number, found NaN");
        // No area.
        let message = read(&bytes(&[[0.0; 3]; 3])).unwrap_err().to_string();
        assert!(message.starts_with("a.stl: triangles[0]: face refused: "), "{message}");
    }
}
