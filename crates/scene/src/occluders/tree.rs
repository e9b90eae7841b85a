//! A tree of boxes over polygons, built from the top: each split where the expected work of a search is least (surface area
//! heuristic over bins of equal width: `MacDonald` and Booth 1990, Wald 2007).

use std::ops::Range;

use super::shape::Bounds;
use crate::extremes::{largest, smallest};

/// Polygons in a leaf, at most.
const LEAF: usize = 4;

/// Bins that centres are sorted into before a split.
const BINS: usize = 16;

/// Boxes in boxes. A node's first child follows it.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    pub(super) nodes: Vec<Node>,
    /// Polygons in the order of the leaves.
    pub(super) order: Vec<usize>,
}

#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) bounds: Bounds,
    pub(super) content: Content,
    /// The part of the order of polygons that is below it.
    pub(super) range: Range<usize>,
}

#[derive(Debug, Clone)]
pub(super) enum Content {
    /// Polygons: all of its range.
    Leaf,
    /// Two nodes.
    Branch([usize; 2]),
}

impl Tree {
    pub(crate) fn over(boxes: &[Bounds]) -> Self {
        Self::of((0..boxes.len()).collect(), boxes)
    }

    /// Of some polygons, by their places among the boxes.
    pub(super) fn of(mut order: Vec<usize>, boxes: &[Bounds]) -> Self {
        let mut nodes = Vec::with_capacity(order.len());
        if !order.is_empty() {
            build(&mut nodes, &mut order, 0, boxes);
        }
        Self { nodes, order }
    }

    /// Visits what is in leaves whose boxes meet a box.
    pub(crate) fn near(&self, bounds: &Bounds, mut visit: impl FnMut(usize)) {
        let mut open: Vec<usize> = self.root().into_iter().collect();
        while let Some(node) = open.pop().map(|node| &self.nodes[node]) {
            if node.bounds.common(bounds).is_some() {
                match &node.content {
                    Content::Branch(children) => open.extend(children),
                    Content::Leaf => self.order[node.range.clone()].iter().copied().for_each(&mut visit),
                }
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The node over all, if there are polygons.
    pub(super) fn root(&self) -> Option<usize> {
        (!self.nodes.is_empty()).then_some(0)
    }
}

/// Adds the node over `order`, which starts at `first` of the whole, with all below it.
fn build(nodes: &mut Vec<Node>, order: &mut [usize], first: usize, boxes: &[Bounds]) {
    let whole = order.iter().fold(Bounds::NONE, |sum, &i| sum.and(&boxes[i]));
    let index = nodes.len();
    nodes.push(Node { bounds: whole, content: Content::Leaf, range: first..first + order.len() });
    if order.len() <= LEAF {
        return;
    }
    let middle = split(order, boxes, &whole);
    let (left, right) = order.split_at_mut(middle);
    build(nodes, left, first, boxes);
    nodes[index].content = Content::Branch([nodes.len(), index + 1]);
    build(nodes, right, first + middle, boxes);
}

/// Sorts the polygons into two parts, neither empty, and returns where the second starts.
fn split(order: &mut [usize], boxes: &[Bounds], whole: &Bounds) -> usize {
    let unit = (whole.high - whole.low).max_element();
    let mut best: Option<(f64, usize, usize)> = None;
    let range = |axis: usize| {
        let centres = order.iter().map(|&i| boxes[i].centre(axis));
        centres.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (smallest(low, c), largest(high, c)))
    };
    let ranges = [0, 1, 2].map(range);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast saturates: from 0, and then to the last bin"
    )]
    let bin = |axis: usize, polygon: usize| {
        let (low, high) = ranges[axis];
        let place = (boxes[polygon].centre(axis) - low) / (high - low) * BINS as f64;
        (place as usize).min(BINS - 1)
    };
    for axis in (0..3).filter(|&axis| ranges[axis].0 < ranges[axis].1) {
        let mut bins = [(0_usize, Bounds::NONE); BINS];
        for &polygon in order.iter() {
            let (count, sum) = &mut bins[bin(axis, polygon)];
            (*count, *sum) = (*count + 1, sum.and(&boxes[polygon]));
        }
        for cut in 1..BINS {
            let cost = |part: &[(usize, Bounds)]| {
                let count: usize = part.iter().map(|(count, _)| count).sum();
                let sum = part.iter().fold(Bounds::NONE, |sum, (_, bounds)| sum.and(bounds));
                (count > 0).then(|| count as f64 * sum.surface(unit))
            };
            let (low, high) = bins.split_at(cut);
            let (Some(low), Some(high)) = (cost(low), cost(high)) else { continue };
            if best.is_none_or(|(least, _, _)| low + high < least) {
                best = Some((low + high, axis, cut));
            }
        }
    }
    // All centres in one point: any halves will do.
    let Some((_, axis, cut)) = best else { return order.len() / 2 };
    let mut middle = 0;
    for i in 0..order.len() {
        if bin(axis, order[i]) < cut {
            order.swap(i, middle);
            middle += 1;
        }
    }
    middle
}
