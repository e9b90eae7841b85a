//! What is around a polygon and before it, as surfaces, and the cuts of outlines.

use std::ops::Range;

use radgrad_core::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::Occluders;
use super::shape::{Bounds, Shape};
use super::tree::{Content, Tree};

impl Occluders {
    /// Visits the polygons whose boxes are within a distance of a polygon's, but for itself.
    pub(crate) fn around(&self, index: usize, distance: f64, mut visit: impl FnMut(usize)) {
        let Bounds { low, high } = self.polygons[index].bounds;
        let around = Bounds { low: low - DVec3::splat(distance), high: high + DVec3::splat(distance) };
        self.visit(
            |bounds| bounds.common(&around).is_some(),
            |other| {
                if other != index {
                    visit(other);
                }
                false
            },
        );
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

    /// The polygons that may hide one of them from another: those with any behind them, as surfaces. The walls of a convex room have none.
    pub(crate) fn hiders(&self) -> Tree {
        let has_any_behind = |shape: &Shape| {
            let front = shape.front(true);
            let has_a_point_behind =
                |bounds: &Bounds| !front.holds_box(&shape.frame.locate(bounds.low), &shape.frame.locate(bounds.high));
            let is_behind = |other: usize| !front.holds(self.polygons[other].vertices.iter().map(|&v| shape.frame.locate(v)));
            self.visit(has_a_point_behind, is_behind)
        };
        let order = (0..self.polygons.len()).into_par_iter().filter(|&index| has_any_behind(&self.polygons[index])).collect();
        Tree::of(order, &self.polygons.iter().map(|polygon| polygon.bounds).collect::<Vec<_>>())
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

    /// Visits the polygons in the boxes that `enters`, until `visit` returns true; whether it did.
    pub(super) fn visit(&self, enters: impl Fn(&Bounds) -> bool, visit: impl FnMut(usize) -> bool) -> bool {
        self.visit_of(&self.tree, enters, visit)
    }

    /// The same of the polygons of a tree.
    pub(crate) fn visit_of(&self, tree: &Tree, enters: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(usize) -> bool) -> bool {
        let mut open: SmallVec<[usize; 64]> = SmallVec::new();
        open.extend(tree.root());
        while let Some(index) = open.pop() {
            let node = &tree.nodes[index];
            if !enters(&node.bounds) {
                continue;
            }
            match &node.content {
                Content::Branch(children) => open.extend_from_slice(children),
                Content::Leaf => {
                    let polygons = tree.order[node.range.clone()].iter();
                    if polygons.copied().any(|polygon| enters(&self.polygons[polygon].bounds) && visit(polygon)) {
                        return true;
                    }
                }
            }
        }
        false
    }
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

pub(crate) fn perimeter(outline: &[DVec3]) -> f64 {
    (0..outline.len()).map(|i| (outline[(i + 1) % outline.len()] - outline[i]).length()).sum()
}
