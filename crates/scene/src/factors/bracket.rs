//! A proven bracket of what two faces exchange past others.
//!
//! Both faces are cut into cells, and a pair of cells is
//! - seen, where no occluder is in the beam between the two ([`Beam`]): it exchanges all of it;
//! - hidden, where one convex occluder parts the two and every segment from a corner of one to a corner of the other passes
//!   through it: the plane of the occluder then meets the hull of the two in the hull of those crossings, all inside the occluder;
//! - mixed, else: it exchanges between nothing and all.
//!
//! The mixed pair that exchanges most is split next, its larger cell into four, until the bracket is narrow enough or the
//! cells are spent. The width then falls like the size of the cells, since only those at a shadow's edge stay mixed.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use radgrad_core::{DVec3, Polygon};
use robust::{Coord3D, orient3d};

use super::exchange::{Exchange, exchange};
use super::rule::{Patch, patches};
use crate::projection::normalising_power;
use crate::{Beam, Occluders};

/// What two faces exchange at least and at most, in units of area, and what is left undecided.
#[derive(Debug, Clone)]
pub(super) struct Bracket {
    /// What is surely seen.
    pub(super) seen: Exchange,
    /// Bounds on the rest.
    pub(super) mixed: Vec<Mixed>,
}

/// A pair of cells that is neither seen nor hidden, as far as is known.
#[derive(Debug, Clone)]
pub(super) struct Mixed {
    pub(super) cells: [Cell; 2],
    pub(super) free: Exchange,
}

/// A part of a face.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    patch: Patch,
    pub(super) polygon: Polygon,
}

/// The faces that a bracket is for, and what may hide one from the other.
pub(super) struct Between<'a> {
    pub(super) index: &'a Occluders,
    pub(super) faces: [usize; 2],
    pub(super) polygons: [&'a Polygon; 2],
    pub(super) candidates: &'a [usize],
    /// The polygons of the candidates.
    pub(super) occluders: &'a [&'a Polygon],
}

impl Bracket {
    pub(super) fn least(&self) -> f64 {
        self.seen.least()
    }

    pub(super) fn most(&self) -> f64 {
        self.seen.most() + self.mixed.iter().map(|pair| pair.free.most()).sum::<f64>()
    }
}

impl Between<'_> {
    /// The bracket, narrowed to `width` if `most_cells` pairs do.
    pub(super) fn bracket(&self, width: f64, most_cells: usize) -> Bracket {
        let mut bracket = Bracket { seen: Exchange::default(), mixed: Vec::new() };
        let mut open = BinaryHeap::new();
        let (mut left, mut examined) = (0.0, 0);
        let [from, to] = self.polygons.map(cells);
        for a in &from {
            for b in &to {
                self.examine([a.clone(), b.clone()], &mut bracket, &mut open, &mut left);
            }
        }
        while left > width && examined < most_cells {
            let Some(Mixed { cells: [a, b], free }) = open.pop() else { break };
            let pairs: Option<Vec<[Cell; 2]>> = if a.polygon.size() >= b.polygon.size() {
                a.quarters().map(|parts| parts.into_iter().map(|part| [part, b.clone()]).collect())
            } else {
                b.quarters().map(|parts| parts.into_iter().map(|part| [a.clone(), part]).collect())
            };
            let Some(pairs) = pairs else {
                // Too small to be cut: it stays as it is.
                bracket.mixed.push(Mixed { cells: [a, b], free });
                continue;
            };
            left -= free.most();
            for pair in pairs {
                examined += 1;
                self.examine(pair, &mut bracket, &mut open, &mut left);
            }
        }
        bracket.mixed.extend(open);
        bracket
    }

    fn examine(&self, cells: [Cell; 2], bracket: &mut Bracket, open: &mut BinaryHeap<Mixed>, left: &mut f64) {
        let free = exchange(&cells[0].polygon, &cells[1].polygon);
        if free == Exchange::default() {
            return;
        }
        let beam = Beam::from_polygon(&cells[0].polygon, &cells[1].polygon);
        let is_seen = beam.is_some_and(|beam| self.index.among(&beam, self.candidates, &self.faces).polygons.is_empty());
        if is_seen {
            bracket.seen.area += free.area;
            bracket.seen.error += free.error + f64::EPSILON * bracket.seen.area.abs();
        } else if !self.occluders.iter().any(|occluder| hides(occluder, [&cells[0].polygon, &cells[1].polygon])) {
            *left += free.most();
            open.push(Mixed { cells, free });
        }
    }
}

fn cells(polygon: &Polygon) -> Vec<Cell> {
    patches(polygon.vertices()).into_iter().filter_map(Cell::of).collect()
}

impl Cell {
    fn of(patch: Patch) -> Option<Self> {
        let corners = patch.outline().to_vec();
        Some(Self { polygon: Polygon::new(corners).ok()?, patch })
    }

    /// Four cells that are this one together; `None` where coordinates are too coarse for them.
    fn quarters(&self) -> Option<Vec<Self>> {
        let parts: Vec<Self> = self.patch.quarters().into_iter().map_while(Self::of).collect();
        (parts.len() == 4).then_some(parts)
    }
}

/// Whether a convex occluder parts two convex cells and all segments between them pass through it.
fn hides(occluder: &Polygon, [a, b]: [&Polygon; 2]) -> bool {
    if !may_part(occluder, [a, b]) {
        return false;
    }
    let vertices = occluder.vertices();
    let all = vertices.iter().chain(a.vertices()).chain(b.vertices());
    let power = normalising_power(all.fold(0.0, |m: f64, v| m.max(v.abs().max_element())));
    let at = |v: DVec3| Coord3D { x: v.x * power, y: v.y * power, z: v.z * power };
    let outline: Vec<Coord3D<f64>> = vertices.iter().map(|&v| at(v)).collect();
    let [from, to] = [a, b].map(|cell| cell.vertices().iter().map(|&v| at(v)).collect::<Vec<_>>());
    let count = outline.len();
    // Every plane through three consecutive corners parts the two: those of a flat outline are one plane but for rounding.
    let parts = |k: usize| {
        let side = |p: &Coord3D<f64>| orient3d(outline[k], outline[(k + 1) % count], outline[(k + 2) % count], *p);
        (from.iter().all(|p| side(p) > 0.0) && to.iter().all(|p| side(p) < 0.0))
            || (from.iter().all(|p| side(p) < 0.0) && to.iter().all(|p| side(p) > 0.0))
    };
    if !(0..count).all(parts) {
        return false;
    }
    // A line that has all edges of a convex outline on one side passes inside.
    let passes_inside = |p: &Coord3D<f64>, q: &Coord3D<f64>| {
        let turn = |k: usize| orient3d(*p, *q, outline[k], outline[(k + 1) % count]);
        (0..count).all(|k| turn(k) > 0.0) || (0..count).all(|k| turn(k) < 0.0)
    };
    is_convex_patch(occluder) && from.iter().all(|p| to.iter().all(|q| passes_inside(p, q)))
}

/// Whether the occluder's plane has one cell on either side, as far as doubles tell: exact signs of what is level with the plane
/// are dear.
fn may_part(occluder: &Polygon, cells: [&Polygon; 2]) -> bool {
    let (origin, normal) = (occluder.vertices()[0], occluder.normal());
    let [a, b] = cells.map(|cell| {
        let heights = cell.vertices().iter().map(|&v| normal.dot(v - origin));
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
    });
    // What touches the plane does not count as parted, so that no margin is needed: a wrong no only widens a bracket.
    (a.0 > 0.0 && b.1 < 0.0) || (a.1 < 0.0 && b.0 > 0.0)
}

/// A triangle or a convex quadrilateral: others count as hiding nothing alone, which only widens a bracket.
fn is_convex_patch(polygon: &Polygon) -> bool {
    patches(polygon.vertices()).len() == 1
}

impl PartialEq for Mixed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Mixed {}

impl PartialOrd for Mixed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Mixed {
    fn cmp(&self, other: &Self) -> Ordering {
        self.free.most().total_cmp(&other.free.most())
    }
}
