//! All elements of a scene, and the faces that lie between them.

pub(crate) mod basis;
pub(crate) mod clusters;
pub(crate) mod contact;
pub(crate) mod element;
pub(crate) mod glow;
pub(crate) mod outline;
pub(crate) mod overlap;
pub(crate) mod partition;
mod remainder;
pub(crate) mod rule;
pub(crate) mod screen;
pub(crate) mod shadow;
pub(crate) mod shape;
pub(crate) mod surfaces;
pub(crate) mod texture;

use radgrad_core::{DVec3, Polygon, Receiver};
use radgrad_scene::{Beam, Boxes, Occluders, Scene, largest, smallest, triangulate};

use crate::bytes::Bytes;
use crate::error::Error;
use crate::mesh::basis::Basis;
use crate::mesh::clusters::Clusters;
use crate::mesh::element::{Element, around};
use crate::mesh::outline::{Cut, Given, LARGE, MOST_SLICES, is_long, slices, with_parallelogram};
use crate::mesh::screen::Screen;
use crate::mesh::shape::Shape;

/// The trees of elements over the faces of a scene.
///
/// ```
/// use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::Mesh;
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let mut mesh = Mesh::new(&scene, 1)?;
/// let before = mesh.leaves().count();
/// mesh.divide(0)?;
/// assert_eq!(mesh.leaves().count(), before + 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Mesh {
    polygons: Vec<Polygon>,
    /// Whether a face exchanges light, or only hides others.
    exchanges: Vec<bool>,
    /// Whether it emits.
    emits: Vec<bool>,
    /// Convex parts of each polygon.
    convex: Vec<Vec<Vec<DVec3>>>,
    /// The same as occluders.
    screens: Vec<Vec<Screen>>,
    index: Occluders,
    /// The faces near a place.
    boxes: Boxes,
    bases: [Basis; 2],
    elements: Vec<Element>,
    roots: Vec<usize>,
    clusters: Clusters,
    /// The elements that each face was first cut into.
    roots_of_face: Vec<Vec<usize>>,
    /// How faces were first cut.
    given: Given,
}

/// A point's or an element's sight of a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Nothing: one of them is behind the other, or this face hides all of it.
    Nothing(Option<usize>),
    /// Nothing is between them.
    Clear,
    /// These faces may be.
    Past(Vec<usize>),
}

impl Bytes for Sight {
    fn put(&self, to: &mut Vec<u8>) {
        match self {
            Self::Nothing(face) => (0_usize, *face).put(to),
            Self::Clear => 1_usize.put(to),
            Self::Past(faces) => {
                2_usize.put(to);
                faces.put(to);
            }
        }
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        match usize::take(from)? {
            0 => Bytes::take(from).map(Self::Nothing),
            1 => Some(Self::Clear),
            2 => Bytes::take(from).map(Self::Past),
            _ => None,
        }
    }
}

impl Sight {
    /// The faces that may be between.
    pub(crate) fn faces(&self) -> &[usize] {
        if let Self::Past(faces) = self { faces } else { &[] }
    }
}

/// A point is at a face within this fraction of the scene's extent.
pub(crate) const TOUCHES: f64 = 1e-9;

impl Mesh {
    /// The coarsest elements, with bases of a degree.
    ///
    /// # Errors
    /// If a face cannot be cut into triangles.
    pub fn new(scene: &Scene, degree: usize) -> Result<Self, Error> {
        Self::cut(scene, degree, Cut::Few)
    }

    /// The same of faces that are cut in some way. Those that others stand on are cut along their feet before, those without parts are
    /// cut as by [`Self::new`].
    pub(crate) fn cut(scene: &Scene, degree: usize, cut: Cut<'_>) -> Result<Self, Error> {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, degree));
        let polygons: Vec<Polygon> = scene.polygons().cloned().collect();
        let exchanges: Vec<bool> = scene.faces().iter().map(|face| scene.surfaces()[face.surface()].exchanges()).collect();
        let convex = polygons.iter().enumerate().map(|(face, polygon)| convex_parts(polygon).ok_or(Error::Face { face }));
        let convex = convex.collect::<Result<Vec<_>, Error>>()?;
        let boxes: Vec<[DVec3; 2]> = polygons.iter().map(|polygon| around(polygon.vertices())).collect();
        // Those that are far away stand on nothing, and hang over nothing closely.
        let close = if matches!(cut, Cut::Few) { contact::CLOSE } else { 0.0 };
        let index = Boxes::new(&boxes.iter().map(|sides| widened(sides, close)).collect::<Vec<_>>());
        let others = |face: usize, close: f64| {
            let [low, high] = boxes[face];
            let own = 1e-6 * (high - low).max_element();
            let meets = move |[from, to]: &[DVec3; 2]| {
                let reach = DVec3::splat(largest(own, close * (*to - *from).max_element()));
                from.cmple(high + reach).all() && to.cmpge(low - reach).all()
            };
            let near = index.near([low - own, high + own]).into_iter();
            let boxes = &boxes;
            near.filter(move |&other| other != face && meets(&boxes[other])).map(|other| &polygons[other])
        };
        // Long faces are cut into parts where no face meets another and parts are few.
        let count = |polygon: &Polygon| slices(polygon.vertices()).map_or(1, |slices| slices.len());
        let slices_are_few = polygons.len() <= MOST_SLICES
            && polygons.iter().map(count).sum::<usize>() <= MOST_SLICES
            && (0..polygons.len()).all(|face| others(face, 0.0).next().is_none());
        let area: f64 = polygons.iter().map(Polygon::area).sum();
        let (mut elements, mut roots_of_face) = (Vec::new(), vec![Vec::new(); polygons.len()]);
        for (face, polygon) in polygons.iter().enumerate().filter(|(face, _)| exchanges[*face]) {
            let is_shortened = matches!(cut, Cut::Few) && is_long(polygon.vertices()) && polygon.area() >= LARGE * area;
            let sliced = (is_shortened || slices_are_few).then(|| slices(polygon.vertices())).flatten();
            let whole = sliced.as_ref().filter(|_| is_shortened).unwrap_or(&convex[face]);
            let by_feet = || contact::cut(polygon, whole, others(face, close), close);
            let squares = || {
                let parts = by_feet().unwrap_or_else(|| convex[face].clone()).into_iter();
                let parallelograms =
                    parts.flat_map(|part| with_parallelogram(&part, polygon.normal()).unwrap_or_else(|| vec![part]));
                parallelograms.flat_map(|part| slices(&part).unwrap_or_else(|| vec![part])).collect()
            };
            let given = match cut {
                Cut::Few => None,
                Cut::Squares => Some(squares()),
                Cut::Parts(parts) => parts.get(face).filter(|parts| !parts.is_empty()).cloned(),
            };
            let parts = given.or_else(by_feet);
            let of_face = match parts.or(sliced) {
                None => Element::of_face(polygon, face, &bases)?,
                Some(parts) => {
                    let mut elements = Vec::new();
                    for part in parts {
                        let part = Polygon::new(part).map_err(|source| Error::Element { face, source })?;
                        elements.extend(Element::of_face(&part, face, &bases)?);
                    }
                    elements
                }
            };
            roots_of_face[face] = (elements.len()..elements.len() + of_face.len()).collect();
            elements.extend(of_face);
        }
        let roots = (0..elements.len()).collect();
        let emits: Vec<bool> = scene
            .faces()
            .iter()
            .map(|face| scene.materials()[face.material()].radiance().iter().any(|radiance| *radiance > 0.0))
            .collect();
        let clusters = Clusters::over(&elements, &emits);
        let screens = convex.iter().zip(&polygons);
        let screens = screens.map(|(parts, of)| parts.iter().map(|part| Screen::new(part, of.normal())).collect()).collect();
        Ok(Self {
            clusters,
            screens,
            index: Occluders::new(&polygons),
            boxes: index,
            convex,
            polygons,
            exchanges,
            emits,
            bases,
            elements,
            roots,
            roots_of_face,
            given: cut.given(),
        })
    }

    /// All elements, divided or not; an element is named by its index.
    #[must_use]
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// The elements that are no part of another.
    #[must_use]
    pub fn roots(&self) -> &[usize] {
        &self.roots
    }

    /// Indices of the elements that are not divided.
    pub fn leaves(&self) -> impl Iterator<Item = usize> {
        (0..self.elements.len()).filter(|&e| self.elements[e].is_leaf())
    }

    /// An element and those above it, up to the one without a parent.
    pub(crate) fn above(&self, element: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(element), |&at| self.elements[at].parent())
    }

    /// The basis of an element.
    #[must_use]
    pub fn basis(&self, element: usize) -> &Basis {
        &self.bases[usize::from(self.elements[element].shape() == Shape::Triangle)]
    }

    /// Those of parallelograms and of triangles.
    pub(crate) const fn bases(&self) -> &[Basis; 2] {
        &self.bases
    }

    /// Polygons of the faces.
    #[must_use]
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// Clusters of the roots.
    pub(crate) const fn clusters(&self) -> &Clusters {
        &self.clusters
    }

    /// Of grey faces.
    #[cfg(test)]
    pub(crate) fn of_faces(faces: &[Vec<[f64; 3]>], degree: usize) -> Self {
        let mut scene = Scene::new(["grey"]).unwrap();
        let (grey, surface) = (scene.add_material("grey", [0.5], [0.0]).unwrap(), scene.add_surface("all"));
        for corners in faces {
            let polygon = Polygon::new(corners.iter().copied().map(DVec3::from).collect()).unwrap();
            scene.add_face(surface, grey, polygon, None).unwrap();
        }
        Self::new(&scene, degree).unwrap()
    }

    /// With clusters though it has few elements.
    #[cfg(test)]
    pub(crate) fn clustered(mut self) -> Self {
        self.cluster();
        self
    }

    /// Puts the coarsest elements into clusters though they are few.
    pub(crate) fn cluster(&mut self) {
        self.clusters = Clusters::always_over(&self.elements[..self.roots.len()], &self.emits);
    }

    /// The face that a ray meets first, of faces but for some, and where; nothing if it meets that from behind.
    pub(crate) fn front_met(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<(usize, DVec3)> {
        self.index.first_front_along(from, toward, leave_out)
    }

    /// The cluster of the one element that a ray meets first, of faces but for one; nothing if it meets that from behind.
    pub(crate) fn met(&self, from: DVec3, toward: DVec3, leave_out: Option<usize>) -> Option<usize> {
        let (face, point) = self.front_met(from, toward, leave_out.as_slice())?;
        let excess = |root: &usize| self.elements[*root].excess(self.elements[*root].reference(point));
        let nearest = match &self.roots_of_face[face][..] {
            [root] => Some(root),
            roots => roots.iter().min_by(|a, b| excess(a).total_cmp(&excess(b))),
        };
        nearest.map(|&root| self.clusters.single(root))
    }

    /// Which child of its parent an element is.
    pub(crate) fn child(&self, element: usize) -> usize {
        self.elements[element].parent().and_then(|parent| self.elements[parent].children()).map_or(0, |first| element - first)
    }

    /// All area.
    pub(crate) fn area(&self) -> f64 {
        self.roots.iter().map(|&root| self.elements[root].area()).sum()
    }

    /// Mean over all area of a quantity with this mean on each root.
    pub(crate) fn mean(&self, of_root: impl Fn(usize) -> f64) -> f64 {
        let sum = |(area, sum): (f64, f64), &root: &usize| {
            let own = self.elements[root].area();
            (area + own, sum + own * of_root(root))
        };
        let (area, sum) = self.roots.iter().fold((0.0, 0.0), sum);
        sum / area
    }

    /// Whether a face exchanges light; else it only hides others.
    pub(crate) fn exchanges(&self, face: usize) -> bool {
        self.exchanges[face]
    }

    /// The index of all polygons.
    pub(crate) const fn index(&self) -> &Occluders {
        &self.index
    }

    /// Convex parts of a face's polygon.
    pub(crate) fn convex_parts(&self, face: usize) -> &[Vec<DVec3>] {
        &self.convex[face]
    }

    /// Divides an element into four. One that is divided stays as it is.
    ///
    /// # Errors
    /// If its parts are too small for their coordinates.
    pub fn divide(&mut self, element: usize) -> Result<(), Error> {
        if self.elements[element].is_leaf() {
            let children = self.elements[element].divided(element, self.basis(element))?;
            self.elements[element].children = Some(self.elements.len());
            self.elements.extend(children);
        }
        Ok(())
    }

    /// The elements that are divided, in the order in which they were: dividing a new mesh of the scene likewise gives this one.
    #[must_use]
    pub fn divisions(&self) -> Vec<usize> {
        let mut divided: Vec<usize> = (0..self.elements.len()).filter(|&e| !self.elements[e].is_leaf()).collect();
        divided.sort_by_key(|&e| self.elements[e].children);
        divided
    }

    /// How faces were first cut: [`Cut::of`] it gives the same elements.
    pub(crate) const fn given(&self) -> &Given {
        &self.given
    }

    /// How many elements there were before any was divided.
    pub(crate) fn undivided(&self) -> usize {
        self.elements.iter().filter_map(Element::children).min().unwrap_or(self.elements.len())
    }

    /// The leaf at a point of a face, the nearest one if it is between them; `None` where the face exchanges no light.
    #[must_use]
    pub fn leaf_at(&self, face: usize, point: DVec3) -> Option<usize> {
        let excess = |e: &usize| self.elements[*e].excess(self.elements[*e].reference(point));
        let nearest = |a: &usize, b: &usize| excess(a).total_cmp(&excess(b));
        let mut element = *self.roots_of_face.get(face)?.iter().min_by(|a, b| nearest(a, b))?;
        while let Some(first) = self.elements[element].children {
            element = (first..first + 4).min_by(|a, b| nearest(a, b))?;
        }
        Some(element)
    }

    /// The face that a point is on, the nearest one within `reach` that faces along `normal`, and the point of its plane.
    pub(crate) fn face_at(&self, point: DVec3, normal: DVec3, reach: f64) -> Option<(usize, DVec3)> {
        let normal = normal.try_normalize()?;
        let on = |&(face, polygon): &(usize, &Polygon)| {
            let (distance, foot) = self.distance_to_face(face, point);
            (distance <= reach && polygon.normal().dot(normal) > 0.99).then_some((distance, face, foot))
        };
        let near = self.faces_near(point, reach).into_iter().map(|face| (face, &self.polygons[face]));
        let faces = near.filter(|(face, _)| self.exchanges[*face]);
        let nearest = faces.filter_map(|f| on(&f)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((nearest.1, nearest.2))
    }

    /// Whether a point is within `reach` of a face, whichever way that faces.
    pub(crate) fn is_near_a_face(&self, point: DVec3, reach: f64) -> bool {
        self.faces_near(point, reach).into_iter().any(|face| self.distance_to_face(face, point).0 <= reach)
    }

    /// The faces that a point may be within `reach` of, along the sides of their elements and their normals, ascending.
    pub(crate) fn faces_near(&self, point: DVec3, reach: f64) -> Vec<usize> {
        // Beside a corner it is farther off than along either side.
        let around = DVec3::splat(2.0 * reach);
        self.boxes.near([point - around, point + around])
    }

    /// How far a point is off a face at most, infinitely where the face exchanges no light, and the point of its plane.
    pub(crate) fn distance_to_face(&self, face: usize, point: DVec3) -> (f64, DVec3) {
        let polygon = &self.polygons[face];
        let height = polygon.normal().dot(point - polygon.vertices()[0]);
        let foot = point - polygon.normal() * height;
        let outside = |e: &usize| {
            let element = &self.elements[*e];
            largest(element.excess(element.reference(foot)), 0.0) * 2.0 * element.radius()
        };
        let outside = self.roots_of_face[face].iter().map(outside).fold(f64::INFINITY, smallest);
        (largest(height.abs(), outside), foot)
    }

    /// Whether each of two elements has a point in front of the other, by more than the rounding of coordinates.
    pub(crate) fn facing(&self, a: usize, b: usize) -> bool {
        let in_front = |of: usize, element: usize| {
            let (of, element) = (&self.elements[of], &self.elements[element]);
            let level = 1e-12 * ((of.centre() - element.centre()).length() + of.radius() + element.radius());
            element.polygon().vertices().iter().any(|v| of.polygon().normal().dot(*v - of.centre()) > level)
        };
        self.elements[a].face() != self.elements[b].face() && in_front(a, b) && in_front(b, a)
    }

    /// Normals of the faces that can light this one and are at a point of it, within `reach`.
    pub(crate) fn touching(&self, point: DVec3, face: usize, reach: f64) -> impl Iterator<Item = DVec3> {
        let normal = self.polygons[face].normal();
        let touches = move |element: &&Element| {
            if element.face() == face || normal.dot(element.polygon().normal()) >= 1.0 - 1e-9 {
                return false;
            }
            let height = element.polygon().normal().dot(point - element.polygon().vertices()[0]);
            let is_above = |v: &DVec3| normal.dot(*v - point) > reach;
            height.abs() <= reach && element.is_at(point, reach) && element.polygon().vertices().iter().any(is_above)
        };
        let roots = self.faces_near(point, reach).into_iter().flat_map(|face| &self.roots_of_face[face]);
        roots.map(|&root| &self.elements[root]).filter(touches).map(|element| element.polygon().normal())
    }

    /// An element's sight of another, among `known` where the faces in between were found for larger ones.
    pub(crate) fn sight(&self, receiver: usize, source: usize, known: Option<&[usize]>) -> Sight {
        let [to, from] = [receiver, source].map(|e| &self.elements[e]);
        if to.face() == from.face() {
            return Sight::Nothing(None);
        }
        let Some(beam) = Beam::from_polygon(to.polygon(), from.polygon()) else { return Sight::Nothing(None) };
        let ends = [to, from].map(|element| element.polygon().vertices());
        self.sight_by_index(&beam, known, [to.face(), from.face()], ends)
    }

    /// A point's sight of an element, with the face that it is on, among `known`.
    pub(crate) fn sight_of_point(&self, face: usize, point: DVec3, source: usize, known: Option<&[usize]>) -> Sight {
        let from = &self.elements[source];
        if face == from.face() {
            return Sight::Nothing(None);
        }
        let Some(beam) = Beam::from_point_of(&self.polygons[face], point, from.polygon()) else { return Sight::Nothing(None) };
        self.sight_by_index(&beam, known, [face, from.face()], [&[point], from.polygon().vertices()])
    }

    /// The sight of an element from a receiver that is on no face, among `known`: exactly for the coordinates as they are.
    pub(crate) fn sight_in_space(&self, receiver: &Receiver, source: usize, known: Option<&[usize]>) -> Sight {
        let from = &self.elements[source];
        let Some(beam) = Beam::from_receiver(receiver, from.polygon()) else { return Sight::Nothing(None) };
        self.sight_by_index(&beam, known, [from.face(); 2], [&[receiver.position()], from.polygon().vertices()])
    }

    /// Whether a face but for those left out is between two points.
    pub(crate) fn is_between(&self, ends: [DVec3; 2], leave_out: [usize; 2]) -> bool {
        self.index.is_between(ends, &leave_out)
    }

    /// Whether a face alone hides some points, and all between them, from others.
    pub(crate) fn hides(&self, face: usize, [from, to]: [&[DVec3]; 2]) -> bool {
        self.screens[face].iter().any(|screen| screen.hides(from, to))
    }

    fn sight_by_index(&self, beam: &Beam, given: Option<&[usize]>, leave_out: [usize; 2], ends: [&[DVec3]; 2]) -> Sight {
        let candidates = match given {
            Some(given) => self.index.among(beam, given, &leave_out),
            None => self.index.in_beam(beam, &leave_out),
        };
        if candidates.polygons.is_empty() {
            Sight::Clear
        } else if let Some(&face) = candidates.polygons.iter().find(|&&face| self.hides(face, ends)) {
            Sight::Nothing(Some(face))
        } else {
            Sight::Past(candidates.polygons)
        }
    }
}

/// A polygon, or triangles that make it up where it is not convex.
pub(crate) fn convex_parts(polygon: &Polygon) -> Option<Vec<Vec<DVec3>>> {
    let (v, normal) = (polygon.vertices(), polygon.normal());
    let corner = |i: usize| [v[i], v[(i + 1) % v.len()], v[(i + 2) % v.len()]];
    let turns = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - b).dot(normal) >= 0.0;
    if (0..v.len()).all(|i| turns(corner(i))) {
        return Some(vec![v.to_vec()]);
    }
    Some(triangulate(v)?.into_iter().map(|corners| corners.map(|i| v[i]).to_vec()).collect())
}

/// A box that is wider by a part of its longest side on every side, and by the rounding of that.
fn widened([low, high]: &[DVec3; 2], part: f64) -> [DVec3; 2] {
    let reach = part * (*high - *low).max_element();
    let rounding = if part == 0.0 { 0.0 } else { 1e-12 * largest(low.abs().max_element(), high.abs().max_element()) };
    [*low - (reach + rounding), *high + (reach + rounding)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_box_that_is_near_is_missed_and_few_others_are_found() {
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let boxes: Vec<[DVec3; 2]> = (0..2000)
            .map(|k| {
                let low = DVec3::new(uniform(), uniform(), if k % 2 == 0 { 0.0 } else { uniform() });
                [low, low + DVec3::new(uniform(), uniform(), uniform()) * if k % 100 == 0 { 0.5 } else { 0.02 }]
            })
            .collect();
        let (mut met, mut looked_at) = (0, 0);
        for part in [0.0, 0.8] {
            let index = Boxes::new(&boxes.iter().map(|sides| widened(sides, part)).collect::<Vec<_>>());
            for own in &boxes {
                let hits = index.near([own[0] - 1e-9, own[1] + 1e-9]);
                assert!(hits.is_sorted());
                looked_at += hits.len();
                for (other, [from, to]) in boxes.iter().enumerate() {
                    let reach = DVec3::splat(largest(1e-9, part * (*to - *from).max_element()));
                    if from.cmple(own[1] + reach).all() && to.cmpge(own[0] - reach).all() {
                        met += 1;
                        assert!(hits.binary_search(&other).is_ok(), "{own:?} {other}");
                    }
                }
            }
        }
        assert!(met > 10_000 && looked_at < 2000 * boxes.len() / 2, "{met} {looked_at}");
        assert_eq!(Boxes::new(&[]).near([DVec3::ZERO; 2]), [0; 0]);
    }
}
