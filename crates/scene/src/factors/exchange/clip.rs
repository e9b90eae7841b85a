//! A polygon in normalised coordinates, and the part of it in front of a plane.

use radgrad_core::DVec3;

use super::areas::FlatOutline;
use crate::extremes::largest as larger;
use crate::occluders::half_space::Level;
use crate::occluders::overlap::{above, on_the_way};

/// A polygon's outline around an origin, in a unit in which the farthest coordinate is below 1.
pub(super) struct Outline {
    pub(super) points: Vec<DVec3>,
    pub(super) normal: DVec3,
    /// How far rounding moved a vertex when the origin moved, and vertices are off the plane.
    rounding: f64,
    /// How far points of its surface may be off its plane, and by how much its vertices are.
    level: Level,
    /// The same of the plane of the coordinates as they are.
    exact: Level,
    defect: f64,
}

/// The part in front of a plane; empty outlines do not exist.
pub(super) struct Front {
    pub(super) points: Vec<DVec3>,
    /// Bound on how far its corners are from where they should be.
    pub(super) moved: f64,
}

impl Outline {
    pub(super) fn new(part: &FlatOutline<'_>, origin: DVec3, power: f64) -> Self {
        let points: Vec<DVec3> = part.points.iter().map(|&v| (v - origin) * power).collect();
        let largest = part.points.iter().map(|v| v.abs().max_element()).fold(origin.abs().max_element(), larger);
        let defect = part.defect * power;
        let lost = |v: &DVec3| difference_error(*v, origin).length() * power * (1.0 + 1e-12);
        let rounding = part.points.iter().map(lost).fold(0.0, larger) + defect;
        let [level, exact] = [part.slope / power, 0.0].map(|slope| Level::new(largest * power, slope));
        Self { normal: part.normal, rounding, level, exact, defect, points }
    }

    /// The part in front of the other's plane; `None` where nothing is, or nothing by more than what the other's plane is known to, since that is of
    /// a surface whose coordinates are rounded. Corners within the rounding of heights are taken to lie in the plane. The plane of a sliver is known to
    /// far less than that, but where something is clearly in front of it, it is cut at the plane of the coordinates as they are.
    pub(super) fn in_front_of(&self, other: &Self) -> Option<Front> {
        let origin = other.points[0];
        let defect = 2.0 * (self.defect + other.defect);
        let (mut to_plane, mut is_in_front) = (0.0, false);
        let mut height = |p: &DVec3| {
            let r = *p - origin;
            let height = other.normal.dot(r);
            is_in_front |= height > other.level.at(r.length()) + defect;
            if height.abs() > other.exact.at(r.length()) + defect {
                return height;
            }
            to_plane = larger(to_plane, height.abs());
            0.0
        };
        let heights: Vec<f64> = self.points.iter().map(&mut height).collect();
        if !is_in_front {
            return None;
        }
        let moved = self.rounding + to_plane;
        if heights.iter().all(|&h| h >= 0.0) {
            return Some(Front { points: self.points.clone(), moved });
        }
        // Crossing points err by a few roundings of coordinates below 2.
        let moved = moved + 16.0 * f64::EPSILON;
        let mut points = above(&self.points, &heights, on_the_way);
        points.dedup();
        Some(Front { points, moved })
    }
}

/// What rounding takes from `a - b`, exactly (D. E. Knuth's two-sum).
fn difference_error(a: DVec3, b: DVec3) -> DVec3 {
    let difference = a - b;
    let from_b = difference - a;
    (a - (difference - from_b)) - (b + from_b)
}
