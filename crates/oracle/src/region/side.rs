//! The side of the emitter's plane that the receiver is on, without rounding: from the plane itself nothing is seen, and a
//! height that is a rounded difference of large coordinates cannot tell.
//!
//! The plane is that of three vertices, vertex 0 and two neighbours that span the most with it: the plane of a triangle, and of
//! any polygon whose vertices are exactly in one. The sign is that of Shewchuk's predicate (Discrete Comput. Geom. 18, 1997).

use glam::DVec3;
use radgrad_core::Polygon;
use robust::{Coord3D, orient3d};

use crate::region::compensated::normalising_power;
use crate::region::{PreciseVertex, twice_area};

/// Where the receiver is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Lit,
    InPlane,
    Unlit,
}

/// The side that `position` is on; `outline` is the polygon in coordinates of its plane, counter-clockwise from the lit side.
pub(crate) fn side(position: DVec3, polygon: &Polygon, outline: &[PreciseVertex]) -> Side {
    let area = |i: usize| twice_area(&outline[0], &outline[i - 1], &outline[i]).rounded();
    let widest = (2..outline.len()).max_by(|i, j| area(*i).abs().total_cmp(&area(*j).abs())).unwrap_or(2);
    let corners = [0, widest - 1, widest].map(|i| polygon.vertices()[i]);
    let largest = corners.iter().fold(position.abs().max_element(), |m, v| m.max(v.abs().max_element()));
    let power = normalising_power(largest);
    let [a, b, c, x] =
        [corners[0], corners[1], corners[2], position].map(|v| v * power).map(|v| Coord3D { x: v.x, y: v.y, z: v.z });
    // Positive where a, b, c run clockwise as seen from x.
    let clockwise = orient3d(a, b, c, x) * area(widest).signum();
    if clockwise < 0.0 {
        Side::Lit
    } else if clockwise > 0.0 {
        Side::Unlit
    } else {
        Side::InPlane
    }
}
