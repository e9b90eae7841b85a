//! The polygons of a scene that may hide a part of an emitter from a receiver: a tree of boxes, searched by a [`Beam`].
//!
//! A polygon that is not found is proven to hide nothing: every test in [`beam`] covers its rounding, and boxes are exact, lowest
//! and highest coordinates without arithmetic. One that is found may still hide nothing. A search visits the boxes that meet the
//! beam and their siblings: it costs little beyond the boxes in the beam. [`Found`] counts both.

pub(crate) mod beam;
pub(crate) mod half_space;
mod hull;
pub(crate) mod level;
pub(crate) mod overlap;
mod rays;
pub(crate) mod segment;
pub(crate) mod shape;
#[cfg(test)]
mod tests;
pub(crate) mod tree;

use radgrad_core::{DVec3, Polygon};

use self::beam::Beam;
use self::rays::Rays;
use self::shape::{Bounds, Shape};
use self::tree::{Content, Tree};

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
/// let hiding = found.polygons.iter().map(|&k| &scene[k]);
/// assert_eq!(evaluate(&receiver, &lamp, hiding), evaluate(&receiver, &lamp, &scene[1..]));
/// ```
#[derive(Debug, Clone)]
pub struct Occluders {
    tree: Tree,
    polygons: Vec<Shape>,
    rays: Rays,
}

/// Boxes, each with its lowest and highest coordinates, searched for those that a box meets.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Boxes(Tree);

impl Boxes {
    #[must_use]
    pub fn new(boxes: &[[DVec3; 2]]) -> Self {
        Self(Tree::over(&boxes.iter().map(|corners| Bounds::of(corners)).collect::<Vec<_>>()))
    }

    /// The places of all boxes that meet a box, and of some more that are near, ascending.
    #[must_use]
    pub fn near(&self, corners: [DVec3; 2]) -> Vec<usize> {
        let mut near = Vec::new();
        self.0.near(&Bounds::of(&corners), |place| near.push(place));
        near.sort_unstable();
        near
    }
}

/// The polygons that a search found, and the boxes and polygons it tested.
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
    /// An index of polygons, numbered from 0 in their order. It copies the coordinates that it needs.
    pub fn new<'a>(polygons: impl IntoIterator<Item = &'a Polygon>) -> Self {
        let polygons: Vec<Shape> = polygons.into_iter().map(Shape::of).collect();
        let tree = Tree::over(&polygons.iter().map(|polygon| polygon.bounds).collect::<Vec<_>>());
        Self { rays: Rays::of(&tree, &polygons), tree, polygons }
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
        self.in_beam_of(&self.tree, beam, leave_out)
    }

    /// The same of the polygons of a tree.
    pub(crate) fn in_beam_of(&self, tree: &Tree, beam: &Beam, leave_out: &[usize]) -> Found {
        let mut found = Found::default();
        let mut open = Vec::with_capacity(64);
        open.extend(tree.root());
        while let Some(index) = open.pop() {
            let node = &tree.nodes[index];
            found.boxes_tested += 1;
            if beam.misses_box(&node.bounds) {
                continue;
            }
            match &node.content {
                Content::Branch(children) => open.extend(children),
                Content::Leaf => self.test(beam, &tree.order[node.range.clone()], leave_out, &mut found),
            }
        }
        found.polygons.sort_unstable();
        found
    }

    /// The same among `candidates`, those found in a wider beam, such as that of a whole receiver when the beam is of one of its
    /// points. Indices of no polygon are passed over.
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
