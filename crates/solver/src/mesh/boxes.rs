//! Boxes that are near a box, of very many.

use std::ops::Range;

use radgrad_core::DVec3;
use radgrad_scene::largest;

/// Boxes in a node that is not divided.
const LEAF: usize = 8;

/// Boxes in halves of halves along the longest side of their middles' box.
pub(super) struct Boxes<'a> {
    boxes: &'a [[DVec3; 2]],
    order: Vec<usize>,
    /// Each before those of its two halves.
    nodes: Vec<Node>,
}

struct Node {
    around: [DVec3; 2],
    /// The longest side of a box.
    longest: f64,
    range: Range<usize>,
    /// The node of its second half; the first one follows it.
    second: Option<usize>,
}

impl<'a> Boxes<'a> {
    pub(super) fn new(boxes: &'a [[DVec3; 2]]) -> Self {
        let mut tree = Self { boxes, order: (0..boxes.len()).collect(), nodes: Vec::new() };
        let mut order = std::mem::take(&mut tree.order);
        tree.divide(&mut order, 0);
        Self { order, ..tree }
    }

    fn divide(&mut self, order: &mut [usize], first: usize) {
        let boxes = self.boxes;
        let join = |[low, high]: [DVec3; 2], [from, to]: [DVec3; 2]| [low.min(from), high.max(to)];
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let around = order.iter().map(|&at| boxes[at]).fold(none, join);
        let longest = order.iter().map(|&at| (boxes[at][1] - boxes[at][0]).max_element()).fold(0.0, largest);
        let node = self.nodes.len();
        self.nodes.push(Node { around, longest, range: first..first + order.len(), second: None });
        if order.len() <= LEAF {
            return;
        }
        let middle = |at: usize| 0.5 * boxes[at][0] + 0.5 * boxes[at][1];
        let [low, high] = order.iter().map(|&at| [middle(at); 2]).fold(none, join);
        let (axis, half) = ((high - low).max_position(), order.len() / 2);
        order.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let (lower, upper) = order.split_at_mut(half);
        self.divide(lower, first);
        self.nodes[node].second = Some(self.nodes.len());
        self.divide(upper, first + half);
    }

    /// Those whose box, wider by `part` of its longest side on every side, may meet a box that is wider by `own`, ascending, with some others.
    pub(super) fn near(&self, [low, high]: [DVec3; 2], own: f64, part: f64) -> Vec<usize> {
        let (mut hits, mut open) = (Vec::new(), vec![0]);
        while let Some(at) = open.pop() {
            let Node { around: [from, to], longest, range, second } = &self.nodes[at];
            let reach = DVec3::splat(own + part * longest);
            if !(from.cmple(high + reach).all() && to.cmpge(low - reach).all()) {
                continue;
            }
            match second {
                Some(second) => open.extend([at + 1, *second]),
                None => hits.extend_from_slice(&self.order[range.clone()]),
            }
        }
        hits.sort_unstable();
        hits
    }
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
        let index = Boxes::new(&boxes);
        let (mut met, mut looked_at) = (0, 0);
        for own in &boxes {
            for part in [0.0, 0.8] {
                let hits = index.near(*own, 1e-9, part);
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
        assert_eq!(Boxes::new(&[]).near([DVec3::ZERO; 2], 1.0, 1.0), [0; 0]);
    }
}
