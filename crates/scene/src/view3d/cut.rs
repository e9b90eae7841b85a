//! A base surface around its subsurfaces: convex polygons without the convex polygons that lie in them.

use radgrad_core::{DVec3, Polygon};

use crate::error::Error;
use crate::extremes::largest;
use crate::projection::normalising_power;
use crate::scene::overlaps::flat::{Frame, Part, convex_parts, tolerance};

/// Vertices may be off the base's plane by this fraction of its size, as in `radgrad_core::Polygon`.
const PLANARITY: f64 = 4e-12;

/// A part of the base's area that rounding may add or lose: coordinates of a few decimals off by their last, on a slanted wall.
const AREA: f64 = 1e-9;

/// The rest of a base.
#[derive(Debug)]
pub(super) struct Remainder<'a> {
    number: usize,
    base: &'a Polygon,
    frame: Frame,
    /// The base's area, in the unit of the frame.
    area: f64,
    tolerance: f64,
    pieces: Vec<Part>,
}

impl<'a> Remainder<'a> {
    /// All of the base, which must be convex; `number` is its own in the file.
    pub(super) fn whole(number: usize, base: &'a Polygon) -> Result<Self, Error> {
        let power = normalising_power(base.size());
        let frame = Frame::new(base.vertices(), base.normal(), power);
        let tolerance = tolerance(PLANARITY * base.size(), farthest(base)) * power;
        let mut remainder = Self { number, base, frame, area: 0.0, tolerance, pieces: Vec::new() };
        let Some(whole) = remainder.convex(base.vertices()) else {
            return Err(remainder.fault("a base must be convex: split it, and combine the parts".to_owned()));
        };
        remainder.area = whole.area();
        remainder.pieces.push(whole);
        Ok(remainder)
    }

    /// Cuts a subsurface out. It must be convex, lie in the base and outside other subsurfaces, and face as the base does, or
    /// against it if `reversed`.
    pub(super) fn without(&mut self, subsurface: &Polygon, reversed: bool) -> Result<(), Error> {
        let mut outline = subsurface.vertices().to_vec();
        let (normal, origin) = (self.base.normal(), self.base.vertices()[0]);
        let distance = outline.iter().map(|&v| normal.dot(v - origin).abs()).fold(0.0, largest);
        let allowed =
            PLANARITY * self.base.size() + 4.0 * f64::EPSILON * largest(farthest(subsurface), origin.abs().max_element());
        if distance > allowed {
            return Err(self.fault(format!("a vertex is {distance:e} off the plane of the base (allowed {allowed:e})")));
        }
        if (normal.dot(subsurface.normal()) < 0.0) != reversed {
            let rule = if reversed { "a null surface must face its base" } else { "a subsurface must face as its base does" };
            return Err(self.fault(rule.to_owned()));
        }
        if reversed {
            outline.reverse();
        }
        let Some(hole) = self.convex(&outline) else {
            return Err(self.fault("a subsurface must be convex: split it".to_owned()));
        };
        let missing = hole.area() - self.pieces.iter().map(|piece| piece.common(&hole).area()).sum::<f64>();
        if missing.abs() > AREA * self.area {
            let (area, share) = (subsurface.area(), missing / hole.area());
            let rule = format!("of its area {area}, {:e} is outside the base or in another subsurface", share * area);
            return Err(self.fault(rule));
        }
        let holes = [hole];
        let pieces = std::mem::take(&mut self.pieces).into_iter();
        self.pieces = pieces.flat_map(|piece| piece.without(&holes, self.tolerance)).collect();
        Ok(())
    }

    /// How many pieces there are.
    pub(super) fn count(&self) -> usize {
        self.pieces.len()
    }

    /// The pieces that are left.
    pub(super) fn pieces(self) -> Vec<Vec<DVec3>> {
        self.pieces.into_iter().map(|piece| piece.corners.iter().map(|corner| corner.point).collect()).collect()
    }

    fn fault(&self, rule: String) -> Error {
        Error::Subsurface { base: self.number, rule }
    }

    /// An outline as a part, if it is convex.
    fn convex(&self, outline: &[DVec3]) -> Option<Part> {
        let parts = convex_parts(outline, &self.frame, self.tolerance)?;
        let corners = |part: &Vec<usize>| part.iter().map(|&i| self.frame.corner(outline[i])).collect();
        if let [whole] = &parts[..] { Some(Part::new(corners(whole))) } else { None }
    }
}

/// The largest coordinate.
fn farthest(polygon: &Polygon) -> f64 {
    polygon.vertices().iter().map(|v| v.abs().max_element()).fold(0.0, largest)
}
