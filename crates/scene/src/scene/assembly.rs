//! From the faces of a file to those of a scene.
//!
//! Vertices that repeat their predecessor are left out, and so are faces without area: they exchange nothing. Where the coordinates of the
//! file are rounded, vertices are moved back onto the planes that they were on ([`healing`]), and faces thinner than the rounding are
//! without area too. A face that is flat to the rounding stays whole; one that is not is split into triangles; a hole that is reached
//! along a bridge is cut there. All of this is noted.

use radgrad_core::{DVec3, Polygon};

use super::healing::weld;
use super::keyhole::keyhole;
use super::note::Note;
use super::outline::{Given, Outline, take_face};
use super::{Scene, split};
use crate::error::Error;
use crate::extremes::{largest, smallest};
use crate::occluders::overlap::perimeter;
use crate::place::Place;
use crate::reading::{Budget, Degenerate};

/// The part of a scene that faces are added to.
#[derive(Debug)]
pub(super) struct Assembly<'a> {
    pub(super) scene: &'a mut Scene,
    pub(super) budget: &'a Budget,
    pub(super) degenerate: Degenerate,
}

/// Faces or vertices of one fate: the first, and how many there are.
#[derive(Debug, Default)]
struct Tally {
    first: Option<(Place, Reason)>,
    count: usize,
}

/// Why something was left out.
type Reason = Option<radgrad_core::Error>;

impl Tally {
    fn add(&mut self, place: &Place, reason: impl FnOnce() -> Reason) {
        self.count += 1;
        if self.first.is_none() {
            self.first = Some((place.clone(), reason()));
        }
    }
}

impl Assembly<'_> {
    /// Adds the faces of a file, whose coordinates are rounded by at most this.
    pub(super) fn add(&mut self, mut given: Vec<Given>, rounding: f64) -> Result<(), Error> {
        self.scene.modelling.precision = rounding;
        if let Some((face, error)) = given.iter().find_map(|face| Some((face, not_finite(&face.outline.vertices)?))) {
            return Err(Error::Face(error).at_place(face.place.clone()));
        }
        let mut welded = weld(given.iter().map(|face| &face.outline.vertices[..]), rounding);
        let (mut repeated, mut left_out, mut moved) = (Tally::default(), Tally::default(), Moved::default());
        for (index, face) in given.iter_mut().enumerate() {
            let distinct = without_repeated(welded.face(index));
            if distinct.len() < face.outline.vertices.len() {
                repeated.add(&face.place, || None);
                face.outline = face.outline.part(&distinct);
                welded.keep(index, &distinct);
            }
        }
        let widths: Vec<f64> = (0..given.len()).map(|face| welded.width(face)).collect();
        welded.flatten(rounding);
        for (index, face) in given.into_iter().enumerate() {
            let Given { surface, material, mut outline, place } = face;
            let from = std::mem::replace(&mut outline.vertices, welded.outline(index));
            // As given, and as it is now.
            let (around, width) = (perimeter(&outline.vertices), smallest(widths[index], 2.0 * welded.width(index)));
            if outline.vertices.len() < 3 || width < rounding {
                let reason = || Polygon::new(outline.vertices.clone()).err();
                left_out.add(&place, reason);
                moved.swept += 0.5 * around * width;
                continue;
            }
            let farthest = from.iter().zip(&outline.vertices).map(|(from, to)| (*from - *to).length()).fold(0.0, largest);
            moved.add(farthest, around, &place);
            let faces = self.scene.faces.len();
            match self.add_outline(surface, material, outline, &place, rounding) {
                Ok(()) => self.scene.faces[faces..].iter_mut().for_each(|face| face.moved = farthest),
                Err(Refused::WithoutArea(reason)) => left_out.add(&place, || Some(reason)),
                Err(Refused::Because(error)) => return Err(error),
            }
        }
        self.scene.modelling.distance = moved.farthest.as_ref().map_or(0.0, |(distance, _)| *distance);
        let area: f64 = self.scene.polygons().map(Polygon::area).sum();
        self.scene.modelling.share = if moved.swept > 0.0 { moved.swept / (area + moved.swept) } else { 0.0 };
        if let Some((distance, place)) = moved.farthest {
            self.note(Note::Healed { place, faces: moved.faces, distance, precision: rounding })?;
        }
        if let Some((place, _)) = repeated.first {
            self.note(Note::RepeatedVertices { place, faces: repeated.count })?;
        }
        if let Some((place, reason)) = left_out.first {
            self.note(Note::LeftOut { place, faces: left_out.count, reason, precision: rounding })?;
        }
        Ok(())
    }

    fn note(&mut self, note: Note) -> Result<(), Error> {
        self.budget.take_many("notes", 1, 2 * size_of::<Note>() + 256)?;
        self.scene.notes.push(note);
        Ok(())
    }

    /// Adds the polygon of an outline, or the parts that it has to be split into.
    fn add_outline(
        &mut self,
        surface: usize,
        material: usize,
        outline: Outline,
        place: &Place,
        rounding: f64,
    ) -> Result<(), Refused> {
        let polygon = match polygon(&outline.vertices, rounding) {
            Ok(polygon) => polygon,
            Err(error @ radgrad_core::Error::NotPlanar { distance, size, .. }) => {
                let Some(split) = split::triangles(&outline.vertices) else { return self.refuse(error, place, Error::Warped) };
                let triangles = self.add_triangles(surface, material, &outline, &split, place)?;
                let surface = self.scene.surfaces[surface].name.clone();
                return Ok(self.note(Note::Split { place: place.clone(), surface, triangles, distance, size })?);
            }
            Err(error @ radgrad_core::Error::ZeroArea { .. }) => return Err(Refused::WithoutArea(error)),
            Err(error @ radgrad_core::Error::NotSimple { .. }) => {
                let parts = keyhole(&outline.vertices, rounding).filter(|_| outline.coordinates.iter().all(Option::is_none));
                let Some(parts) = parts else { return self.refuse(error, place, Error::Face) };
                return Ok(self.add_parts(surface, material, parts, place)?);
            }
            Err(error) => return self.refuse(error, place, Error::Face),
        };
        match outline.charts(&polygon) {
            Ok(charts) => {
                let added = self.scene.add_charted_face(surface, material, polygon, Some(place.clone()), charts);
                added.map_err(|error| error.at_place(place.clone()))?;
            }
            Err(Error::Chart { off, .. }) => {
                let Some(split) = split::triangles(&outline.vertices) else {
                    let error = Error::expected("a face that can be cut into triangles", "one that touches itself");
                    return Err(error.at_place(place.clone()).into());
                };
                let triangles = self.add_triangles(surface, material, &outline, &split, place)?;
                let surface = self.scene.surfaces[surface].name.clone();
                self.note(Note::SplitForTexture { place: place.clone(), surface, triangles, off })?;
            }
            Err(error) => return Err(error.at_place(place.clone()).into()),
        }
        Ok(())
    }

    /// Adds the parts of a face that comes back to a vertex of its own.
    fn add_parts(&mut self, surface: usize, material: usize, parts: Vec<Vec<DVec3>>, place: &Place) -> Result<(), Error> {
        let (count, name) = (parts.len(), self.scene.surfaces[surface].name.clone());
        for part in parts {
            take_face(self.budget, part.len()).map_err(|error| error.at_place(place.clone()))?;
            let polygon = Polygon::new(part).map_err(|error| Error::Face(error).at_place(place.clone()))?;
            self.scene
                .add_face(surface, material, polygon, Some(place.clone()))
                .map_err(|error| error.at_place(place.clone()))?;
        }
        self.note(Note::Bridged { place: place.clone(), surface: name, parts: count })
    }

    /// Adds triangles of an outline and returns how many there are.
    fn add_triangles(
        &mut self,
        surface: usize,
        material: usize,
        outline: &Outline,
        split: &[[usize; 3]],
        place: &Place,
    ) -> Result<usize, Error> {
        for triangle in split {
            take_face(self.budget, 3).map_err(|error| error.at_place(place.clone()))?;
            let part = outline.part(triangle);
            let polygon = Polygon::new(part.vertices.clone()).map_err(|error| Error::Face(error).at_place(place.clone()))?;
            let charts = part.charts(&polygon).map_err(|error| error.at_place(place.clone()))?;
            let added = self.scene.add_charted_face(surface, material, polygon, Some(place.clone()), charts);
            added.map_err(|error| error.at_place(place.clone()))?;
        }
        Ok(split.len())
    }

    fn refuse(
        &mut self,
        error: radgrad_core::Error,
        place: &Place,
        fault: fn(radgrad_core::Error) -> Error,
    ) -> Result<(), Refused> {
        match self.degenerate {
            Degenerate::Refuse => Err(fault(error).at_place(place.clone()).into()),
            Degenerate::Drop => Err(Refused::WithoutArea(error)),
        }
    }
}

/// Why a face was not added.
enum Refused {
    /// It is left out.
    WithoutArea(radgrad_core::Error),
    /// The file is refused.
    Because(Error),
}

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Self::Because(error)
    }
}

/// How far vertices were moved.
#[derive(Debug, Default)]
struct Moved {
    farthest: Option<(f64, Place)>,
    faces: usize,
    /// The area that edges sweep, at most.
    swept: f64,
}

impl Moved {
    fn add(&mut self, distance: f64, perimeter: f64, place: &Place) {
        if distance > 0.0 {
            self.faces += 1;
            self.swept += distance * perimeter;
            if self.farthest.as_ref().is_none_or(|(farthest, _)| distance > *farthest) {
                self.farthest = Some((distance, place.clone()));
            }
        }
    }
}

/// The polygon of an outline, which may be flat, or simple, to the rounding alone. One that comes back to a vertex of its own is
/// no such.
fn polygon(vertices: &[DVec3], rounding: f64) -> Result<Polygon, radgrad_core::Error> {
    use radgrad_core::Error::{NotPlanar, NotSimple};
    match Polygon::new(vertices.to_vec()) {
        Err(NotPlanar { .. }) if rounding > 0.0 => Polygon::from_rounded(vertices.to_vec(), rounding),
        Err(NotSimple { .. }) if rounding > 0.0 && keyhole(vertices, rounding).is_none() => {
            Polygon::from_rounded(vertices.to_vec(), rounding)
        }
        other => other,
    }
}

fn not_finite(vertices: &[DVec3]) -> Option<radgrad_core::Error> {
    let index = vertices.iter().position(|v| !v.is_finite())?;
    Some(radgrad_core::Error::VertexNotFinite { index, value: vertices[index] })
}

/// Places of the vertices of a face that are kept: none that is its predecessor again, and no edge that is run back at once.
fn without_repeated(vertices: &[usize]) -> Vec<usize> {
    let mut distinct: Vec<usize> = Vec::with_capacity(vertices.len());
    let vertex = |place: usize| vertices[place];
    for place in 0..vertices.len() {
        distinct.push(place);
        loop {
            let count = distinct.len();
            if count > 1 && vertex(distinct[count - 1]) == vertex(distinct[count - 2]) {
                distinct.pop();
            } else if count > 2 && vertex(distinct[count - 1]) == vertex(distinct[count - 3]) {
                distinct.truncate(count - 2);
            } else {
                break;
            }
        }
    }
    // The same where the last meets the first.
    loop {
        let count = distinct.len();
        if count > 1 && vertex(distinct[0]) == vertex(distinct[count - 1]) {
            distinct.pop();
        } else if count > 2 && vertex(distinct[0]) == vertex(distinct[count - 2]) {
            distinct.truncate(count - 2);
        } else if count > 2 && vertex(distinct[1]) == vertex(distinct[count - 1]) {
            distinct.drain(..2);
        } else {
            return distinct;
        }
    }
}
