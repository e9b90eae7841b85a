//! The polygons of a scene that may hide a part of an emitter from a receiver: a tree of boxes, searched by a [`Beam`].
//!
//! What is not found is proven to hide nothing: every test in [`beam`] covers its rounding, and boxes are exact, lowest and
//! highest coordinates without arithmetic. What is found may still hide nothing. A search visits the boxes that meet the beam and
//! their siblings, so that it costs what is in the beam, and little for what is elsewhere; [`Found`] counts both.
//!
//! The tree is built from the top, each split where the expected work of a search is least (surface area heuristic over bins of
//! equal width: `MacDonald` and Booth 1990, Wald 2007).

mod beam;
mod half_space;
mod hull;
mod shape;
#[cfg(test)]
mod tests;

use std::ops::Range;

use radgrad_core::Polygon;

pub use beam::Beam;
use shape::{Bounds, Shape};

/// Polygons in a leaf, at most.
const LEAF: usize = 4;

/// Bins that centres are sorted into before a split.
const BINS: usize = 16;

/// An index of polygons for searches by [`Beam`].
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
/// use radgrad_scene::{Beam, Occluders};
/// let square = |low: f64, z: f64| {
///     let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]; // counter-clockwise from below
///     Polygon::new(corners.map(|(x, y)| DVec3::new(x + low, y + low, z)).to_vec()).unwrap()
/// };
/// let [lamp, screen, aside, above] = [square(0.0, 1.0), square(0.5, 0.5), square(3.0, 0.5), square(0.0, 2.0)];
/// let scene = [lamp.clone(), screen, aside, above];
/// let receiver = Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0).unwrap();
///
/// let index = Occluders::new(&scene);
/// let beam = Beam::from_receiver(&receiver, &lamp).expect("the receiver is in front of the lamp");
/// let found = index.in_beam(&beam, &[0]); // the lamp itself hides nothing
/// assert_eq!(found.polygons, [1]);
///
/// let lamp = Emitter::new(lamp, Emission::Constant(1.0)).unwrap();
/// let hiding = [scene[1].clone()];
/// assert_eq!(evaluate(&receiver, &lamp, &hiding), evaluate(&receiver, &lamp, &scene[1..]));
/// ```
#[derive(Debug, Clone)]
pub struct Occluders {
    nodes: Vec<Node>,
    /// Polygons in the order of the leaves.
    order: Vec<usize>,
    polygons: Vec<Shape>,
}

#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    /// A part of the order of polygons.
    Leaf(Range<usize>),
    /// The node next to this one, and this one.
    Branch(usize),
}

/// What a search found, and what it cost.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Found {
    /// Indices of the polygons that may hide something, ascending.
    pub polygons: Vec<usize>,
    /// Boxes that were compared with the beam.
    pub boxes_tested: usize,
    /// Polygons that were compared with the beam.
    pub polygons_tested: usize,
}

impl Occluders {
    /// An index of polygons, numbered from 0 in their order. It keeps what it needs of them.
    pub fn new<'a>(polygons: impl IntoIterator<Item = &'a Polygon>) -> Self {
        let polygons: Vec<Shape> = polygons.into_iter().map(Shape::of).collect();
        let mut order: Vec<usize> = (0..polygons.len()).collect();
        let mut nodes = Vec::with_capacity(polygons.len());
        if !order.is_empty() {
            build(&mut nodes, &mut order, 0, &polygons);
        }
        Self { nodes, order, polygons }
    }

    /// Number of polygons.
    #[must_use]
    pub fn len(&self) -> usize {
        self.polygons.len()
    }

    /// Whether there are no polygons.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// The polygons that may hide a part of the beam's emitter from its receiver, but for those of `leave_out`: the emitter and
    /// the polygon that the receiver is on.
    #[must_use]
    pub fn in_beam(&self, beam: &Beam, leave_out: &[usize]) -> Found {
        let mut found = Found::default();
        let mut open = Vec::with_capacity(64);
        open.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(index) = open.pop() {
            let node: &Node = &self.nodes[index];
            found.boxes_tested += 1;
            if beam.misses_box(&node.bounds) {
                continue;
            }
            match &node.content {
                Content::Branch(second) => open.extend([*second, index + 1]),
                Content::Leaf(range) => self.test(beam, &self.order[range.clone()], leave_out, &mut found),
            }
        }
        found.polygons.sort_unstable();
        found
    }

    /// The same among `candidates`, those found in a wider beam: for one point of a receiver what was found for all of it. Indices
    /// of no polygon are passed over.
    #[must_use]
    pub fn among(&self, beam: &Beam, candidates: &[usize], leave_out: &[usize]) -> Found {
        let mut found = Found::default();
        self.test(beam, candidates, leave_out, &mut found);
        found
    }

    fn test(&self, beam: &Beam, candidates: &[usize], leave_out: &[usize], found: &mut Found) {
        for &index in candidates.iter().filter(|index| !leave_out.contains(index)) {
            let Some(polygon) = self.polygons.get(index) else { continue };
            found.polygons_tested += 1;
            if !beam.misses_polygon(polygon) {
                found.polygons.push(index);
            }
        }
    }
}

/// Adds the node over `order`, which starts at `first` of the whole, with all below it.
fn build(nodes: &mut Vec<Node>, order: &mut [usize], first: usize, polygons: &[Shape]) {
    let whole = order.iter().fold(Bounds::NONE, |sum, &i| sum.and(&polygons[i].bounds));
    let index = nodes.len();
    let leaf = Content::Leaf(first..first + order.len());
    nodes.push(Node { bounds: whole, content: leaf });
    if order.len() <= LEAF {
        return;
    }
    let middle = split(order, polygons, &whole);
    let (left, right) = order.split_at_mut(middle);
    build(nodes, left, first, polygons);
    nodes[index].content = Content::Branch(nodes.len());
    build(nodes, right, first + middle, polygons);
}

/// Sorts the polygons into two parts, neither empty, and returns where the second starts.
fn split(order: &mut [usize], polygons: &[Shape], whole: &Bounds) -> usize {
    let unit = (whole.high - whole.low).max_element();
    let mut best: Option<(f64, usize, usize)> = None;
    let range = |axis: usize| {
        let centres = order.iter().map(|&i| polygons[i].bounds.centre(axis));
        centres.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
    };
    let ranges = [0, 1, 2].map(range);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast saturates: from 0, and then to the last bin"
    )]
    let bin = |axis: usize, polygon: usize| {
        let (low, high) = ranges[axis];
        let place = (polygons[polygon].bounds.centre(axis) - low) / (high - low) * BINS as f64;
        (place as usize).min(BINS - 1)
    };
    for axis in (0..3).filter(|&axis| ranges[axis].0 < ranges[axis].1) {
        let mut bins = [(0_usize, Bounds::NONE); BINS];
        for &polygon in order.iter() {
            let (count, sum) = &mut bins[bin(axis, polygon)];
            (*count, *sum) = (*count + 1, sum.and(&polygons[polygon].bounds));
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
