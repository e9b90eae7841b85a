//! Lines of a scene across which what a point sees may jump: the edges of faces, and where faces cross.
//!
//! Of two faces that share an edge and turn the same side to a point nothing is seen between them, so that what is seen behind
//! them does not begin there. Other edges are outlines.

use std::collections::HashMap;

use radgrad_core::{DVec3, Polygon};

use crate::mesh::Mesh;
use crate::mesh::element::around;
use crate::mesh::screen::LEVEL;

/// A segment, each once.
#[derive(Debug)]
pub(super) struct Edge {
    pub(super) ends: [DVec3; 2],
    /// The faces that it bounds, and whether each runs from the first end to the second; none where faces cross.
    faces: Vec<(usize, bool)>,
}

/// The lines of all faces.
#[derive(Debug, Default)]
pub(super) struct Edges {
    pub(super) all: Vec<Edge>,
    of_face: Vec<Vec<usize>>,
    /// For each face the segments in which others stand on it or cross it.
    feet: Vec<Vec<[DVec3; 2]>>,
    planes: Vec<[DVec3; 2]>,
}

/// A segment by the bits of its ends, the lesser first.
type Key = [[u64; 3]; 2];

/// The key of a segment, and whether it runs from the first end of the key.
pub(super) fn key([a, b]: [DVec3; 2]) -> (Key, bool) {
    // No zero has a sign.
    let bits = |p: DVec3| p.to_array().map(|c| (c + 0.0).to_bits());
    let (a, b) = (bits(a), bits(b));
    if a <= b { ([a, b], true) } else { ([b, a], false) }
}

impl Edges {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let polygons = mesh.polygons();
        let mut edges =
            Self { of_face: vec![Vec::new(); polygons.len()], feet: vec![Vec::new(); polygons.len()], ..Self::default() };
        edges.planes = polygons.iter().map(|polygon| [polygon.vertices()[0], polygon.normal()]).collect();
        let mut known: HashMap<Key, usize> = HashMap::new();
        for (face, polygon) in polygons.iter().enumerate() {
            let v = polygon.vertices();
            for (i, &a) in v.iter().enumerate() {
                let ends = [a, v[(i + 1) % v.len()]];
                let (key, forward) = key(ends);
                let index = *known.entry(key).or_insert_with(|| {
                    let ends = if forward { ends } else { [ends[1], ends[0]] };
                    edges.all.push(Edge { ends, faces: Vec::new() });
                    edges.all.len() - 1
                });
                edges.all[index].faces.push((face, forward));
                edges.of_face[face].push(index);
            }
        }
        edges.meet(mesh, polygons);
        edges
    }

    /// Finds where faces stand on others or cross them.
    fn meet(&mut self, mesh: &Mesh, polygons: &[Polygon]) {
        let boxes: Vec<[DVec3; 2]> = polygons.iter().map(|polygon| around(polygon.vertices())).collect();
        let mut order: Vec<usize> = (0..polygons.len()).collect();
        order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
        for (place, &a) in order.iter().enumerate() {
            for &b in &order[place + 1..] {
                let reach = 1e-9 * (boxes[a][1] - boxes[a][0]).length().max((boxes[b][1] - boxes[b][0]).length());
                if boxes[b][0].x > boxes[a][1].x + reach {
                    break;
                }
                let apart = boxes[b][0].cmpgt(boxes[a][1] + reach).any() || boxes[a][0].cmpgt(boxes[b][1] + reach).any();
                if apart {
                    continue;
                }
                for (on, other) in [(a, b), (b, a)] {
                    for part in mesh.convex_parts(other) {
                        let Some((foot, crosses)) = foot(self.planes[on], part) else { continue };
                        self.feet[on].push(foot);
                        if crosses {
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

    /// Whether something stands on a face or crosses it.
    pub(super) fn has_feet(&self, face: usize) -> bool {
        !self.feet[face].is_empty()
    }

    /// Whether faces cross in a line.
    pub(super) fn crosses(&self, line: usize) -> bool {
        self.all[line].faces.is_empty()
    }

    /// Whether something else stands on or crosses a face inside a convex part of it.
    pub(super) fn stands_on(&self, face: usize, part: &[DVec3]) -> bool {
        let normal = self.planes[face][1];
        self.feet[face].iter().any(|foot| {
            let size = part.iter().map(|p| (*p - part[0]).length()).fold(0.0, f64::max);
            let (mut from, mut to) = (0.0_f64, 1.0_f64);
            let inside = part.iter().enumerate().all(|(i, &p)| {
                let inward = normal.cross(part[(i + 1) % part.len()] - p).normalize_or_zero();
                let [start, end] = foot.map(|q| inward.dot(q - p) - 1e-9 * size);
                if start <= 0.0 && end <= 0.0 {
                    return false;
                }
                let crossing = start / (start - end);
                if start < 0.0 {
                    from = from.max(crossing);
                } else if end < 0.0 {
                    to = to.min(crossing);
                }
                true
            });
            inside && to > from
        })
    }

    /// Whether an edge may be an outline for points of the hull of these.
    pub(super) fn is_outline(&self, edge: usize, from: &[DVec3]) -> bool {
        let [(a, along), (b, other)] = self.all[edge].faces[..] else { return true };
        if along == other {
            return true;
        }
        let side = |face: usize| {
            let [corner, normal] = self.planes[face];
            let reach = from.iter().map(|p| (*p - corner).length()).fold(0.0, f64::max);
            let height = from.iter().map(|p| normal.dot(*p - corner));
            let (low, high) = height.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
            let level = LEVEL * reach;
            if low >= -level && high > level {
                1
            } else if high <= level && low < -level {
                -1
            } else {
                0
            }
        };
        let (a, b) = (side(a), side(b));
        a == 0 || a != b
    }
}

/// The segment in which a convex polygon stands on a plane or crosses it, and whether it crosses; `None` if it is nowhere in front,
/// or meets the plane in no more than a point.
fn foot([corner, normal]: [DVec3; 2], part: &[DVec3]) -> Option<([DVec3; 2], bool)> {
    let heights: Vec<f64> = part.iter().map(|p| normal.dot(*p - corner)).collect();
    let reach = part.iter().map(|p| (*p - corner).length()).fold(0.0, f64::max);
    let level = 1e-9 * reach;
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), &h| (low.min(h), high.max(h)));
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
