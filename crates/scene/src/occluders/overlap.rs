//! Faces that lie in one plane, face the same way and overlap: the visible part of the overlap counts twice.
//!
//! A [`Beam`](super::Beam) takes a face level with a surface, up to the rounding of its coordinates, to be in its plane and so to
//! hide nothing. If two faces are level with each other, neither hides the other, and light from where both are is counted for
//! each. So the test here is that of the beam, with the area that the two have in common. Back to back they are seen from one side
//! each, and a face in front of another by more than the rounding hides it: both are as they should be.
//!
//! Edges that coincide leave slivers of an overlap. With coordinates off by `d = 4 eps C`, C the largest of them, two edges of
//! length l overlap by at most `2 sqrt(2) d l`, and l is at most half the sum P of the perimeters: `1.5 d P`. Clipping rounds
//! by less than d again.

use std::ops::Range;

use radgrad_core::{DVec3, Polygon};

use super::Occluders;
use super::half_space::Level;
use super::shape::Bounds;
use super::tree::Content;
use crate::scene::triangles;
use crate::{largest, smallest};

/// Slivers of this area, over the perimeters' sum and the largest coordinate, are left by rounding: twice 1.5 times 4 eps.
const SLIVER: f64 = 12.0 * f64::EPSILON;

/// Two polygons that overlap in one plane.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Overlap {
    /// Their indices, the lower one first.
    pub(crate) polygons: [usize; 2],
    /// A point that both have.
    pub(crate) at: DVec3,
    /// The part of the smaller one that both have.
    pub(crate) share: f64,
}

impl Occluders {
    /// Two of the polygons indexed that overlap in one plane and face the same way, among those that count; `polygons` are all of
    /// them.
    pub(crate) fn overlap(&self, polygons: &[&Polygon], counts: impl Fn(usize) -> bool) -> Option<Overlap> {
        let whole = &self.tree.nodes.get(self.tree.root()?)?.bounds;
        let extent = (whole.high - whole.low).length();
        (0..self.polygons.len()).filter(|&index| counts(index)).find_map(|index| {
            let (shape, polygon) = (&self.polygons[index], polygons[index]);
            let slope = perimeter(polygon.vertices()) / polygon.area();
            let reach = DVec3::splat(Level::new(largest_of(polygon), slope).at(extent));
            let around = Bounds { low: shape.bounds.low - reach, high: shape.bounds.high + reach };
            let mut near: Vec<usize> = Vec::new();
            self.visit(
                |bounds| bounds.common(&around).is_some(),
                |other| {
                    if other != index && counts(other) && self.are_level([index, other]) {
                        near.push(other);
                    }
                    false
                },
            );
            near.sort_unstable();
            near.into_iter().find_map(|other| overlap([index, other], [polygon, polygons[other]]))
        })
    }

    /// Whether a polygon and any of those that count have points in front of each other, as surfaces.
    pub(crate) fn faces_any(&self, index: usize, counts: impl Fn(usize) -> bool) -> bool {
        let shape = &self.polygons[index];
        let front = shape.front(true);
        let before = |bounds: &Bounds| !front.excludes_box(&shape.frame.locate(bounds.low), &shape.frame.locate(bounds.high));
        self.visit(before, |other| {
            other != index && counts(other) && !self.is_behind(other, index) && !self.is_behind(index, other)
        })
    }

    /// Visits the polygons that may see a polygon, as surfaces: all that have a point in front of it, but for those in boxes that are
    /// passed over: `enter` is told which places of [`Self::order`] are in a box, and its corners.
    pub(crate) fn facing(&self, index: usize, enter: impl Fn(Range<usize>, [DVec3; 8]) -> bool, mut visit: impl FnMut(usize)) {
        let shape = &self.polygons[index];
        let front = shape.front(true);
        let mut open: Vec<usize> = self.tree.root().into_iter().collect();
        while let Some(at) = open.pop() {
            let node = &self.tree.nodes[at];
            let [low, high] = [node.bounds.low, node.bounds.high].map(|corner| shape.frame.locate(corner));
            if front.excludes_box(&low, &high) || !enter(node.range.clone(), node.bounds.corners()) {
                continue;
            }
            match &node.content {
                Content::Branch(children) => open.extend(children),
                Content::Leaf => {
                    self.tree.order[node.range.clone()].iter().copied().filter(|&other| other != index).for_each(&mut visit);
                }
            }
        }
    }

    /// All polygons, those of a box one after the other.
    pub(crate) fn order(&self) -> &[usize] {
        &self.tree.order
    }

    /// Whether a polygon is nowhere in front of another, as surfaces.
    pub(crate) fn is_behind(&self, index: usize, of: usize) -> bool {
        let of = &self.polygons[of];
        of.front(true).excludes(self.polygons[index].vertices.iter().map(|&v| of.frame.locate(v)))
    }

    fn are_level(&self, [a, b]: [usize; 2]) -> bool {
        self.is_behind(a, b) && self.is_behind(b, a)
    }

    /// Visits the polygons in the boxes that `enters`, until `visit` returns true; whether it did.
    pub(super) fn visit(&self, enters: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(usize) -> bool) -> bool {
        let mut open = Vec::with_capacity(64);
        open.extend(self.tree.root());
        while let Some(index) = open.pop() {
            let node = &self.tree.nodes[index];
            if !enters(&node.bounds) {
                continue;
            }
            match &node.content {
                Content::Branch(children) => open.extend(children),
                Content::Leaf => {
                    let polygons = self.tree.order[node.range.clone()].iter();
                    if polygons.copied().any(|polygon| enters(&self.polygons[polygon].bounds) && visit(polygon)) {
                        return true;
                    }
                }
            }
        }
        false
    }
}

/// The overlap of two polygons that are level with each other, if they face the same way.
fn overlap(indices: [usize; 2], [a, b]: [&Polygon; 2]) -> Option<Overlap> {
    if a.normal().dot(b.normal()) <= 0.5 {
        return None;
    }
    let (along, across) = a.normal().any_orthonormal_pair();
    let origin = a.vertices()[0];
    let flat = |v: DVec3| [along.dot(v - origin), across.dot(v - origin)];
    let parts = |polygon: &Polygon| -> Option<Vec<[[f64; 2]; 3]>> {
        let corners = polygon.vertices();
        Some(triangles(corners)?.into_iter().map(|triangle| triangle.map(|i| flat(corners[i]))).collect())
    };
    let (of_a, of_b) = (parts(a)?, parts(b)?);
    let (mut area, mut widest) = (0.0, (0.0, [0.0; 2]));
    for first in &of_a {
        for second in &of_b {
            let common = clip(first, second);
            let part = area_of(&common);
            area += part;
            if part > widest.0 {
                let count = common.len() as f64;
                let sum = common.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
                widest = (part, sum.map(|sum| sum / count));
            }
        }
    }
    if area <= SLIVER * (perimeter(a.vertices()) + perimeter(b.vertices())) * largest(largest_of(a), largest_of(b)) {
        return None;
    }
    let (at, [first, second]) = (origin + along * widest.1[0] + across * widest.1[1], indices);
    let polygons = [first.min(second), first.max(second)];
    Some(Overlap { polygons, at, share: area / smallest(a.area(), b.area()) })
}

/// The part of a triangle that is in another, both counter-clockwise (I. Sutherland and G. Hodgman 1974).
fn clip(triangle: &[[f64; 2]; 3], by: &[[f64; 2]; 3]) -> Vec<[f64; 2]> {
    (0..3).fold(triangle.to_vec(), |rest, edge| {
        let (from, to) = (by[edge], by[(edge + 1) % 3]);
        let inside = |p: &[f64; 2]| (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
        let heights: Vec<f64> = rest.iter().map(inside).collect();
        above(&rest, &heights, |here, next, t| [0, 1].map(|k| here[k] + t * (next[k] - here[k])))
    })
}

/// The part of an outline where heights, given at its corners, are not negative: one step of Sutherland and Hodgman. `between` gives
/// the point at a share of the way from a corner to the next.
pub(crate) fn above<P: Copy>(outline: &[P], heights: &[f64], between: impl Fn(P, P, f64) -> P) -> Vec<P> {
    let mut kept = Vec::with_capacity(outline.len() + 2);
    for (i, (&here, &h)) in outline.iter().zip(heights).enumerate() {
        let j = (i + 1) % outline.len();
        if h >= 0.0 {
            kept.push(here);
        }
        if (h > 0.0 && heights[j] < 0.0) || (h < 0.0 && heights[j] > 0.0) {
            kept.push(between(here, outline[j], h / (h - heights[j])));
        }
    }
    kept
}

/// Between two places, at a share of the way.
pub(crate) fn on_the_way(here: DVec3, next: DVec3, share: f64) -> DVec3 {
    here + (next - here) * share
}

fn area_of(outline: &[[f64; 2]]) -> f64 {
    let Some((origin, rest)) = outline.split_first() else { return 0.0 };
    let across = |pair: &[[f64; 2]]| {
        let [a, b] = [pair[0], pair[1]].map(|p| [p[0] - origin[0], p[1] - origin[1]]);
        a[0] * b[1] - a[1] * b[0]
    };
    0.5 * rest.windows(2).map(across).sum::<f64>()
}

pub(crate) fn perimeter(outline: &[DVec3]) -> f64 {
    (0..outline.len()).map(|i| (outline[(i + 1) % outline.len()] - outline[i]).length()).sum()
}

fn largest_of(polygon: &Polygon) -> f64 {
    polygon.vertices().iter().map(|v| v.abs().max_element()).fold(0.0, largest)
}
