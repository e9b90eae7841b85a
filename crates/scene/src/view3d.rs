//! Input files of `View3D` (G. N. Walton, NIST), `.vs3`, and its matrices of view factors as text.
//!
//! The first letter of a line tells its kind, in either case: `T` title, `C` control, `F` kind of geometry, `V` vertex, `S`
//! surface, `O` obstruction, `N` null surface; `E` or `*` ends the data, and must be there; `!` and `/` start a comment before any
//! word. Surfaces have numbers, in sequence from 1. Of the control line only `encl` is used ([`Scene::enclosure`]): the rest steers
//! the integration of that program. Geometry is `F 3`, surfaces through numbered vertices, or `F 3a`, shapes in planes given by a
//! corner, azimuth and tilt; which of the two a surface is shows in its line.
//!
//! - A surface is lit on the side from which its vertices are counter-clockwise. Its one channel is `grey`, its reflectance is 1
//!   less the emittance, its radiance 0: these files say nothing of temperatures. A triangle has 0 for its fourth
//!   vertex.
//! - `cmb` makes a surface part of an earlier one: both are faces of one [`crate::Surface`].
//! - `base` makes it a subsurface, such as a window: the base is cut around it, so that no area counts twice.
//! - A null surface only cuts its base, and hides the surfaces behind it. A masking surface, `M`, is refused: light between it and
//!   the surface it covers crosses no gap.
//! - An obstruction hides and has no row in a matrix.
//!
//! A vertex that is no three numbers is refused where a surface uses it.
//!
//! The format is described in the user manual of `View3D` 3.3.

mod cut;
mod matrix;
mod shape;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use radgrad_core::{DVec3, Polygon};

pub use self::matrix::{MatrixHeader, write_matrix};
use self::shape::{data_of, is_separator};
use crate::error::Error;
use crate::messages::quoted;
use crate::place::{Place, Position};
use crate::reading::{Budget, Reading};
use crate::scene::Scene;
use crate::scene::intake::Intake;
use crate::scene::vertices::Vertices;
use crate::words::{Words, lines};

/// Reads a file.
///
/// # Errors
/// If the file cannot be read, or breaks the format: with file, line and the expected value.
pub fn read(file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    let budget = Budget::new(reading.budget);
    parse_within(&crate::reading::open(file, &budget)?, Intake::new(Scene::new(["grey"])?, file, reading, &budget))?.finish()
}

/// Reads the text of a file. `file` is its name in messages.
///
/// ```
/// use std::path::Path;
/// use radgrad_scene::{Degenerate, view3d};
/// let text = "T two squares\nF 3\n\
///             V 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nV 5 0 0 1\nV 6 1 0 1\nV 7 1 1 1\nV 8 0 1 1\n\
///             ! #  v1 v2 v3 v4  base cmb emit name\n\
///             S 1   1  2  3  4     0   0 0.90 bottom\n\
///             S 2   8  7  6  5     0   0 0.90 top\n\
///             End of data\n";
/// let scene = view3d::parse(text.as_bytes(), Path::new("squares.vs3"), Degenerate::Refuse)?;
/// assert_eq!((scene.title(), scene.surfaces()[1].name()), (Some("two squares"), "top"));
/// assert_eq!(scene.materials()[0].reflectance(), [1.0 - 0.9]);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn parse(text: &[u8], file: &Path, reading: impl Into<Reading>) -> Result<Scene, Error> {
    let reading = reading.into();
    parse_within(text, Intake::new(Scene::new(["grey"])?, file, reading, &Budget::new(reading.budget)))?.finish()
}

fn parse_within(text: &[u8], mut intake: Intake) -> Result<Intake, Error> {
    let file = intake.file();
    let text = intake.decode(text, &file)?;
    let mut reader = Reader { intake, vertices: Vertices::default(), elements: Vec::new() };
    let mut lines = lines(&text).enumerate().map(|(index, line)| (index + 1, line));
    while let Some((number, line)) = lines.next() {
        let place = reader.intake.place(Position::Line(number));
        match reader.line(data_of(line), &place, &mut lines) {
            Ok(true) => {}
            Ok(false) => return reader.into_intake(),
            Err(error) => return Err(if error.place().is_some() { error } else { error.at_place(place) }),
        }
    }
    // Without its end a file may have lost surfaces.
    Err(Error::expected("a line `End of data`", "the end of the file").at_place(reader.intake.place(Position::File)))
}

/// The role of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Radiating,
    Obstruction,
    Null,
}

/// A surface as described, and the polygon it has before anything is cut out of it.
struct Element {
    kind: Kind,
    place: Place,
    vertices: Vec<DVec3>,
    /// Numbers, from 1; 0 for none.
    base: usize,
    combined_with: usize,
    emittance: f64,
    name: String,
}

struct Reader {
    intake: Intake,
    vertices: Vertices,
    elements: Vec<Element>,
}

impl Reader {
    /// Reads a line, and those after it that belong to it; false at the end of the data.
    fn line<'a>(&mut self, data: &str, place: &Place, lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Result<bool, Error> {
        let mut words = Words::separated(data, is_separator);
        let Some(word) = words.next() else { return Ok(true) };
        match word.as_bytes()[0].to_ascii_uppercase() {
            b'E' | b'*' => return Ok(false),
            b'T' => self.intake.set_title(words.remainder().to_owned()),
            b'C' => self.control(words, place)?,
            b'F' => geometry(words)?,
            b'V' => self.vertex(words, place)?,
            b'S' => self.element(Kind::Radiating, words, place, lines)?,
            b'O' => self.element(Kind::Obstruction, words, place, lines)?,
            b'N' => self.element(Kind::Null, words, place, lines)?,
            b'M' => {
                let instead = "leave it and what it covers out, or put a gap between them";
                return Err(Error::Unsupported { what: "a masking surface".to_owned(), instead });
            }
            _ => return Err(Error::expected("a line of T, C, F, V, S, O, N or E", quoted(Some(word)))),
        }
        Ok(true)
    }

    /// Pairs of name and value, such as `encl=1`.
    fn control(&mut self, words: Words<'_>, place: &Place) -> Result<(), Error> {
        let mut words = Words::separated(words.remainder(), |c| is_separator(c) || c == '=');
        while let Some(name) = words.next() {
            let value = words.next();
            match name.to_ascii_lowercase().as_str() {
                "encl" => match value {
                    Some("0") => self.intake.set_enclosure(false),
                    Some("1") => self.intake.set_enclosure(true),
                    // The program asks only whether it is 0.
                    Some(other) if other.parse::<i64>().is_ok() => {
                        self.intake.ignore(place.clone(), format!("encl={other} is taken as encl=1"));
                        self.intake.set_enclosure(true);
                    }
                    _ => return Err(Error::expected("encl=0 or encl=1", quoted(value))),
                },
                "eps" | "epsu" | "epso" | "maxu" | "maxo" | "mino" | "row" | "col" | "emit" | "out" | "list" | "prjd" => {}
                _ => self.intake.ignore(place.clone(), format!("unknown control word {} is not used", quoted(Some(name)))),
            }
        }
        Ok(())
    }

    fn vertex(&mut self, mut words: Words<'_>, place: &Place) -> Result<(), Error> {
        next_in_sequence("vertex", words.integer("number of the vertex")?, self.vertices.len())?;
        let read = words.coordinates(["x", "y", "z"]).map_err(|error| error.at_place(place.clone()));
        if read.is_ok() && !words.is_empty() {
            self.intake.ignore(place.clone(), "what follows the coordinates of a vertex is not used".to_owned());
        }
        self.vertices.push(read, &self.intake)
    }

    fn element<'a>(
        &mut self,
        kind: Kind,
        mut words: Words<'_>,
        place: &Place,
        lines: &mut impl Iterator<Item = (usize, &'a str)>,
    ) -> Result<(), Error> {
        next_in_sequence("surface", words.integer("number of the surface")?, self.elements.len())?;
        let shape = words.clone().next().and_then(shape::Shape::named);
        let mut vertices = Vec::with_capacity(4);
        if shape.is_some() {
            words.next();
        } else {
            for corner in 1..=4 {
                let number = words.integer(&format!("number of vertex {corner}, or a shape R, Q or T"))?;
                if corner < 4 || number != 0 {
                    vertices.push(self.numbered_vertex(number)?);
                }
            }
        }
        let number = self.elements.len() + 1;
        let mut element =
            Element { kind, place: place.clone(), vertices, base: 0, combined_with: 0, emittance: 1.0, name: number.to_string() };
        // An obstruction may end here.
        if kind != Kind::Obstruction || !words.is_empty() {
            self.properties(&mut element, words)?;
        }
        if let Some(shape) = shape {
            element.vertices = shape.vertices(lines, &mut self.intake)?;
        }
        let size = 2 * size_of::<Element>() + 4 * size_of::<DVec3>() + element.name.len();
        self.intake.budget().take_many("surfaces", 1, size)?;
        self.elements.push(element);
        Ok(())
    }

    fn numbered_vertex(&mut self, number: i64) -> Result<DVec3, Error> {
        let place = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
        let vertex = place.map(|place| self.vertices.corner(place, &mut self.intake)).transpose()?;
        vertex.flatten().ok_or_else(|| {
            Error::expected(format!("a vertex from 1 to {}, those before this line", self.vertices.len()), number.to_string())
        })
    }

    /// Base, combination, emittance and name.
    fn properties(&mut self, element: &mut Element, mut words: Words<'_>) -> Result<(), Error> {
        let earlier = self.elements.len();
        let mut number = |what: &'static str| -> Result<usize, Error> {
            let number = words.integer(what)?;
            usize::try_from(number).ok().filter(|&number| number <= earlier).ok_or_else(|| {
                Error::expected(format!("an earlier surface, 1 to {earlier}, or 0 for none ({what})"), number.to_string())
            })
        };
        let (base, combined_with) = (number("base")?, number("cmb")?);
        match (element.kind, base) {
            (Kind::Null, 0) => return Err(Error::expected("the base of a null surface", "0")),
            (Kind::Obstruction, 1..) => return Err(Error::expected("0, since an obstruction has no base", base.to_string())),
            _ => {}
        }
        if base > 0 && self.elements[base - 1].kind == Kind::Null {
            return Err(Error::expected("a base that is not a null surface", base.to_string()));
        }
        if combined_with > 0 {
            let first = &self.elements[combined_with - 1];
            if first.combined_with > 0 || first.kind != Kind::Radiating || element.kind != Kind::Radiating {
                return Err(Error::expected("a radiating surface that is not combined itself (cmb)", combined_with.to_string()));
            }
        }
        let emittance = words.number("emittance").and_then(|emittance| {
            let fault = || Error::expected("an emittance between 0 and 1", emittance.to_string());
            if (0.0..=1.0).contains(&emittance) { Ok(emittance) } else { Err(fault()) }
        });
        let emittance = match emittance {
            Err(error) if !self.intake.needs_materials() => {
                self.intake.ignore_fault(error.at_place(element.place.clone()), "taken as black");
                1.0
            }
            emittance => emittance?,
        };
        (element.base, element.combined_with, element.emittance) = (base, combined_with, emittance);
        if let Some(name) = words.next() {
            name.clone_into(&mut element.name);
        }
        Ok(())
    }

    fn into_intake(self) -> Result<Intake, Error> {
        let Self { mut intake, vertices, elements } = self;
        vertices.note_faults(&mut intake);
        let mut surfaces: Vec<usize> = Vec::with_capacity(elements.len());
        let mut materials: HashMap<u64, usize> = HashMap::new();
        let mut subsurfaces: Vec<Vec<&Element>> = vec![Vec::new(); elements.len()];
        for element in elements.iter().filter(|element| element.base > 0) {
            subsurfaces[element.base - 1].push(element);
        }
        for (index, element) in elements.iter().enumerate() {
            let surface = match (element.kind, element.combined_with) {
                (Kind::Radiating, 0) => intake.add_surface(&element.name, true)?,
                (Kind::Radiating, earlier) => surfaces[earlier - 1],
                (Kind::Obstruction | Kind::Null, _) => intake.add_surface(&element.name, false)?,
            };
            surfaces.push(surface);
            let material = match materials.entry(element.emittance.to_bits()) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    let name = format!("emittance {}", element.emittance);
                    *new.insert(intake.add_material(&name, &[1.0 - element.emittance], &[0.0])?)
                }
            };
            if subsurfaces[index].is_empty() {
                intake.add_face(surface, material, element.vertices.clone(), element.place.clone())?;
                continue;
            }
            for piece in remainder(index + 1, element, &subsurfaces[index], intake.budget())? {
                intake.add_face(surface, material, piece, element.place.clone())?;
            }
        }
        Ok(intake)
    }
}

/// The rest of a base without its subsurfaces. A null surface faces its base, the others face as it does.
fn remainder(number: usize, base: &Element, subsurfaces: &[&Element], budget: &Budget) -> Result<Vec<Vec<DVec3>>, Error> {
    let polygon =
        |element: &Element| Polygon::new(element.vertices.clone()).map_err(|e| Error::Face(e).at_place(element.place.clone()));
    let whole = polygon(base)?;
    let mut remainder = cut::Remainder::whole(number, &whole).map_err(|error| error.at_place(base.place.clone()))?;
    for subsurface in subsurfaces {
        let cut = remainder.without(&polygon(subsurface)?, subsurface.kind == Kind::Null);
        cut.map_err(|error| error.at_place(subsurface.place.clone()))?;
        budget.take_many("parts of a base", remainder.count(), size_of::<Vec<DVec3>>())?;
    }
    Ok(remainder.pieces())
}

fn geometry(mut words: Words<'_>) -> Result<(), Error> {
    match words.next() {
        Some("3" | "3a" | "3A") => Ok(()),
        other => Err(Error::expected("a geometry of three dimensions, F 3 or F 3a", quoted(other))),
    }
}

fn next_in_sequence(what: &str, number: i64, before: usize) -> Result<(), Error> {
    if usize::try_from(number) == Ok(before + 1) {
        return Ok(());
    }
    Err(Error::expected(format!("{what} {}, the next in sequence", before + 1), number.to_string()))
}
