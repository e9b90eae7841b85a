//! Lines of a scene across which the view of a point may jump: the edges of faces, and where faces cross.
//!
//! Two faces that share an edge and turn the same side to a point leave no gap there, so that the point's sight of faces behind
//! does not change across that edge. Other edges are outlines. A corner of another face that is on an edge (a T-junction) divides it
//! into two edges, and each may be shared by itself.

use std::collections::HashMap;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Boxes, largest, smallest};

use crate::mesh::Mesh;
use crate::mesh::contact;
use crate::mesh::element::around;
use crate::mesh::screen::LEVEL;

/// A segment, each once.
#[derive(Debug)]
struct Edge {
    ends: [DVec3; 2],
    /// The faces that it bounds, and whether each runs from the first end to the second; none where faces cross.
    faces: Vec<(usize, bool)>,
}

/// The lines of all faces.
#[derive(Debug, Default)]
pub(crate) struct Edges {
    all: Vec<Edge>,
    of_face: Vec<Vec<usize>>,
    /// For each face the others that stand on it or cross it, and the segments in which they do.
    feet: Vec<Vec<(usize, [DVec3; 2])>>,
    /// For each face the first one of those that it hangs together with by edges.
    solids: Vec<usize>,
    planes: Vec<[DVec3; 2]>,
}

/// A segment by the bits of its ends, the lesser first.
type Key = [[u64; 3]; 2];

/// The bits of a point, of which no zero has a sign.
fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(|c| (c + 0.0).to_bits())
}

/// The key of a segment, and whether it runs from the first end of the key.
fn key([a, b]: [DVec3; 2]) -> (Key, bool) {
    let (a, b) = (bits(a), bits(b));
    if a <= b { ([a, b], true) } else { ([b, a], false) }
}

impl Edges {
    pub(crate) fn find(mesh: &Mesh) -> Self {
        let polygons = mesh.polygons();
        let mut edges =
            Self { of_face: vec![Vec::new(); polygons.len()], feet: vec![Vec::new(); polygons.len()], ..Self::default() };
        edges.planes = polygons.iter().map(|polygon| [polygon.vertices()[0], polygon.normal()]).collect();
        let pairs = near(polygons);
        let mut indices: HashMap<Key, usize> = HashMap::new();
        for (face, around) in around_each(polygons, &pairs).into_iter().enumerate() {
            for ends in pieces(polygons[face].vertices(), &around) {
                let (key, forward) = key(ends);
                let index = *indices.entry(key).or_insert_with(|| {
                    let ends = if forward { ends } else { [ends[1], ends[0]] };
                    edges.all.push(Edge { ends, faces: Vec::new() });
                    edges.all.len() - 1
                });
                edges.all[index].faces.push((face, forward));
                edges.of_face[face].push(index);
            }
        }
        edges.meet(mesh, pairs);
        edges.join();
        edges
    }

    /// Finds which faces hang together.
    fn join(&mut self) {
        self.solids = (0..self.of_face.len()).collect();
        let mut open: Vec<usize> = Vec::new();
        let mut visited = vec![false; self.solids.len()];
        for first in 0..self.solids.len() {
            if !visited[first] {
                visited[first] = true;
                open.push(first);
            }
            while let Some(face) = open.pop() {
                self.solids[face] = first;
                for &line in &self.of_face[face] {
                    for &(other, _) in &self.all[line].faces {
                        if !std::mem::replace(&mut visited[other], true) {
                            open.push(other);
                        }
                    }
                }
            }
        }
    }

    /// Finds where faces stand on others or cross them, from those that are near.
    fn meet(&mut self, mesh: &Mesh, pairs: Vec<Near>) {
        for Near { faces: [a, b], reach } in pairs {
            for (on, other) in [(a, b), (b, a)] {
                for part in mesh.convex_parts(other) {
                    let Some((foot, crosses)) = foot(self.planes[on], part) else { continue };
                    // The plane goes on beyond the face.
                    let normal = self.planes[on][1];
                    for foot in mesh.convex_parts(on).iter().filter_map(|of| inside(foot, normal, of, reach)) {
                        self.feet[on].push((other, foot));
                        // Where one face ends in the other nothing crosses.
                        if crosses && !is_on_border(foot, mesh.polygons()[on].vertices(), 4.0 * reach) {
                            self.of_face[on].push(self.all.len());
                            self.of_face[other].push(self.all.len());
                            self.all.push(Edge { ends: foot, faces: Vec::new() });
                        }
                    }
                }
            }
        }
    }

    /// The lines of a face.
    pub(super) fn of_face(&self, face: usize) -> &[usize] {
        &self.of_face[face]
    }

    /// Whether faces cross in a line.
    pub(super) fn crosses(&self, line: usize) -> bool {
        self.all[line].faces.is_empty()
    }

    /// The ends of a line.
    pub(super) fn ends(&self, line: usize) -> [DVec3; 2] {
        self.all[line].ends
    }

    /// The solid of a face: a number that all faces connected with it have.
    pub(super) fn solid(&self, face: usize) -> usize {
        self.solids[face]
    }

    /// The other faces that stand on a face or cross it, and the segments in which they do.
    pub(crate) fn feet(&self, face: usize) -> &[(usize, [DVec3; 2])] {
        &self.feet[face]
    }

    /// A face, of some, that stands on another or crosses it inside a convex part of that.
    pub(super) fn standing(&self, face: usize, part: &[DVec3], among: &[usize]) -> Option<usize> {
        let normal = self.planes[face][1];
        let size = part.iter().map(|p| (*p - part[0]).length()).fold(0.0, largest);
        let is_inside = |foot: &[DVec3; 2]| inside(*foot, normal, part, -1e-9 * size).is_some();
        let mut feet = self.feet[face].iter().filter(|(of, _)| among.contains(of));
        feet.find(|(_, foot)| is_inside(foot)).map(|(of, _)| *of)
    }

    /// The parts of a convex polygon for points of which an edge may be an outline: those in front of one of its two sheets and behind the
    /// other. Faces that are at an edge back to back, as those of a box that has an inside, are one sheet.
    pub(super) fn outlined_from(&self, edge: usize, from: &[DVec3]) -> Vec<Vec<DVec3>> {
        let [(a, along), (b, other)] = self.sheets(edge)[..] else { return vec![from.to_vec()] };
        let same = if along == other { -1.0 } else { 1.0 };
        let between = |sign: f64| self.beside(b, -sign * same, &self.beside(a, sign, from));
        [1.0, -1.0].map(between).into_iter().filter(|part| !part.is_empty()).collect()
    }

    /// The faces at an edge, one of each sheet, and whether each runs from its first end to the second.
    fn sheets(&self, edge: usize) -> Vec<(usize, bool)> {
        let Edge { ends: [from, to], faces } = &self.all[edge];
        let along = (*to - *from).normalize_or_zero();
        let inward = |&(face, forward): &(usize, bool)| self.planes[face][1].cross(if forward { along } else { -along });
        let mut sheets: Vec<(usize, bool)> = Vec::with_capacity(2);
        for face in faces {
            if sheets.iter().all(|sheet| (inward(sheet) - inward(face)).length() > LEVEL) {
                sheets.push(*face);
            }
        }
        sheets
    }

    /// The part of a convex polygon on one side of a face's plane: all of it if it lies in the plane, nothing if it touches the
    /// plane from the other side.
    pub(super) fn beside(&self, face: usize, sign: f64, from: &[DVec3]) -> Vec<DVec3> {
        let [corner, normal] = self.planes[face];
        before([corner, normal * sign], from)
    }
}

/// The part of a convex polygon in front of a plane: all of it if it lies in the plane, nothing if it touches the plane from behind.
fn before([corner, normal]: [DVec3; 2], from: &[DVec3]) -> Vec<DVec3> {
    let level = LEVEL * from.iter().map(|p| (*p - corner).length()).fold(0.0, largest);
    let heights: Vec<f64> = from.iter().map(|p| normal.dot(*p - corner)).collect();
    if heights.iter().all(|h| *h <= level) {
        return if heights.iter().all(|h| *h >= -level) { from.to_vec() } else { Vec::new() };
    }
    let mut clipped = Vec::with_capacity(from.len() + 1);
    for (i, &p) in from.iter().enumerate() {
        let j = (i + 1) % from.len();
        if heights[i] >= -level {
            clipped.push(p);
        }
        if smallest(heights[i], heights[j]) < -level && largest(heights[i], heights[j]) > 0.0 {
            clipped.push(p + (from[j] - p) * (heights[i] / (heights[i] - heights[j])));
        }
    }
    clipped
}

/// Two faces whose boxes are no farther apart than this, a small part of their sizes.
struct Near {
    faces: [usize; 2],
    reach: f64,
}

/// All pairs of them.
fn near(polygons: &[Polygon]) -> Vec<Near> {
    let boxes: Vec<[DVec3; 2]> = polygons.iter().map(|polygon| around(polygon.vertices())).collect();
    let reach: Vec<f64> = boxes.iter().map(|[low, high]| 1e-9 * (*high - *low).length()).collect();
    let widened: Vec<[DVec3; 2]> = boxes.iter().zip(&reach).map(|([low, high], reach)| [*low - reach, *high + reach]).collect();
    let index = Boxes::new(&widened);
    // From low to high x, and so their pairs.
    let mut order: Vec<usize> = (0..polygons.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &face)| place[face] = at);
    let of_face = |&a: &usize| {
        let mut later: Vec<usize> = index.near(widened[a]).into_iter().filter(|&b| place[b] > place[a]).collect();
        later.sort_unstable_by_key(|&b| place[b]);
        let pair = |b: usize| {
            let reach = largest(reach[a], reach[b]);
            let apart = boxes[b][0].cmpgt(boxes[a][1] + reach).any() || boxes[a][0].cmpgt(boxes[b][1] + reach).any();
            (!apart).then_some(Near { faces: [a, b], reach })
        };
        later.into_iter().filter_map(pair).collect::<Vec<_>>()
    };
    order.iter().flat_map(of_face).collect()
}

/// For each face the corners of those near it.
fn around_each(polygons: &[Polygon], pairs: &[Near]) -> Vec<Vec<DVec3>> {
    let mut corners = vec![Vec::new(); polygons.len()];
    for Near { faces: [a, b], .. } in pairs {
        corners[*a].extend_from_slice(polygons[*b].vertices());
        corners[*b].extend_from_slice(polygons[*a].vertices());
    }
    corners
}

/// The edges of a face from corner to corner, where some of others' corners may be on them.
fn pieces(v: &[DVec3], corners: &[DVec3]) -> Vec<[DVec3; 2]> {
    let mut pieces = Vec::with_capacity(v.len());
    for (i, &a) in v.iter().enumerate() {
        let b = v[(i + 1) % v.len()];
        let along = b - a;
        let square = along.length_squared();
        let place = |p: &DVec3| {
            let place = (*p - a).dot(along) / square;
            let is_between = place > 0.0 && place < 1.0 && *p != a && *p != b;
            let is_on = (*p - a).cross(along).length() <= LEVEL * square;
            (is_between && is_on).then_some((place, *p))
        };
        let mut between: Vec<(f64, DVec3)> = corners.iter().filter_map(place).collect();
        between.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = a;
        for to in between.into_iter().map(|(_, p)| p).chain([b]) {
            if to != from {
                pieces.push([from, to]);
            }
            from = to;
        }
    }
    pieces
}

/// The part of a segment in the plane of a convex polygon that is in the polygon, made larger on all sides by so much; `None` if that is
/// no more than a point.
fn inside([a, b]: [DVec3; 2], normal: DVec3, part: &[DVec3], by: f64) -> Option<[DVec3; 2]> {
    let [from, to] = contact::inside(part, [a, b], normal, -by)?;
    (to > from).then(|| [a + (b - a) * from, a + (b - a) * to])
}

/// Whether a segment is along an edge of a polygon, and no farther from that than a length.
fn is_on_border(ends: [DVec3; 2], v: &[DVec3], reach: f64) -> bool {
    (0..v.len()).any(|i| {
        let edge = v[(i + 1) % v.len()] - v[i];
        let (along, length) = (edge.normalize_or_zero(), edge.length());
        ends.iter().all(|end| {
            let place = (*end - v[i]).dot(along);
            place >= -reach && place <= length + reach && (*end - v[i]).cross(along).length() <= reach
        })
    })
}

/// The segment in which a convex polygon stands on a plane or crosses it, and whether it crosses; `None` if it is nowhere in front,
/// or meets the plane in no more than a point.
fn foot([corner, normal]: [DVec3; 2], part: &[DVec3]) -> Option<([DVec3; 2], bool)> {
    let heights: Vec<f64> = part.iter().map(|p| normal.dot(*p - corner)).collect();
    let reach = part.iter().map(|p| (*p - corner).length()).fold(0.0, largest);
    let level = 1e-9 * reach;
    let (low, high) = heights
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), &h| (smallest(low, h), largest(high, h)));
    if high <= level || low > level {
        return None;
    }
    let mut points: Vec<DVec3> = Vec::new();
    for (i, &p) in part.iter().enumerate() {
        let j = (i + 1) % part.len();
        if heights[i].abs() <= level {
            points.push(p - normal * heights[i]);
        } else if heights[i] * heights[j] < 0.0 && heights[j].abs() > level {
            points.push(p + (part[j] - p) * (heights[i] / (heights[i] - heights[j])));
        }
    }
    let mut widest = [DVec3::ZERO; 2];
    for (i, &p) in points.iter().enumerate() {
        for &q in &points[i + 1..] {
            if (q - p).length() > (widest[1] - widest[0]).length() {
                widest = [p, q];
            }
        }
    }
    ((widest[1] - widest[0]).length() > level).then_some((widest, low < -level))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_has_a_piece_for_each_corner_of_others_that_is_on_it() {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.25);
        let square = [corner(0.0, 0.0), corner(3.0, 0.0), corner(3.0, 3.0), corner(0.0, 3.0)];
        // Its own corners, two on an edge, each twice, and one beside it.
        let others = [
            corner(2.0, 0.0),
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(3.0, 0.0),
            corner(2.0, 0.0),
            corner(1.5, 1e-9),
            corner(1.0, 0.0),
        ];
        let computed = pieces(&square, &others);
        let expected = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(2.0, 0.0),
            corner(3.0, 0.0),
            corner(3.0, 3.0),
            corner(0.0, 3.0),
            corner(0.0, 0.0),
        ];
        assert_eq!(computed, expected.windows(2).map(|ends| [ends[0], ends[1]]).collect::<Vec<_>>());
        assert_eq!(pieces(&square, &[]).len(), 4);
    }
}
