//! A polygon with the quantities that the search needs.

use radgrad_core::{DVec3, Polygon};

use super::half_space::{Frame, HalfSpace, Plane};
use crate::projection::normalising_power;

/// Heights over a polygon's plane, relative to the lengths at hand, below which a point is in the plane for rays and segments.
pub(super) const LEVEL: f64 = 1e-10;

/// A polygon that may hide others.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    pub(super) vertices: Vec<DVec3>,
    pub(super) bounds: Bounds,
    /// Twice its area along its normal.
    pub(super) turning: DVec3,
    /// Where the space in front of it has its coordinates.
    pub(super) frame: Frame,
    exactly: HalfSpace,
    of_surface: HalfSpace,
}

impl Shape {
    pub(super) fn of(polygon: &Polygon) -> Self {
        let vertices = polygon.vertices().to_vec();
        let plane = Plane::of(polygon);
        let frame = Frame { origin: vertices[0], power: normalising_power(polygon.size()) };
        let (bounds, turning) = (Bounds::of(&vertices), turning(&vertices));
        Self { bounds, turning, frame, exactly: plane.front(&frame), of_surface: plane.over(&frame), vertices }
    }

    /// The space in front: as a surface's, or exactly as given.
    pub(super) const fn front(&self, of_surface: bool) -> &HalfSpace {
        if of_surface { &self.of_surface } else { &self.exactly }
    }
}

/// A vector along the normal of a polygon, twice its area long.
fn turning(vertices: &[DVec3]) -> DVec3 {
    let origin = vertices[0];
    vertices[1..].windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum()
}

/// The smallest box around some points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Bounds {
    pub(super) const NONE: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    pub(crate) fn of(points: &[DVec3]) -> Self {
        points.iter().fold(Self::NONE, |bounds, &p| Self { low: bounds.low.min(p), high: bounds.high.max(p) })
    }

    pub(crate) fn and(self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(super) fn corners(&self) -> [DVec3; 8] {
        let at = |high: usize, low: f64, top: f64| if high == 0 { low } else { top };
        std::array::from_fn(|k| {
            let (low, high) = (self.low, self.high);
            DVec3::new(at(k & 1, low.x, high.x), at(k & 2, low.y, high.y), at(k & 4, low.z, high.z))
        })
    }

    /// The common part, if the two meet.
    pub(crate) fn common(&self, other: &Self) -> Option<Self> {
        let common = Self { low: self.low.max(other.low), high: self.high.min(other.high) };
        common.low.cmple(common.high).all().then_some(common)
    }

    pub(super) fn centre(&self, axis: usize) -> f64 {
        0.5 * self.low[axis] + 0.5 * self.high[axis]
    }

    /// Half the surface, in units of `unit` along each axis so that it cannot overflow.
    pub(super) fn surface(&self, unit: f64) -> f64 {
        let DVec3 { x, y, z } = (self.high - self.low) / unit;
        x * y + y * z + z * x
    }
}
