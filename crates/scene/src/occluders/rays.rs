//! What rays need of the tree and of its polygons. A ray visits tens of boxes and a few polygons, and most of its time goes for comparing it
//! with boxes.
//!
//! The boxes of the two parts of a branch lie side by side, axis by axis: a ray is compared with both at once. It goes on to the nearer one at
//! once, too; only the farther one is put off.
//!
//! # Back to back
//! Of two faces in one plane, back to back as the sides of a thin plate, a ray meets the one that it faces; which of the two is nearer is a
//! matter of rounding. So the nearest front counts if the nearest back is not before it by more than rounding, whatever order they are met in.

use std::ops::Range;

use glam::DVec2;
use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::LEVEL;
use super::shape::Shape;
use super::tree::{Content, Tree};
use crate::smallest;

/// Nodes that a ray has yet to visit, beyond which their list moves to the heap.
const OPEN: usize = 64;

/// A copy of the tree, with what rays need of its polygons.
#[derive(Debug, Clone, Default)]
pub(super) struct Rays {
    /// The box over all, and where the tree begins.
    root: Option<([DVec3; 2], Node)>,
    branches: Vec<Branch>,
    /// Polygons in the order of the leaves, and their corners in the plane of the two axes that each is seen best along.
    facets: Vec<Facet>,
    corners: Vec<[f64; 2]>,
}

/// The boxes of two nodes, and the nodes: each axis has the lowest and the highest coordinates of both boxes.
#[derive(Debug, Clone)]
struct Branch {
    low: [DVec2; 3],
    high: [DVec2; 3],
    parts: [Node; 2],
}

/// A branch by its place; or, if the highest bit is set, the first facet of a leaf and, in the lowest three bits, how many there are.
#[derive(Debug, Clone, Copy)]
struct Node(u32);

impl Node {
    const LEAF: u32 = 1 << 31;

    fn leaf(range: &Range<usize>) -> Self {
        debug_assert!(range.len() < 8, "{range:?}");
        Self(Self::LEAF | short(range.start << 3 | range.len()))
    }

    const fn facets(self) -> Option<Range<usize>> {
        if self.0 & Self::LEAF == 0 {
            return None;
        }
        let start = (self.0 & !Self::LEAF) as usize >> 3;
        Some(start..start + (self.0 & 7) as usize)
    }
}

#[derive(Debug, Clone)]
struct Facet {
    polygon: usize,
    origin: DVec3,
    /// As long as twice the area, which is `size`.
    normal: DVec3,
    size: f64,
    axes: [u8; 2],
    corners: Range<u32>,
}

impl Rays {
    pub(super) fn of(tree: &Tree, polygons: &[Shape]) -> Self {
        let mut rays = Self::default();
        for &polygon in &tree.order {
            let Shape { vertices, turning, .. } = &polygons[polygon];
            let axes = best_axes(*turning);
            let first = rays.corners.len();
            rays.corners.extend(vertices.iter().map(|v| axes.map(|axis| v[usize::from(axis)])));
            let corners = short(first)..short(rays.corners.len());
            rays.facets.push(Facet { polygon, origin: vertices[0], normal: *turning, size: turning.length(), axes, corners });
        }
        // For each node, how many branches are before it: for a branch, its place among them.
        let (mut places, mut count) = (Vec::with_capacity(tree.nodes.len()), 0);
        for of in &tree.nodes {
            places.push(count);
            count += usize::from(matches!(of.content, Content::Branch(_)));
        }
        let node = |index: usize| match tree.nodes[index].content {
            Content::Branch(_) => Node(short(places[index])),
            Content::Leaf => Node::leaf(&tree.nodes[index].range),
        };
        for of in &tree.nodes {
            if let Content::Branch(parts) = of.content {
                let bounds = parts.map(|part| &tree.nodes[part].bounds);
                let [low, high] = [bounds.map(|of| of.low), bounds.map(|of| of.high)]
                    .map(|ends| [0, 1, 2].map(|axis| DVec2::from(ends.map(|end| end[axis]))));
                rays.branches.push(Branch { low, high, parts: parts.map(node) });
            }
        }
        rays.root = tree.root().map(|root| ([tree.nodes[root].bounds.low, tree.nodes[root].bounds.high], node(root)));
        rays
    }

    /// The first polygon that a ray meets, but for those of `leave_out`, and how many times its direction that is away: of those at one
    /// distance, up to rounding, one that it meets from the front.
    pub(super) fn first(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<(usize, f64)> {
        let ([low, high], root) = self.root?;
        let ray = Ray { from: from.to_array(), inverse: inverse(toward).to_array() };
        let both = |end: DVec3| end.to_array().map(DVec2::splat);
        let mut open: SmallVec<[(Node, f64); OPEN]> = SmallVec::new();
        let mut nearest = Nearest::default();
        let mut next = ray.enters(&both(low), &both(high))[0].map(|_| root);
        while let Some(node) = next {
            next = None;
            if let Some(facets) = node.facets() {
                for facet in &self.facets[facets] {
                    if let Some(hit) = self.meets(facet, from, toward, &nearest).filter(|_| !leave_out.contains(&facet.polygon)) {
                        nearest.take(hit);
                    }
                }
            } else {
                let Branch { low, high, parts: [a, b] } = &self.branches[node.0 as usize];
                // The nearer one is taken first.
                next = match ray.enters(low, high) {
                    [Some(to_a), Some(to_b)] => {
                        let [near, far] = if to_a < to_b { [*a, *b] } else { [*b, *a] };
                        open.push((far, if to_a < to_b { to_b } else { to_a }));
                        Some(near)
                    }
                    [Some(_), None] => Some(*a),
                    [None, Some(_)] => Some(*b),
                    [None, None] => None,
                };
            }
            while next.is_none()
                && let Some((node, enters_at)) = open.pop()
            {
                next = (enters_at <= nearest.farthest() * (1.0 + LEVEL)).then_some(node);
            }
        }
        nearest.first().map(|hit| (hit.polygon, hit.distance))
    }

    /// Where a ray goes to the inside of a polygon that may be the first.
    fn meets(&self, facet: &Facet, from: DVec3, toward: DVec3, nearest: &Nearest) -> Option<Hit> {
        let (above, falls) = (facet.normal.dot(from - facet.origin), -facet.normal.dot(toward));
        if above * falls <= 0.0 {
            return None;
        }
        let (distance, is_front) = (above / falls, falls > 0.0);
        if !(distance < nearest.limit(is_front) && distance.is_finite()) {
            return None;
        }
        let reach = (from - facet.origin).length();
        if above.abs() <= LEVEL * facet.size * reach {
            return None;
        }
        let point = from + toward * distance;
        let corners = &self.corners[facet.corners.start as usize..facet.corners.end as usize];
        if !is_inside(corners, facet.axes.map(|axis| point[usize::from(axis)])) {
            return None;
        }
        let beside = LEVEL * facet.size * (reach + distance * toward.length());
        Some(Hit { polygon: facet.polygon, distance, last: distance + beside / falls.abs(), is_front })
    }
}

/// Where a ray meets a polygon.
#[derive(Debug, Clone, Copy)]
struct Hit {
    polygon: usize,
    /// How many times its direction the ray goes to the plane, and to what is behind it by no more than rounding.
    distance: f64,
    last: f64,
    is_front: bool,
}

/// The nearest polygons that a ray meets from the front and from behind.
#[derive(Debug, Default)]
struct Nearest {
    front: Option<Hit>,
    back: Option<Hit>,
}

impl Nearest {
    /// The distance below which a polygon may be the first, by the side that is met.
    fn limit(&self, is_front: bool) -> f64 {
        let front = self.front.map_or(f64::INFINITY, |hit| hit.distance);
        let back = self.back.map_or(f64::INFINITY, |hit| if is_front { hit.last } else { hit.distance });
        smallest(front, back)
    }

    /// The distance beyond which no polygon is the first.
    fn farthest(&self) -> f64 {
        self.limit(true)
    }

    /// Takes a hit within its limit.
    fn take(&mut self, hit: Hit) {
        *(if hit.is_front { &mut self.front } else { &mut self.back }) = Some(hit);
    }

    fn first(&self) -> Option<&Hit> {
        let is_beside = |front: &&Hit| self.back.is_none_or(|back| front.distance <= back.last);
        self.front.as_ref().filter(is_beside).or(self.back.as_ref())
    }
}

/// A place, and one over each component of the direction from there.
struct Ray {
    from: [f64; 3],
    inverse: [f64; 3],
}

impl Ray {
    /// How many times its direction a ray goes to each of two boxes, if it meets them.
    fn enters(&self, low: &[DVec2; 3], high: &[DVec2; 3]) -> [Option<f64>; 2] {
        let along = |axis: usize| {
            let [a, b] = [low, high].map(|ends| (ends[axis] - DVec2::splat(self.from[axis])) * DVec2::splat(self.inverse[axis]));
            [a.min(b), a.max(b)]
        };
        let [[near_x, far_x], [near_y, far_y], [near_z, far_z]] = [along(0), along(1), along(2)];
        let (first, last) = (near_x.max(near_y).max(near_z), far_x.min(far_y).min(far_z));
        let meets = last.cmpge(DVec2::ZERO) & first.cmple(last + last.abs() * LEVEL);
        [meets.x.then_some(first.x), meets.y.then_some(first.y)]
    }
}

/// One over each component of a direction. One of 0 is as good as one that is far below all lengths, and its inverse is finite.
pub(super) fn inverse(along: DVec3) -> DVec3 {
    let steep = |along: f64| if along.abs() < 1e-290 { 1e290 } else { 1.0 / along };
    DVec3::new(steep(along.x), steep(along.y), steep(along.z))
}

/// The two axes along which a polygon of this normal covers most.
pub(super) fn best_axes(normal: DVec3) -> [u8; 2] {
    let size = normal.abs();
    if size.z >= size.x && size.z >= size.y {
        [0, 1]
    } else if size.y >= size.x {
        [2, 0]
    } else {
        [1, 2]
    }
}

/// Whether a point of the plane is inside a polygon: an odd number of edges is crossed along the first axis.
pub(super) fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut odd = false;
    let Some(&[mut ax, mut ay]) = corners.last() else { return false };
    for &[bx, by] in corners {
        // Both are asked, as which edges are crossed is hard to foretell.
        odd ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax));
        (ax, ay) = (bx, by);
    }
    odd
}

/// A place in a list, which has fewer than 2^32.
#[expect(clippy::cast_possible_truncation, reason = "a list of so many polygons does not fit in memory")]
fn short(place: usize) -> u32 {
    debug_assert!(u32::try_from(place).is_ok(), "{place}");
    place as u32
}
