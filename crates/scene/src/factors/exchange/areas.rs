//! Areas that are exchanged, and the flat outlines that exchange them.

use radgrad_core::DVec3;

use crate::extremes::largest as larger;

/// An area that is exchanged, and a bound on its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::factors) struct Exchange {
    pub(in crate::factors) area: f64,
    pub(in crate::factors) error: f64,
}

impl Exchange {
    /// One of which only this range is known.
    pub(in crate::factors) fn within([least, most]: [f64; 2]) -> Self {
        // Rounded, it may be nearer to one end than to the other, and even that end.
        let area = 0.5 * (least + most);
        Self { area, error: larger(most - area, area - least) * (1.0 + 2.0 * f64::EPSILON) }
    }

    /// The exchange of what remains without a part. `off` is a bound on what the cut between the two moved.
    pub(in crate::factors) fn without(self, part: Self, off: f64) -> Self {
        let area = self.area - part.area;
        Self { area, error: self.error + part.error + off + f64::EPSILON * self.area.abs() }
    }

    pub(in crate::factors) const fn most(self) -> f64 {
        self.area + self.error
    }

    pub(in crate::factors) const fn least(self) -> f64 {
        self.area - self.error
    }
}

/// Unit roundoff.
pub(super) const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A flat outline, a polygon or a part of one.
#[derive(Debug, Clone, Copy)]
pub(in crate::factors) struct FlatOutline<'a> {
    pub(in crate::factors) points: &'a [DVec3],
    /// The unit normal of its plane.
    pub(in crate::factors) normal: DVec3,
    /// Perimeter over area of the outline that gives the plane.
    pub(in crate::factors) slope: f64,
    /// Distance by which points are off the plane.
    pub(in crate::factors) defect: f64,
    pub(in crate::factors) area: f64,
}
