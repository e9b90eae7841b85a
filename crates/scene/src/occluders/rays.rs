//! The boxes and polygons of the tree as rays need them. A ray visits tens of boxes and a few polygons, and most of its time goes for reading
//! boxes and comparing it with them.
//!
//! # Boxes
//! Four at a time, in single precision and scaled by a power of two to coordinates up to 1: each is the box of the nodes below it, rounded
//! outward and wider by [`WIDER`] on every side. A ray begins at two places for each axis, the doubles around its origin: the lowest coordinates
//! of boxes are held against the upper one, the highest against the lower one, so that a box seems wider than it is. There remains a rounding by
//! `(1 + u)^3` in each quotient, with u = 2^-24 (T. Ize 2013, "Robust BVH ray traversal"): [`ROUNDING`] more than covers it at both ends. So
//! no ray misses the box of a polygon that it meets.
//!
//! # Edges
//! Polygons are asked in double precision, in the plane across the ray: corners are moved along it to where their two coordinates say on
//! which side the ray passes (S. Woop, C. Benthin, I. Wald 2013, "Watertight ray/triangle intersection"). The numbers computed of a
//! corner depend on the ray and the corner alone, and those of an edge on its two corners, with the opposite sign from the other end: so of two
//! polygons that share an edge, on either side of it, every ray meets one.
//!
//! # Back to back
//! Of two faces in one plane, back to back as the sides of a thin plate, a ray meets the one that it faces; which of the two is nearer is a
//! matter of rounding. So the nearest front counts if the nearest back is not before it by more than rounding, whatever order they are met in.

use std::ops::Range;

use glam::Vec4;
use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::shape::{Bounds, LEVEL, Shape};
use super::tree::{Content, Tree};
use crate::extremes::smallest;
use crate::projection::normalising_power;

/// Boxes that are compared at once.
const WIDE: usize = 4;

/// Nodes that a ray has yet to visit, beyond which their list moves to the heap.
const OPEN: usize = 64;

/// By how much a box is wider on every side, in the unit in which coordinates are up to 1.
const WIDER: f64 = 1.0 / (1_u64 << 24) as f64;

/// One more than twice the rounding of the two quotients that are compared: `2 (3 + 3) u`.
const ROUNDING: f32 = 1.0 + 12.0 * 0.5 * f32::EPSILON;

/// A copy of the tree, with planes and corners of its polygons.
#[derive(Debug, Clone, Default)]
pub(super) struct Rays {
    /// Where the tree begins, and the power of two that scales it.
    root: Option<Node>,
    power: f64,
    branches: Vec<Branch>,
    /// Polygons in the order of the leaves, and their corners.
    facets: Vec<Facet>,
    corners: Vec<DVec3>,
}

/// The boxes of up to four nodes, and the nodes: lowest and highest coordinates of all along each axis. A box that is none is met by no ray.
#[derive(Debug, Clone)]
struct Branch {
    ends: [[Vec4; 3]; 2],
    parts: [Node; WIDE],
}

/// A branch by its place; or, if the highest bit is set, the first facet of a leaf and, in the lowest three bits, how many there are.
#[derive(Debug, Clone, Copy)]
struct Node(u32);

impl Node {
    const LEAF: u32 = 1 << 31;
    const NONE: Self = Self(Self::LEAF);

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
    /// As long as twice the area, which is `size`.
    normal: DVec3,
    size: f64,
    polygon: u32,
    corners: Range<u32>,
}

impl Rays {
    pub(super) fn of(tree: &Tree, polygons: &[Shape]) -> Self {
        let mut rays = Self::default();
        for &polygon in &tree.order {
            let Shape { vertices, turning, .. } = &polygons[polygon];
            let first = rays.corners.len();
            rays.corners.extend(vertices);
            let corners = short(first)..short(rays.corners.len());
            rays.facets.push(Facet { polygon: short(polygon), normal: *turning, size: length(*turning), corners });
        }
        let Some(root) = tree.root() else { return rays };
        let Bounds { low, high } = tree.nodes[root].bounds;
        rays.power = normalising_power(low.abs().max(high.abs()).max_element());
        // Branches that have a place, and the nodes that become their parts.
        let whole = [root];
        let mut open = vec![(
            0,
            match tree.nodes[root].content {
                Content::Leaf => SmallVec::from_slice(&whole),
                Content::Branch(parts) => widened(tree, parts),
            },
        )];
        rays.branches.push(Branch::NONE);
        rays.root = Some(Node(0));
        while let Some((at, parts)) = open.pop() {
            let mut branch = Branch::NONE;
            for (slot, &part) in parts.iter().enumerate() {
                let super::tree::Node { bounds, content, range } = &tree.nodes[part];
                branch.set(slot, bounds, rays.power);
                branch.parts[slot] = match *content {
                    Content::Leaf => Node::leaf(range),
                    Content::Branch(parts) => {
                        let place = rays.branches.len();
                        rays.branches.push(Branch::NONE);
                        open.push((place, widened(tree, parts)));
                        Node(short(place))
                    }
                };
            }
            rays.branches[at] = branch;
        }
        rays
    }

    /// Where a ray first meets a polygon, but for those of `leave_out`: of those at one distance, up to rounding, one that it meets from the
    /// front.
    pub(super) fn first(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<Hit> {
        let ray = Ray::new(from, toward)?;
        let boxes = ray.before_boxes(self.power);
        let mut open: SmallVec<[(Node, f32); OPEN]> = SmallVec::new();
        let mut nearest = Nearest::default();
        let mut limit = f32::INFINITY;
        let mut next = self.root;
        while let Some(node) = next {
            next = None;
            if let Some(facets) = node.facets() {
                for facet in &self.facets[facets] {
                    if let Some(hit) =
                        self.meets(facet, &ray, &nearest).filter(|_| !leave_out.contains(&(facet.polygon as usize)))
                    {
                        nearest.take(hit);
                        limit = ray.in_boxes(nearest.farthest(), self.power);
                    }
                }
            } else {
                let branch = &self.branches[node.0 as usize];
                let (enters, mut met) = boxes.enters(branch, limit);
                // The nearest one is taken first; the others wait, the nearest of them last.
                let waiting = open.len();
                while met != 0 {
                    let slot = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let mut at = open.len();
                    open.push((branch.parts[slot], enters[slot]));
                    while at > waiting && open[at - 1].1 < enters[slot] {
                        open.swap(at - 1, at);
                        at -= 1;
                    }
                }
            }
            while next.is_none()
                && let Some((node, enters_at)) = open.pop()
            {
                next = (enters_at <= limit).then_some(node);
            }
        }
        nearest.first().copied()
    }

    /// Where a ray goes to the inside of a polygon that may be the first.
    fn meets(&self, facet: &Facet, ray: &Ray, nearest: &Nearest) -> Option<Hit> {
        let corners = &self.corners[facet.corners.start as usize..facet.corners.end as usize];
        let out = ray.from - corners[0];
        let (above, falls) = (facet.normal.dot(out), -facet.normal.dot(ray.toward));
        // Of their signs: a product may underflow.
        let (is_front, is_back) = (above > 0.0 && falls > 0.0, above < 0.0 && falls < 0.0);
        if !is_front && !is_back {
            return None;
        }
        let distance = above / falls;
        if !(distance < nearest.limit(is_front) && distance.is_finite()) {
            return None;
        }
        let reach = out.length();
        if above.abs() <= LEVEL * facet.size * reach || !ray.is_inside(corners) {
            return None;
        }
        let beside = LEVEL * facet.size * (reach + distance * ray.length);
        Some(Hit { polygon: facet.polygon, distance, last: distance + beside / falls.abs(), is_front })
    }
}

/// The nodes below two, opened the largest first until there are as many as are compared at once.
fn widened(tree: &Tree, parts: [usize; 2]) -> SmallVec<[usize; WIDE]> {
    let mut nodes: SmallVec<[usize; WIDE]> = SmallVec::from_slice(&parts);
    let size = |node: usize| {
        let Bounds { low, high } = &tree.nodes[node].bounds;
        let unit = (*high - *low).max_element();
        unit * unit * if unit > 0.0 { tree.nodes[node].bounds.surface(unit) } else { 0.0 }
    };
    while nodes.len() < WIDE {
        let branches = nodes.iter().enumerate().filter_map(|(slot, &node)| match tree.nodes[node].content {
            Content::Branch(parts) => Some((slot, parts, size(node))),
            Content::Leaf => None,
        });
        let Some((slot, [a, b], _)) = branches.max_by(|x, y| x.2.total_cmp(&y.2)) else { break };
        nodes[slot] = a;
        nodes.push(b);
    }
    nodes
}

impl Branch {
    const NONE: Self = Self { ends: [[Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]], parts: [Node::NONE; WIDE] };

    fn set(&mut self, slot: usize, bounds: &Bounds, power: f64) {
        for axis in 0..3 {
            self.ends[0][axis][slot] = below(bounds.low[axis] * power - WIDER);
            self.ends[1][axis][slot] = above(bounds.high[axis] * power + WIDER);
        }
    }
}

/// The largest number of single precision that is not above a double, and the least that is not below it.
fn below(number: f64) -> f32 {
    let nearest = single(number);
    if f64::from(nearest) > number { nearest.next_down() } else { nearest }
}

fn above(number: f64) -> f32 {
    -below(-number)
}

/// The nearest number of single precision.
#[expect(clippy::cast_possible_truncation, reason = "what it is rounded by is accounted for")]
const fn single(number: f64) -> f32 {
    number as f32
}

/// Where a ray meets a polygon.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) polygon: u32,
    /// How many times its direction the ray goes to the plane, and to polygons that are behind it by no more than rounding.
    pub(super) distance: f64,
    last: f64,
    pub(super) is_front: bool,
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

/// A ray, and the plane across it in which polygons are asked.
struct Ray {
    from: DVec3,
    toward: DVec3,
    length: f64,
    /// The largest component of the direction, by its axis; corners are moved along the ray to where this coordinate is that of its origin.
    axis: usize,
    /// The other two, over it.
    slope: [f64; 2],
}

impl Ray {
    fn new(from: DVec3, toward: DVec3) -> Option<Self> {
        let size = toward.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let slope = [1, 2].map(|next| toward[(axis + next) % 3] / toward[axis]);
        (slope[0].is_finite() && slope[1].is_finite() && from.is_finite()).then(|| Self {
            from,
            toward,
            length: toward.length(),
            axis,
            slope,
        })
    }

    /// Whether a ray passes inside an outline: an odd number of edges is to the one side of it.
    fn is_inside(&self, corners: &[DVec3]) -> bool {
        match self.axis {
            0 => self.is_inside_of(corners, |v| [v.x, v.y, v.z]),
            1 => self.is_inside_of(corners, |v| [v.y, v.z, v.x]),
            _ => self.is_inside_of(corners, |v| [v.z, v.x, v.y]),
        }
    }

    fn is_inside_of(&self, corners: &[DVec3], turned: impl Fn(DVec3) -> [f64; 3]) -> bool {
        let flat = |corner: DVec3| {
            let [along, x, y] = turned(corner - self.from);
            [x - self.slope[0] * along, y - self.slope[1] * along]
        };
        let mut odd = false;
        let Some(&last) = corners.last() else { return false };
        let [mut ax, mut ay] = flat(last);
        for &corner in corners {
            let [bx, by] = flat(corner);
            // Where the edge is crossed, over a number that is positive if it rises: both are asked, as which edges are crossed is hard to foretell.
            let side = ax * by - ay * bx;
            odd ^= ((ay > 0.0) != (by > 0.0)) & if by > ay { side > 0.0 } else { side < 0.0 };
            (ax, ay) = (bx, by);
        }
        odd
    }

    /// The ray as it is compared with boxes that were scaled by a power of two. The largest component of the direction is 1.
    fn before_boxes(&self, power: f64) -> Boxed {
        let (from, toward) = (self.from * power, self.toward / self.toward[self.axis].abs());
        let component = |axis: usize| {
            let inverse = single(1.0 / toward[axis]);
            // One of 0 is as good as one that is far below the width of any box.
            let inverse = if inverse.abs() <= STEEP { inverse } else { STEEP.copysign(inverse) };
            // The lowest coordinates are met first if the ray rises.
            let origins = [above(from[axis]), below(from[axis])];
            let first = usize::from(inverse < 0.0);
            (first, [origins[first], origins[1 - first]], inverse)
        };
        let [x, y, z] = [0, 1, 2].map(component);
        Boxed {
            first: [x.0, y.0, z.0],
            origins: [x.1[0], y.1[0], z.1[0], x.1[1], y.1[1], z.1[1]].map(Vec4::splat),
            inverse: [x.2, y.2, z.2].map(Vec4::splat),
        }
    }

    /// A distance among boxes, in which the ray's largest component is 1, rounded up.
    fn in_boxes(&self, distance: f64, power: f64) -> f32 {
        above(distance * self.toward[self.axis].abs() * power) * ROUNDING
    }
}

/// The inverse of a component of a direction beside the largest, at most: over a box's least width it is far beyond all boxes.
const STEEP: f32 = 1e30;

/// A ray as boxes are compared with it.
struct Boxed {
    /// By axis, which end of a box it meets first.
    first: [usize; 3],
    /// Where it begins, for the ends that are met first and for the others.
    origins: [Vec4; 6],
    inverse: [Vec4; 3],
}

impl Boxed {
    /// How far a ray goes to each of the boxes, and which of them it meets up to a limit, as bits.
    #[inline]
    fn enters(&self, branch: &Branch, limit: f32) -> ([f32; WIDE], u32) {
        let first = |axis: usize| (branch.ends[self.first[axis]][axis] - self.origins[axis]) * self.inverse[axis];
        let last = |axis: usize| (branch.ends[1 - self.first[axis]][axis] - self.origins[3 + axis]) * self.inverse[axis];
        let enters = first(0).max(first(1)).max(first(2).max(Vec4::ZERO));
        let leaves = last(0).min(last(1)).min(last(2)) * ROUNDING;
        let met = enters.cmple(leaves.min(Vec4::splat(limit)));
        (enters.to_array(), met.bitmask())
    }
}

/// The length of a vector whose square may be no double.
pub(super) fn length(of: DVec3) -> f64 {
    let unit = of.abs().max_element();
    if unit > 0.0 { (of / unit).length() * unit } else { unit }
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
