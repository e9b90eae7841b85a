//! The planes of faces whose coordinates are rounded, and the vertices on them.

use std::collections::{BTreeSet, HashMap};

use radgrad_core::DVec3;

use crate::extremes::{largest, smallest};
use crate::occluders::shape::Bounds;
use crate::occluders::tree::Tree;

/// Margin on the distance that rounding moves a vertex along a normal.
const MARGIN: f64 = 1.2;

/// The distance from a plane of least squares, over that of the plane that vertices were rounded from: with few vertices the fit may turn to
/// some and away from another.
const RESIDUAL: f64 = 1.8;

/// The largest sums of barycentric coordinates that add to that distance: first all that is likely, then, of faces that a fitted plane
/// left out, those that are as near as one rounding.
const LEVERS: [f64; 2] = [3.0, 0.0];

/// Faces whose normal is known to this angle are looked up by it; those of others by the vertices that they share.
const KNOWN: f64 = 1e-3;

/// Cells of normals, and of distances over the extent.
const CELL: f64 = 4.0 * KNOWN;

/// The directions of faces that are narrower than so many roundings say little, first and then: such a face is on a plane only with faces that
/// share all of its vertices. Else a needle beside the edge of two walls would turn the plane of the wrong one.
const NEEDLES: [f64; 2] = [16.0, 4.0];

/// Faces at a vertex, beyond which they are not taken for neighbours by it: of a fan, those beside each other share another vertex.
const HUB: usize = 64;

/// Of planes whose normals differ from the span of those before by less than this, rounding decides where they meet.
const PARALLEL: f64 = 0.1;

/// How far from an edge a vertex on it may be: its own rounding and those of the ends, along three axes.
const BESIDE: f64 = 4.0;

/// The largest motion of a vertex, in roundings: more than planes that are not nearly parallel ask for.
const FARTHEST: f64 = 64.0;

/// A plane, and the faces on it.
#[derive(Debug)]
struct Plane {
    origin: DVec3,
    normal: DVec3,
    /// Three points, far apart, that it was taken from.
    base: [DVec3; 3],
    faces: Vec<usize>,
    vertices: BTreeSet<usize>,
    /// Whether its faces have more vertices than a plane needs.
    asks: bool,
}

impl Plane {
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.origin)
    }

    /// The sum of the magnitudes of a point's barycentric coordinates in the base, at most `most`.
    fn lever(&self, point: DVec3, most: f64) -> f64 {
        let [a, b, c] = self.base;
        let across = |p: DVec3, q: DVec3, r: DVec3| self.normal.dot((q - p).cross(r - p));
        let area = across(a, b, c);
        let sum = (across(point, b, c).abs() + across(a, point, c).abs() + across(a, b, point).abs()) / area.abs();
        // Not a number, where the base has no area, is the most.
        if sum <= most { sum } else { most }
    }

    /// Whether rounding explains the distance of a point.
    fn holds(&self, point: DVec3, rounding: f64, lever: f64) -> bool {
        let [x, y, z] = self.normal.abs().to_array();
        self.height(point).abs() <= MARGIN * rounding * (x + y + z) * (1.0 + self.lever(point, lever))
    }

    /// Takes a point for a corner of the base where that makes it a fifth larger or more; whether it does.
    fn widen(&mut self, point: DVec3) -> bool {
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
        let with = |k: usize| {
            let mut base = self.base;
            base[k] = point;
            base
        };
        let widest = [0, 1, 2].map(with).into_iter().max_by(|a, b| area(*a).total_cmp(&area(*b)));
        let wider = widest.filter(|base| area(*base) > 1.2 * area(self.base));
        self.base = wider.unwrap_or(self.base);
        wider.is_some()
    }

    /// Fits it to its vertices, by least squares of heights; twice, as a tilt of 1e-3 leaves its square.
    fn fit(&mut self, positions: &[DVec3]) {
        for _ in 0..2 {
            let points: Vec<DVec3> = self.vertices.iter().map(|&vertex| positions[vertex]).collect();
            let middle = points.iter().sum::<DVec3>() / points.len() as f64;
            let (along, across) = self.normal.any_orthonormal_pair();
            let [mut uu, mut uv, mut vv, mut uh, mut vh] = [0.0; 5];
            for r in points.iter().map(|point| *point - middle) {
                let (u, v, h) = (along.dot(r), across.dot(r), self.normal.dot(r));
                (uu, uv, vv, uh, vh) = (uu + u * u, uv + u * v, vv + v * v, uh + u * h, vh + v * h);
            }
            let determinant = uu * vv - uv * uv;
            let tilt = [(uh * vv - vh * uv) / determinant, (vh * uu - uh * uv) / determinant];
            let fitted = (self.normal - along * tilt[0] - across * tilt[1]).normalize_or_zero();
            // A face on one line keeps its plane, and a flat one keeps it to the last bit.
            if determinant <= 1e-12 * uu * vv || (uh == 0.0 && vh == 0.0) || !fitted.is_finite() || fitted == DVec3::ZERO {
                return;
            }
            (self.origin, self.normal) = (middle, fitted);
        }
    }

    /// Leaves out faces with a vertex that is farther off than rounding explains, and returns them.
    fn leave_out(&mut self, positions: &[DVec3], faces: &[Vec<usize>], rounding: f64) -> Vec<usize> {
        let [x, y, z] = self.normal.abs().to_array();
        let tolerance = RESIDUAL * rounding * (x + y + z);
        let is_on = |face: &usize| faces[*face].iter().all(|&vertex| self.height(positions[vertex]).abs() <= tolerance);
        let (kept, left_out): (Vec<usize>, Vec<usize>) = self.faces.iter().copied().partition(is_on);
        if !left_out.is_empty() {
            self.vertices = kept.iter().flat_map(|&face| faces[face].iter().copied()).collect();
            self.faces = kept;
        }
        left_out
    }
}

/// The planes of faces.
#[derive(Debug, Default)]
pub(super) struct Planes {
    planes: Vec<Plane>,
}

impl Planes {
    /// The planes of faces, each given by its vertices, around the middle of all of them.
    pub(super) fn fit(positions: &[DVec3], faces: &[Vec<usize>], rounding: f64) -> Self {
        let outline = |face: &Vec<usize>| -> Vec<DVec3> { face.iter().map(|&vertex| positions[vertex]).collect() };
        let widths: Vec<f64> = faces.iter().map(|face| width(&outline(face))).collect();
        let mut order: Vec<usize> = (0..faces.len()).filter(|&face| widths[face] > 0.0).collect();
        order.sort_by(|&a, &b| widths[b].total_cmp(&widths[a]));
        let junctions = junctions(positions, faces, rounding);
        let touching = touching(faces, &junctions);
        let extent = 2.0 * positions.iter().map(|v| v.abs().max_element()).fold(0.0, largest);
        let (planes, by_face, by_normal) = (Vec::new(), HashMap::new(), HashMap::new());
        let (widths, touching) = (&widths, &touching);
        let mut shared =
            Shared { positions, faces, widths, touching, rounding, lever: 0.0, needle: 0.0, extent, planes, by_face, by_normal };
        for (lever, needle) in LEVERS.into_iter().zip(NEEDLES) {
            (shared.lever, shared.needle) = (lever, needle);
            order.iter().for_each(|&face| shared.add(face));
            let left_out = shared.fit();
            order.retain(|face| left_out.contains(face));
        }
        let mut planes = Self { planes: shared.planes };
        planes.join(positions, &junctions, rounding);
        planes
    }

    /// Puts vertices that lie on an edge of another face onto the plane of that face too: where a wall ends in another one, its vertices
    /// are on that one.
    fn join(&mut self, positions: &[DVec3], junctions: &[(usize, usize)], rounding: f64) {
        let mut plane_of: HashMap<usize, usize> = HashMap::new();
        for (place, plane) in self.planes.iter().enumerate() {
            plane_of.extend(plane.faces.iter().map(|&face| (face, place)));
        }
        for &(vertex, face) in junctions {
            let plane = plane_of.get(&face).map(|&place| &mut self.planes[place]);
            if let Some(plane) = plane.filter(|plane| plane.holds(positions[vertex], rounding, 1.0)) {
                plane.vertices.insert(vertex);
            }
        }
    }

    /// The motions of vertices onto their planes: of those that are off one by more than `flat`.
    pub(super) fn settle(&self, positions: &[DVec3], flat: f64, rounding: f64) -> Vec<(usize, DVec3)> {
        let mut on: HashMap<usize, Vec<&Plane>> = HashMap::new();
        for plane in self.planes.iter().filter(|plane| plane.asks) {
            plane.vertices.iter().for_each(|&vertex| on.entry(vertex).or_default().push(plane));
        }
        let mut moved: Vec<(usize, DVec3)> = Vec::new();
        for (vertex, mut planes) in on {
            let position = positions[vertex];
            if planes.iter().all(|plane| plane.height(position).abs() <= flat) {
                continue;
            }
            planes.sort_by_key(|plane| std::cmp::Reverse(plane.vertices.len()));
            let motion = onto(&planes, position);
            let first = onto(&planes[..1], position);
            let farthest = FARTHEST * rounding;
            moved.extend([motion, first].into_iter().find(|motion| motion.length() <= farthest).map(|motion| (vertex, motion)));
        }
        moved.sort_by_key(|(vertex, _)| *vertex);
        moved
    }
}

/// Planes that are being found, and how to find one again.
struct Shared<'a> {
    positions: &'a [DVec3],
    faces: &'a [Vec<usize>],
    widths: &'a [f64],
    /// The faces that share a vertex with each face, or end on an edge of it, or where it ends.
    touching: &'a [Vec<usize>],
    rounding: f64,
    lever: f64,
    needle: f64,
    extent: f64,
    planes: Vec<Plane>,
    by_face: HashMap<usize, usize>,
    by_normal: HashMap<[i64; 4], Vec<usize>>,
}

impl Shared<'_> {
    /// Adds a face to a plane that all of it is on, or to one of its own, and then its neighbours and theirs, the widest
    /// first, while they are on it.
    fn add(&mut self, face: usize) {
        let Some((normal, base)) = (!self.by_face.contains_key(&face)).then(|| widest_triangle(&self.points(face))).flatten()
        else {
            return;
        };
        let origin = self.positions[self.faces[face][0]];
        let mut near: Vec<usize> = self.touching[face].iter().filter_map(|other| self.by_face.get(other)).copied().collect();
        if self.is_known(face) {
            for key in keys(normal, origin, self.extent, true) {
                near.extend(self.by_normal.get(&key).into_iter().flatten());
            }
        }
        let place = near.into_iter().find(|&place| self.is_on(face, place)).unwrap_or_else(|| {
            let (faces, vertices, asks) = (Vec::new(), BTreeSet::new(), false);
            self.planes.push(Plane { origin, normal, base, faces, vertices, asks });
            let place = self.planes.len() - 1;
            for key in keys(normal, origin, self.extent, false) {
                self.by_normal.entry(key).or_default().push(place);
            }
            place
        });
        self.put(face, place);
        let by_width = |face: usize| (Ordered(self.widths[face]), face);
        let mut open: BTreeSet<(Ordered, usize)> = self.touching[face].iter().map(|&other| by_width(other)).collect();
        while let Some((width, face)) = open.pop_last() {
            if width.0 > 0.0 && !self.by_face.contains_key(&face) && self.is_on(face, place) {
                self.put(face, place);
                open.extend(self.touching[face].iter().map(|&other| (Ordered(self.widths[other]), other)));
            }
        }
    }

    /// Fits all planes, and returns the faces that are on none then.
    fn fit(&mut self) -> BTreeSet<usize> {
        let mut left_out = BTreeSet::new();
        for plane in &mut self.planes {
            plane.fit(self.positions);
            left_out.extend(plane.leave_out(self.positions, self.faces, self.rounding));
            plane.asks = plane.vertices.len() > 3;
        }
        self.by_face.retain(|face, _| !left_out.contains(face));
        left_out
    }

    fn points(&self, face: usize) -> Vec<DVec3> {
        self.faces[face].iter().map(|&vertex| self.positions[vertex]).collect()
    }

    /// Whether the direction of a face is known well enough to look for planes by it.
    fn is_known(&self, face: usize) -> bool {
        self.rounding <= KNOWN * self.widths[face]
    }

    /// Whether rounding explains that a face is not on a plane.
    fn is_on(&self, face: usize, place: usize) -> bool {
        let (plane, points) = (&self.planes[place], self.points(face));
        let is_needle = self.widths[face] < self.needle * self.rounding;
        let turned = |normal: DVec3| 1.0 - plane.normal.dot(normal).abs();
        (!is_needle || self.faces[face].iter().all(|vertex| plane.vertices.contains(vertex)))
            && (!self.is_known(face) || widest_triangle(&points).is_some_and(|(normal, _)| turned(normal) <= KNOWN))
            && points.iter().all(|&point| plane.holds(point, self.rounding, self.lever))
    }

    fn put(&mut self, face: usize, place: usize) {
        self.by_face.insert(face, place);
        let plane = &mut self.planes[place];
        plane.faces.push(face);
        let mut is_wider = false;
        for &vertex in &self.faces[face] {
            is_wider |= plane.vertices.insert(vertex) && plane.widen(self.positions[vertex]);
        }
        // Points far apart tell the plane better.
        if is_wider {
            plane.fit(self.positions);
        }
    }
}

/// A width, which is a number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The shortest motion of a point onto planes, the first of those that are nearly parallel.
fn onto(planes: &[&Plane], position: DVec3) -> DVec3 {
    let mut motion = DVec3::ZERO;
    // Again for the rounding of the first.
    for _ in 0..2 {
        let mut axes: Vec<DVec3> = Vec::with_capacity(3);
        for plane in planes {
            let across = axes.iter().fold(plane.normal, |rest, axis| rest - *axis * axis.dot(plane.normal));
            let length = across.length();
            if axes.len() == 3 || length < PARALLEL {
                continue;
            }
            let axis = across / length;
            // Along this axis no plane before is left.
            motion -= axis * (plane.height(position + motion) / length);
            axes.push(axis);
        }
    }
    motion
}

/// Vertices that lie on an edge of a face, between its ends, and that face.
fn junctions(positions: &[DVec3], faces: &[Vec<usize>], rounding: f64) -> Vec<(usize, usize)> {
    let edges_of = |(face, vertices): (usize, &'_ Vec<usize>)| {
        (0..vertices.len()).map(|i| (face, [vertices[i], vertices[(i + 1) % vertices.len()]])).collect::<Vec<_>>()
    };
    let edges: Vec<(usize, [usize; 2])> = faces.iter().enumerate().flat_map(edges_of).collect();
    let ends = |edge: usize| edges[edge].1.map(|end| positions[end]);
    let tree = Tree::over(&(0..edges.len()).map(|edge| Bounds::of(&ends(edge))).collect::<Vec<_>>());
    let reach = BESIDE * rounding;
    let mut junctions = Vec::new();
    for (vertex, &position) in positions.iter().enumerate() {
        let around = Bounds { low: position - DVec3::splat(reach), high: position + DVec3::splat(reach) };
        tree.near(&around, |edge| {
            if !edges[edge].1.contains(&vertex) && is_beside(position, ends(edge), reach) {
                junctions.push((vertex, edges[edge].0));
            }
        });
    }
    junctions
}

/// The faces that share a vertex with each face, or meet it at a junction.
fn touching(faces: &[Vec<usize>], junctions: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut of_vertex: HashMap<usize, Vec<usize>> = HashMap::new();
    let corners = faces.iter().enumerate().flat_map(|(face, vertices)| vertices.iter().map(move |&vertex| (vertex, face)));
    for (vertex, face) in corners.chain(junctions.iter().copied()) {
        of_vertex.entry(vertex).or_default().push(face);
    }
    let mut touching = vec![Vec::new(); faces.len()];
    for around in of_vertex.values().filter(|around| around.len() <= HUB) {
        for &face in around {
            touching[face].extend(around.iter().filter(|&&other| other != face));
        }
    }
    for around in &mut touching {
        around.sort_unstable();
        around.dedup();
    }
    touching
}

/// Whether a point is within a distance of the inside of a segment.
fn is_beside(point: DVec3, [from, to]: [DVec3; 2], distance: f64) -> bool {
    let along = to - from;
    let share = (point - from).dot(along) / along.length_squared();
    share > 0.0 && share < 1.0 && (from + along * share - point).length() <= distance
}

/// The unit normal of an outline, and the triangle of its vertices that is nearly the largest.
fn widest_triangle(outline: &[DVec3]) -> Option<(DVec3, [DVec3; 3])> {
    let (&origin, rest) = outline.split_first()?;
    let doubled = rest.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum::<DVec3>();
    let normal = doubled.normalize_or_zero();
    let farthest = |from: &dyn Fn(DVec3) -> f64| outline.iter().copied().max_by(|a, b| from(*a).total_cmp(&from(*b)));
    let a = farthest(&|p| (p - origin).length())?;
    let b = farthest(&|p| (p - a).length())?;
    let c = farthest(&|p| (p - a).cross(b - a).length())?;
    (normal.is_finite() && normal != DVec3::ZERO).then_some((normal, [a, b, c]))
}

/// The cells of a plane, in both orientations: the one that it is in, or all that one within the tolerance may be in.
fn keys(normal: DVec3, point: DVec3, extent: f64, is_query: bool) -> Vec<[i64; 4]> {
    #[expect(clippy::cast_possible_truncation, reason = "both are at most 1 over the cell")]
    let cell = |value: f64| (value / CELL).floor() as i64;
    let place = |sign: f64| {
        let [x, y, z] = (normal * sign).to_array();
        [x, y, z, sign * normal.dot(point) / smallest(extent, f64::MAX)]
    };
    if !is_query {
        return vec![place(1.0).map(cell)];
    }
    let mut keys = Vec::new();
    for place in [1.0, -1.0].map(place) {
        let ranges = place.map(|value| cell(value - KNOWN)..=cell(value + KNOWN));
        let [xs, ys, zs, ds] = ranges;
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    keys.extend(ds.clone().map(|d| [x, y, z, d]));
                }
            }
        }
    }
    keys
}

/// The doubled area of an outline over its diameter; 0 if it has fewer than three vertices.
pub(super) fn width(outline: &[DVec3]) -> f64 {
    let Some((&origin, rest)) = outline.split_first() else { return 0.0 };
    let diameter = outline.iter().enumerate().flat_map(|(i, a)| outline[..i].iter().map(move |b| (*a - *b).length()));
    let diameter = diameter.fold(0.0, largest);
    let doubled = rest.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum::<DVec3>().length();
    if diameter > 0.0 { doubled / diameter } else { 0.0 }
}
