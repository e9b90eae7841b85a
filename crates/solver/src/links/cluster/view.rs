//! Bounds on a point's view of a cluster: through the sides of its box that face the point.

use radgrad_scene::{largest, smallest};
use std::f64::consts::PI;

use radgrad_core::DVec3;

use crate::bytes::bytes_of;
use crate::links::station::Station;
use crate::mesh::clusters::{Cluster, ROUNDED, highest, most_toward};
use crate::mesh::screen::LEVEL;

/// Bounds on a point's view of a cluster.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct View {
    /// On its form factor.
    pub(crate) factor: f64,
    /// On the kernel.
    pub(crate) peak: f64,
}

impl Cluster {
    /// A point's view of it.
    pub(crate) fn view(&self, station: &Station) -> View {
        let (low, high) = (self.low - station.point, self.high - station.point);
        let level = LEVEL * (low.abs().max(high.abs()).length() + station.point.abs().max_element());
        let over = highest(station.normal, low, high) + level;
        let toward = most_toward(self.normals, low, high) + level;
        if over <= 0.0 || toward <= 0.0 {
            return View::default();
        }
        // Of the nearest point of the box, which is on every side that faces x.
        let nearest = low.max(DVec3::ZERO) + high.min(DVec3::ZERO);
        let distance = nearest.length() - level;
        if distance <= 0.0 {
            return View { factor: 1.0, peak: f64::INFINITY };
        }
        let peak = smallest(over / distance, 1.0) * smallest(toward / distance, 1.0) / (PI * distance * distance) * ROUNDED;
        let side = |axis: usize| {
            let height = largest(low[axis], -high[axis]);
            if height <= 0.0 {
                return 0.0;
            }
            let (mut from, mut to) = (low, high);
            let plane = if low[axis] > 0.0 { low[axis] } else { high[axis] };
            (from[axis], to[axis]) = (plane, plane);
            let over = highest(station.normal, from, to) + level;
            if over <= 0.0 {
                return 0.0;
            }
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let area = (high[next] - low[next] + level) * (high[last] - low[last] + level);
            let cosine = smallest(over / distance, 1.0);
            cosine * area * (height + level) / (PI * distance * distance * distance) * ROUNDED
        };
        let factor = smallest(smallest(side(0) + side(1) + side(2), peak * self.area()), 1.0);
        View { factor, peak }
    }
}

bytes_of!(View { factor, peak });
