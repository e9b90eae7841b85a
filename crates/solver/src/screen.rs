//! Convex polygons that alone hide one thing from another.
//!
//! Let a polygon's plane part two sets of points. Where the segment from a point x of the hull of one to a point y of the hull of
//! the other crosses it is, for a given y, a projective image of x, and for a given x one of y: both keep segments straight. So it
//! is in the hull of the crossings between the points of the sets themselves. If these all are in the polygon nothing is seen
//! past it.

use radgrad_core::DVec3;

/// Fraction of the lengths at hand by which crossings are inside, and points off the plane.
const LEVEL: f64 = 1e-9;

/// A convex polygon.
#[derive(Debug, Clone)]
pub(crate) struct Screen {
    corner: DVec3,
    normal: DVec3,
    /// For each side a point of it and the direction inward.
    sides: Vec<[DVec3; 2]>,
}

impl Screen {
    /// The polygon with these corners in a plane of this normal, around which they turn counter-clockwise.
    pub(crate) fn new(corners: &[DVec3], normal: DVec3) -> Self {
        let side = |i: usize| [corners[i], normal.cross(corners[(i + 1) % corners.len()] - corners[i]).normalize_or_zero()];
        Self { corner: corners[0], normal, sides: (0..corners.len()).map(side).collect() }
    }

    /// Whether no point of the hull of some sees one of the hull of others past it.
    pub(crate) fn hides(&self, from: &[DVec3], to: &[DVec3]) -> bool {
        let height = |p: &DVec3| self.normal.dot(*p - self.corner);
        let (Some(first), Some(last)) = (from.first(), to.first()) else { return false };
        let sign = if height(first) > 0.0 { 1.0 } else { -1.0 };
        let level = LEVEL * ((*first - self.corner).length() + (*last - self.corner).length());
        if from.iter().any(|p| sign * height(p) <= level) || to.iter().any(|p| sign * height(p) >= -level) {
            return false;
        }
        from.iter().all(|a| {
            to.iter().all(|b| {
                let (here, there) = (height(a), height(b));
                let crossing = *a + (*b - *a) * (here / (here - there));
                self.sides.iter().all(|[corner, inward]| inward.dot(crossing - *corner) > level)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: f64, z: f64) -> Vec<DVec3> {
        [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| DVec3::new(x, y, z)).to_vec()
    }

    #[test]
    fn a_screen_hides_what_is_behind_it_and_nothing_that_shows_at_a_corner() {
        let screen = Screen::new(&square(1.0, 0.0), DVec3::Z);
        let at = |x: f64, z: f64| square(0.2, z).iter().map(|p| *p + DVec3::new(x, x, 0.0)).collect::<Vec<_>>();
        for [near, far] in [[1.0, -1.0], [-1.0, 1.0]] {
            assert!(screen.hides(&at(0.4, near), &at(0.4, far)));
            // The middle of what is seen through from corner to corner.
            assert!(screen.hides(&at(0.7, near), &at(0.9, far)));
            assert!(!screen.hides(&at(0.75, near), &at(1.1, far)));
            assert!(!screen.hides(&at(0.4, near), &at(0.4, near)));
            assert!(!screen.hides(&at(0.4, near), &[DVec3::new(0.5, 0.5, far), DVec3::new(0.5, 0.5, near)]));
            assert!(!screen.hides(&at(0.4, near), &[DVec3::new(0.5, 0.5, 0.0)]));
        }
    }
}
