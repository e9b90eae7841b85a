//! A base surface around its subsurfaces: convex polygons without the convex polygons that lie in them.
//!
//! One piece of the base is cut along the lines of the subsurface's edges, one after the other: the part outside edge k and inside
//! the edges before it is a piece of its own, and the part inside all of them is the subsurface's. Sides are exact signs; a cut
//! through an edge is a new vertex, rounded, well within the limit on planarity of a polygon.

use radgrad_core::{DVec3, Polygon};
use robust::{Coord, orient2d};

use crate::projection::Projection;
use crate::{Error, largest};

/// Vertices may be off the base's plane by this fraction of its size, as in `radgrad_core::Polygon`.
const PLANARITY: f64 = 4e-12;

/// A part of the base's area that rounding may add or lose: coordinates of a few decimals off by their last, on a slanted wall.
const AREA: f64 = 1e-9;

/// The rest of a base.
#[derive(Debug)]
pub(super) struct Remainder {
    number: usize,
    projection: Projection,
    normal: DVec3,
    origin: DVec3,
    size: f64,
    area: f64,
    pieces: Vec<Vec<DVec3>>,
}

impl Remainder {
    /// All of the base, which must be convex; `number` is its own in the file.
    pub(super) fn of(number: usize, base: &Polygon) -> Result<Self, Error> {
        let vertices = base.vertices();
        let remainder = Self {
            number,
            projection: Projection::of(vertices),
            normal: base.normal(),
            origin: vertices[0],
            size: base.size(),
            area: base.area(),
            pieces: vec![vertices.to_vec()],
        };
        match remainder.is_convex(vertices) {
            true => Ok(remainder),
            false => Err(remainder.fault("a base must be convex: split it, and combine the parts".to_owned())),
        }
    }

    /// Cuts a subsurface out. It must be convex, lie in the base and outside other subsurfaces, and face as the base does, or
    /// against it if `reversed`.
    pub(super) fn without(&mut self, subsurface: &Polygon, reversed: bool) -> Result<(), Error> {
        let mut hole = subsurface.vertices().to_vec();
        let off = hole.iter().map(|&v| self.normal.dot(v - self.origin).abs()).fold(0.0, largest);
        let farthest = hole.iter().map(|v| v.abs().max_element()).fold(self.origin.abs().max_element(), largest);
        let allowed = PLANARITY * self.size + 4.0 * f64::EPSILON * farthest;
        if off > allowed {
            return Err(self.fault(format!("a vertex is {off:e} off the plane of the base (allowed {allowed:e})")));
        }
        if (self.normal.dot(subsurface.normal()) < 0.0) != reversed {
            let rule = if reversed { "a null surface must face its base" } else { "a subsurface must face as its base does" };
            return Err(self.fault(rule.to_owned()));
        }
        if reversed {
            hole.reverse();
        }
        if !self.is_convex(&hole) {
            return Err(self.fault("a subsurface must be convex: split it".to_owned()));
        }
        let mut covered = 0.0;
        for piece in std::mem::take(&mut self.pieces) {
            let (mut rest, mut outside) = (piece.clone(), Vec::new());
            for (i, &from) in hole.iter().enumerate() {
                let to = hole[(i + 1) % hole.len()];
                outside.extend(Some(self.half(&rest, to, from)).filter(|outside| self.has_area(outside)));
                rest = self.half(&rest, from, to);
            }
            covered += self.area(&rest);
            // A piece that the subsurface does not reach stays whole: else there were as many pieces as its lines have crossings.
            if self.has_area(&rest) { self.pieces.extend(outside) } else { self.pieces.push(piece) }
        }
        let missing = subsurface.area() - covered;
        if missing.abs() > AREA * self.area {
            let rule = format!("of its area {}, {missing:e} is outside the base or in another subsurface", subsurface.area());
            return Err(self.fault(rule));
        }
        Ok(())
    }

    /// How many pieces there are.
    pub(super) fn count(&self) -> usize {
        self.pieces.len()
    }

    /// The pieces that are left.
    pub(super) fn pieces(self) -> Vec<Vec<DVec3>> {
        self.pieces
    }

    fn fault(&self, rule: String) -> Error {
        Error::Subsurface { base: self.number, rule }
    }

    fn is_convex(&self, outline: &[DVec3]) -> bool {
        let points: Vec<Coord<f64>> = outline.iter().map(|&v| self.projection.point(v)).collect();
        let count = points.len();
        (0..count).all(|i| orient2d(points[i], points[(i + 1) % count], points[(i + 2) % count]) >= 0.0)
    }

    /// The part of a convex outline to the left of the line from `from` to `to` (Sutherland and Hodgman 1974).
    fn half(&self, outline: &[DVec3], from: DVec3, to: DVec3) -> Vec<DVec3> {
        let [a, b] = [from, to].map(|v| self.projection.point(v));
        let sides: Vec<f64> = outline.iter().map(|&v| orient2d(a, b, self.projection.point(v))).collect();
        let mut half = Vec::with_capacity(outline.len() + 1);
        for (i, (&v, &side)) in outline.iter().zip(&sides).enumerate() {
            let j = (i + 1) % outline.len();
            if side >= 0.0 {
                half.push(v);
            }
            if side * sides[j] < 0.0 {
                half.push(v + (outline[j] - v) * (side / (side - sides[j])));
            }
        }
        half.dedup();
        if half.len() > 1 && half.first() == half.last() {
            half.pop();
        }
        half
    }

    /// Area of a piece, along the base's normal.
    fn area(&self, piece: &[DVec3]) -> f64 {
        let Some((&first, others)) = piece.split_first() else { return 0.0 };
        0.5 * others.windows(2).map(|pair| self.normal.dot((pair[0] - first).cross(pair[1] - first))).sum::<f64>()
    }

    /// Whether a piece is wider than the base's vertices are certain.
    fn has_area(&self, piece: &[DVec3]) -> bool {
        self.area(piece) > PLANARITY * self.size * self.size
    }
}
