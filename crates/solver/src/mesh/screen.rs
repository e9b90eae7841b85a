//! Convex polygons that alone hide one thing from another.
//!
//! Let the points `x_i` be on one side of a polygon's plane, at heights `h_i >= 0`, and `y_j` on the other, at depths `g_j >= 0`.
//! The segment between them crosses the plane at `(h_i y_j + g_j x_i) / (h_i + g_j)`. From `x = sum l_i x_i` to
//! `y = sum m_j y_j` the crossing is the mean of these with the weights `l_i m_j (h_i + g_j)`: in the hull of the crossings between
//! the points themselves, those that both are in the plane left out. If these are all in the polygon nothing is seen past it.
//!
//! Points are level with the plane, and crossings on an edge, up to the rounding of coordinates: planes are those of surfaces, as
//! in the scene's beams, and a gap narrower than that is none. Walls stand on floors, and meet in corners.

use radgrad_core::DVec3;
use radgrad_scene::largest;

/// Fraction of the lengths at hand that coordinates are rounded by: heights below it are those of a plane's own points.
pub(crate) const LEVEL: f64 = 1e-12;

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
        let highest = from.iter().map(height).fold(0.0, |most: f64, h| if h.abs() > most.abs() { h } else { most });
        let reach = from.iter().chain(to).map(|p| (*p - self.corner).length_squared()).fold(0.0, largest).sqrt();
        let (sign, level) = (highest.signum(), LEVEL * reach);
        let is_in_front = |p: &DVec3| sign * height(p) >= -level;
        let is_behind = |p: &DVec3| sign * height(p) <= level;
        let apart = highest.abs() > level && to.iter().any(|p| sign * height(p) < -level);
        if !apart || !from.iter().all(is_in_front) || !to.iter().all(is_behind) {
            return false;
        }
        from.iter().all(|x| {
            let above = largest(sign * height(x), 0.0);
            to.iter().all(|y| {
                let below = largest(-sign * height(y), 0.0);
                if largest(above, below) <= level {
                    return true;
                }
                let crossing = (*y * above + *x * below) / (above + below);
                self.sides.iter().all(|[corner, inward]| inward.dot(crossing - *corner) >= -level)
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
        let shifted = |x: f64, z: f64| square(0.2, z).iter().map(|p| *p + DVec3::new(x, x, 0.0)).collect::<Vec<_>>();
        for [near, far] in [[1.0, -1.0], [-1.0, 1.0]] {
            assert!(screen.hides(&shifted(0.4, near), &shifted(0.4, far)));
            // The middle of the region seen through from corner to corner.
            assert!(screen.hides(&shifted(0.7, near), &shifted(0.85, far)));
            assert!(!screen.hides(&shifted(0.75, near), &shifted(1.1, far)));
            assert!(!screen.hides(&shifted(0.4, near), &shifted(0.4, near)));
            assert!(!screen.hides(&shifted(0.4, near), &[DVec3::new(0.5, 0.5, far), DVec3::new(0.5, 0.5, near)]));
            assert!(!screen.hides(&shifted(0.4, near), &[DVec3::new(0.5, 0.5, 0.0)]));
            // A body that begins where the screen stands, and reaches as far as it does.
            let beside = [DVec3::new(0.0, 0.0, 0.0), DVec3::new(1.0, 0.0, near), DVec3::new(0.0, 1.0, near)];
            assert!(screen.hides(&beside, &square(1.0, far)) && !screen.hides(&beside, &square(1.1, far)));
            assert!(screen.hides(&beside, &[DVec3::ZERO, DVec3::new(0.5, 0.5, far)]));
        }
    }
}
