//! Faces in the coordinates of one plane, as convex parts, and the arithmetic of these: the common part of two, and one without others.
//!
//! A convex part without another is cut along the lines of the other's edges, one after the other: the part beyond an edge and
//! inside those before it is a piece, and the part inside all of them is the other's. The edge that cuts off the largest piece
//! goes first, so that pieces are few and wide: a disc leaves four boards around its square, then the remainders of its corners.
//! Without many others the part that is nearest to the middle is cut out first, and each piece goes on with the parts that reach
//! it: as in a sort by halves.
//!
//! Corners within the tolerance of a line are on it, and cuts that meet a corner of the other within it end there: a face keeps
//! no slivers along its neighbours, and a piece has the corner of the face that it was cut around bit for bit.

use std::collections::HashMap;

use radgrad_core::DVec3;

use crate::extremes::{largest, smallest};
use crate::occluders::overlap::above;
use crate::scene::split::triangles;

/// The distance by which lines that coincided may be apart, with coordinates up to `largest` that are rounded by at most `rounding`.
pub(crate) fn tolerance(rounding: f64, largest: f64) -> f64 {
    4.0 * rounding + 16.0 * f64::EPSILON * largest
}

/// Coordinates in a plane, in a unit in which the scene is about 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
    power: f64,
}

impl Frame {
    /// Of the plane through the first vertex of an outline, which has this normal. The longest edge is along the first axis, so that
    /// boxes tell boards apart. Lengths are multiplied by a power of two.
    pub(crate) fn new(outline: &[DVec3], normal: DVec3, power: f64) -> Self {
        let edge = |i: usize| (outline[(i + 1) % outline.len()] - outline[i]) * power;
        let longest = (0..outline.len()).map(edge).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let along = longest.unwrap_or(DVec3::ZERO);
        let along = (along - normal * normal.dot(along)).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        let origin = outline.first().copied().unwrap_or(DVec3::ZERO);
        Self { origin, axes: [along, normal.cross(along), normal], power }
    }

    pub(crate) fn corner(&self, point: DVec3) -> Corner {
        let offset = (point - self.origin) * self.power;
        let [x, y, height] = self.axes.map(|axis| axis.dot(offset));
        Corner { at: [x, y], height, point }
    }

    /// The point of the plane that is nearest to a corner.
    pub(crate) fn foot(&self, corner: &Corner) -> DVec3 {
        corner.point - self.axes[2] * (corner.height / self.power)
    }

    pub(crate) const fn normal(&self) -> DVec3 {
        self.axes[2]
    }
}

/// A point: where it is along a plane, its height over that, and where in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    pub(crate) at: [f64; 2],
    pub(crate) height: f64,
    pub(crate) point: DVec3,
}

impl Corner {
    fn between(here: Self, next: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let mixed = [0, 1].map(|k| mix(here.at[k], next.at[k]));
        Self { at: mixed, height: mix(here.height, next.height), point: here.point + (next.point - here.point) * share }
    }
}

/// A convex part of a face, counter-clockwise.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) corners: Vec<Corner>,
    low: [f64; 2],
    high: [f64; 2],
}

impl Part {
    pub(crate) fn new(corners: Vec<Corner>) -> Self {
        let bound = |start: f64, of: fn(f64, f64) -> f64| [0, 1].map(|k| corners.iter().map(|c| c.at[k]).fold(start, of));
        Self { low: bound(f64::INFINITY, smallest), high: bound(f64::NEG_INFINITY, largest), corners }
    }

    pub(crate) fn area(&self) -> f64 {
        area(&self.corners)
    }

    pub(crate) fn perimeter(&self) -> f64 {
        let count = self.corners.len();
        (0..count).map(|i| length(self.corners[i].at, self.corners[(i + 1) % count].at)).sum()
    }

    /// Whether it is wider than the tolerance.
    pub(crate) fn is_wide(&self, tolerance: f64) -> bool {
        self.corners.len() >= 3 && self.area() > 0.5 * tolerance * self.perimeter()
    }

    /// Whether the boxes around the two have no common part of a width.
    pub(crate) fn is_apart(&self, other: &Self) -> bool {
        (0..2).any(|k| self.low[k] >= other.high[k] || other.low[k] >= self.high[k])
    }

    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|k| 0.5 * (self.low[k] + self.high[k]))
    }

    /// The part that is in another as well (I. Sutherland and G. Hodgman 1974): with the heights of this one.
    pub(crate) fn common(&self, other: &Self) -> Self {
        if self.is_apart(other) {
            return Self::new(Vec::new());
        }
        let count = other.corners.len();
        let clip = |rest: Vec<Corner>, i: usize| {
            let (from, to) = (other.corners[i].at, other.corners[(i + 1) % count].at);
            let heights: Vec<f64> = rest.iter().map(|corner| turn(from, to, corner.at)).collect();
            above(&rest, &heights, Corner::between)
        };
        Self::new((0..count).fold(self.corners.clone(), clip))
    }

    /// Itself without others.
    pub(crate) fn without(self, others: &[Self], tolerance: f64) -> Vec<Self> {
        let mut pieces = Vec::new();
        let mut open = vec![(self, (0..others.len()).collect::<Vec<usize>>())];
        while let Some((piece, mut near)) = open.pop() {
            near.retain(|&other| piece.common(&others[other]).is_wide(tolerance));
            let distance = |other: usize| length(others[other].middle(), piece.middle());
            let Some(first) = (0..near.len()).min_by(|&a, &b| distance(near[a]).total_cmp(&distance(near[b]))) else {
                pieces.push(piece);
                continue;
            };
            let other = &others[near.swap_remove(first)];
            open.extend(piece.around(other, tolerance).into_iter().map(|outside| (outside, near.clone())));
        }
        pieces
    }

    /// The pieces beyond the edges of another.
    fn around(&self, other: &Self, tolerance: f64) -> Vec<Self> {
        let count = other.corners.len();
        let (mut rest, mut pieces) = (self.corners.clone(), Vec::new());
        // The area that an edge cuts off becomes less as the rest does: an area found before is a bound.
        let mut edges: Vec<(f64, usize)> = (0..count).map(|edge| (f64::INFINITY, edge)).collect();
        while let Some(place) = (0..edges.len()).max_by(|&a, &b| edges[a].0.total_cmp(&edges[b].0)) {
            let (bound, edge) = edges[place];
            let [inside, beyond] = halves(&rest, [other.corners[edge], other.corners[(edge + 1) % count]], tolerance);
            let beyond = Self::new(beyond);
            if !beyond.is_wide(tolerance) {
                edges.swap_remove(place);
                continue;
            }
            edges[place].0 = beyond.area();
            if edges[place].0 >= bound || edges.iter().all(|&(other, _)| other <= edges[place].0) {
                edges.swap_remove(place);
                pieces.push(beyond);
                rest = inside;
            }
        }
        pieces
    }
}

/// The parts of a convex outline to the left and to the right of the line through two corners.
fn halves(outline: &[Corner], [from, to]: [Corner; 2], tolerance: f64) -> [Vec<Corner>; 2] {
    let along = length(from.at, to.at);
    let height = |corner: &Corner| {
        let height = turn(from.at, to.at, corner.at) / along;
        if height.abs() <= tolerance { 0.0 } else { height }
    };
    let heights: Vec<f64> = outline.iter().map(height).collect();
    let below: Vec<f64> = heights.iter().map(|height| -height).collect();
    let cut = |here: Corner, next: Corner, share: f64| {
        let corner = Corner::between(here, next, share);
        // Half the tolerance along both lines.
        let is_at = |end: &Corner| length(end.at, corner.at) <= tolerance;
        [from, to].into_iter().find(is_at).unwrap_or(corner)
    };
    [&heights, &below].map(|heights| distinct(above(outline, heights, cut)))
}

/// Whether a simple outline is convex.
pub(crate) fn is_convex(outline: &[Corner]) -> bool {
    let corner = |i: usize| outline[i % outline.len()].at;
    (0..outline.len()).all(|i| turn(corner(i), corner(i + 1), corner(i + 2)) >= 0.0)
}

/// Whether an edge of a convex outline has it on its left, and another all but a strip of this width on its right.
pub(crate) fn lies_beside(outline: &[Corner], other: &[Corner], width: f64) -> bool {
    (0..outline.len()).any(|i| {
        let (from, to) = (outline[i].at, outline[(i + 1) % outline.len()].at);
        let is_on_right = |corner: &Corner| {
            let turn = turn(from, to, corner.at);
            turn <= 0.0 || turn <= width * length(from, to)
        };
        other.iter().all(is_on_right)
    })
}

/// An outline without corners that are at their predecessor.
fn distinct(mut outline: Vec<Corner>) -> Vec<Corner> {
    outline.dedup_by(|a, b| a.point == b.point);
    while outline.len() > 1 && outline.first().map(|c| c.point) == outline.last().map(|c| c.point) {
        outline.pop();
    }
    outline
}

/// Convex parts of a simple outline as indices of its vertices (S. Hertel and K. Mehlhorn 1983): at most four times as many as are needed.
/// A vertex that is within the tolerance of the line between its neighbours makes no part of its own. `None` if the outline crosses or
/// touches itself.
pub(crate) fn convex_parts(vertices: &[DVec3], frame: &Frame, tolerance: f64) -> Option<Vec<Vec<usize>>> {
    let corners: Vec<[f64; 2]> = vertices.iter().map(|&v| frame.corner(v).at).collect();
    if vertices.len() == 3 {
        return Some(vec![vec![0, 1, 2]]);
    }
    let is_convex = |before: usize, vertex: usize, after: usize| {
        let (a, b, c) = (corners[before], corners[vertex], corners[after]);
        let goes_on = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) > 0.0;
        let turn = turn(a, b, c);
        turn >= 0.0 || goes_on && -turn <= tolerance * length(a, c)
    };
    let triangles = triangles(vertices)?;
    let mut parts: Vec<Vec<usize>> = triangles.iter().map(|triangle| triangle.to_vec()).collect();
    let mut joined_to: Vec<usize> = (0..parts.len()).collect();
    let mut owner = HashMap::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for edge in [[a, b], [b, c], [c, a]] {
            owner.insert(edge, index);
        }
    }
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let Some(&other) = owner.get(&[to, from]).filter(|&&other| other > index) else { continue };
            let [one, other] = [index, other].map(|part| root(&mut joined_to, part));
            // `to .. from` of the one and `from .. to` of the other.
            let (first, second) = (starting_at(&parts[one], to), starting_at(&parts[other], from));
            let ends = [(&first, &second), (&second, &first)];
            let stays_convex = ends.iter().all(|(coming, going)| {
                coming.len() >= 2 && going.len() >= 2 && is_convex(coming[coming.len() - 2], going[0], going[1])
            });
            if one != other && stays_convex {
                parts[one] = first.into_iter().chain(second[1..second.len() - 1].iter().copied()).collect();
                parts[other].clear();
                joined_to[other] = one;
            }
        }
    }
    parts.retain(|part| !part.is_empty());
    Some(parts)
}

/// The first of those that were joined.
pub(crate) fn root(joined_to: &mut [usize], mut index: usize) -> usize {
    while joined_to[index] != index {
        joined_to[index] = joined_to[joined_to[index]];
        index = joined_to[index];
    }
    index
}

fn starting_at(part: &[usize], vertex: usize) -> Vec<usize> {
    let start = part.iter().position(|&v| v == vertex).unwrap_or(0);
    part[start..].iter().chain(&part[..start]).copied().collect()
}

pub(crate) fn area(outline: &[Corner]) -> f64 {
    let Some((origin, rest)) = outline.split_first() else { return 0.0 };
    0.5 * rest.windows(2).map(|pair| turn(origin.at, pair[0].at, pair[1].at)).sum::<f64>()
}

/// Twice the area of a triangle, positive if it is counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn length(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}
