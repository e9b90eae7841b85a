//! Healing of rounded coordinates: vertices that rounding moved apart are joined, and those that it moved off a plane are put back.
//!
//! A file holds the coordinates of a vertex to a rounding q: half a unit of its last decimal, or 2^-24 of the largest coordinate in single
//! precision. A flat wall of many vertices is then flat to about q alone, and two walls that meet in an edge do not quite. Taken for exact,
//! such a wall is folded, sees itself, and hides slivers of its neighbours. So, with `t = 1.2 q |n|_1`, which is the distance by which the
//! rounding of a vertex moves it along the normal n, with a margin:
//!
//! 1. Vertices that differ by at most 1.5 q in each coordinate are one ([`weld`]).
//! 2. Faces share a plane if each vertex of the one is within `t (1 + l)` of the plane of the other, where l, at most 3, is the sum of the
//!    magnitudes of the vertex' barycentric coordinates in the triangle that the plane was taken from: the error that the rounding of that
//!    triangle's corners adds there ([`planes`]). Wide faces go first: the normal of a needle says nothing.
//! 3. The plane is fitted to all vertices of its faces by least squares.
//! 4. Each vertex is moved the least that brings it onto its planes ([`Planes::settle`]), so that an edge of two walls is on both and walls
//!    that end in it end there. Planes of three vertices ask for nothing. Of planes that are nearly parallel, the one with more
//!    vertices counts.
//!
//! A face that is flat already to the rounding of doubles stays as it is, bit for bit. Lengths are in the unit of the
//! coordinates.

mod planes;

use std::collections::HashMap;

use radgrad_core::DVec3;

use self::planes::{Planes, width};
use crate::extremes::largest;

/// Vertices that differ in no coordinate by more than this many roundings are one: a unit of the last place is two.
const SAME: f64 = 1.5;

/// The vertices of faces, each once.
#[derive(Debug)]
pub(super) struct Welded {
    /// Where each is.
    positions: Vec<DVec3>,
    /// The vertices of each face.
    faces: Vec<Vec<usize>>,
}

/// Joins vertices that rounding may have moved apart: those of no rounding only if they are equal.
pub(super) fn weld<'a>(outlines: impl Iterator<Item = &'a [DVec3]>, rounding: f64) -> Welded {
    let reach = SAME * rounding;
    let mut welded = Welded { positions: Vec::new(), faces: Vec::new() };
    // Cells of twice the reach: a neighbour is in one of at most eight.
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut equal: HashMap<[u64; 3], usize> = HashMap::new();
    for outline in outlines {
        let mut add = |vertex: DVec3| -> usize {
            // Adding 0 makes -0 the same.
            let bits = (vertex + DVec3::ZERO).to_array().map(f64::to_bits);
            if let Some(&index) = equal.get(&bits) {
                return index;
            }
            let near = if reach > 0.0 { near(&cells, &welded.positions, vertex, reach) } else { None };
            let index = near.unwrap_or_else(|| {
                welded.positions.push(vertex);
                if reach > 0.0 {
                    cells.entry(cell(vertex, reach)).or_default().push(welded.positions.len() - 1);
                }
                welded.positions.len() - 1
            });
            equal.insert(bits, index);
            index
        };
        let face = outline.iter().map(|&vertex| add(vertex)).collect();
        welded.faces.push(face);
    }
    welded
}

fn cell(vertex: DVec3, reach: f64) -> [i64; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "a coordinate beyond the range shares the last cell")]
    (vertex / (2.0 * reach)).to_array().map(|x| x.floor() as i64)
}

fn near(cells: &HashMap<[i64; 3], Vec<usize>>, positions: &[DVec3], vertex: DVec3, reach: f64) -> Option<usize> {
    let [low, high] = [-reach, reach].map(|off| cell(vertex + DVec3::splat(off), reach));
    let both = |axis: usize| if low[axis] == high[axis] { vec![low[axis]] } else { vec![low[axis], high[axis]] };
    let (ys, zs) = (both(1), both(2));
    for x in both(0) {
        for (&y, &z) in ys.iter().flat_map(|y| zs.iter().map(move |z| (y, z))) {
            let mut inside = cells.get(&[x, y, z]).into_iter().flatten().copied();
            if let Some(index) = inside.find(|&index| (positions[index] - vertex).abs().max_element() <= reach) {
                return Some(index);
            }
        }
    }
    None
}

impl Welded {
    /// The vertices of a face: those with the same number are one.
    pub(super) fn face(&self, face: usize) -> &[usize] {
        &self.faces[face]
    }

    /// Where the vertices of a face are.
    pub(super) fn outline(&self, face: usize) -> Vec<DVec3> {
        self.faces[face].iter().map(|&vertex| self.positions[vertex]).collect()
    }

    /// Leaves out vertices of a face, and the whole face where fewer than three stay.
    pub(super) fn keep(&mut self, face: usize, kept: &[usize]) {
        let before = &self.faces[face];
        self.faces[face] = kept.iter().map(|&i| before[i]).collect();
    }

    /// Brings faces onto planes of their own and of their neighbours, as the module says.
    pub(super) fn flatten(&mut self, rounding: f64) {
        let coordinate = self.positions.iter().map(|v| v.abs().max_element()).fold(0.0, largest);
        let (low, high) =
            self.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
        let centre = low * 0.5 + high * 0.5;
        if !(centre.is_finite() && rounding > 0.0 && rounding.is_finite()) {
            return;
        }
        let around: Vec<DVec3> = self.positions.iter().map(|&v| v - centre).collect();
        let planes = Planes::fit(&around, &self.faces, rounding);
        // Four roundings of doubles, as `radgrad_core::Polygon` allows.
        let flat = 4.0 * f64::EPSILON * coordinate;
        for (vertex, moved) in planes.settle(&around, flat, rounding) {
            self.positions[vertex] += moved;
        }
    }

    /// The distance between the two sides of a face that are nearest: its doubled area over its longest diagonal.
    pub(super) fn width(&self, face: usize) -> f64 {
        width(&self.outline(face))
    }
}
