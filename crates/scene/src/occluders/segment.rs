//! Whether a polygon is between two points, and the first one along a ray: in double precision, for estimates by samples.

use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::Occluders;
use super::rays::{best_axes, inverse, is_inside, length};
use super::shape::{Bounds, LEVEL, Shape};
use super::tree::Tree;

impl Occluders {
    /// Whether any polygon but for those of `leave_out` crosses the segment between two points. A point that is in a polygon's plane, up
    /// to rounding, is not hidden by it, and a segment along an edge may be either.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Occluders;
    /// let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// let index = Occluders::new(&[Polygon::new(corners.to_vec())?]);
    /// let down = |x: f64| [DVec3::new(x, 0.5, 2.0), DVec3::new(x, 0.5, 0.0)];
    /// assert!(index.is_between(down(0.5), &[]) && !index.is_between(down(1.5), &[]) && !index.is_between(down(0.5), &[0]));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn is_between(&self, segment: [DVec3; 2], leave_out: &[usize]) -> bool {
        self.is_any_between(&self.tree, segment, leave_out)
    }

    /// The same of the polygons of a tree.
    pub(crate) fn is_any_between(&self, tree: &Tree, segment: [DVec3; 2], leave_out: &[usize]) -> bool {
        let is_before = |index: usize| !leave_out.contains(&index) && crossing(&self.polygons[index], segment).is_some();
        self.visit_of(tree, enters(segment), is_before)
    }

    /// The polygons of a tree that cross the segment from one point to another, likewise, each with the share of it before.
    pub(crate) fn all_between(&self, tree: &Tree, segment: [DVec3; 2], leave_out: &[usize]) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        self.visit_of(tree, enters(segment), |index| {
            if !leave_out.contains(&index) {
                found.extend(crossing(&self.polygons[index], segment).map(|share| (index, share)));
            }
            false
        });
        found
    }

    /// The first polygon that a ray meets, but for those of `leave_out`, and the point where it does: of polygons that it starts in the plane
    /// of, up to rounding, none; of polygons that it meets at one place, as two back to back, one that faces it.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Occluders;
    /// let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    /// let level = |z: f64| Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec());
    /// let index = Occluders::new(&[level(2.0)?, level(1.0)?]);
    /// let (face, point) = index.first_along(DVec3::new(0.5, 0.25, 0.0), DVec3::Z, &[]).unwrap();
    /// assert!(face == 1 && point == DVec3::new(0.5, 0.25, 1.0));
    /// assert!(index.first_along(DVec3::new(0.5, 0.25, 0.0), -DVec3::Z, &[]).is_none());
    ///
    /// let below = Polygon::new(level(1.0)?.vertices().iter().rev().copied().collect())?;
    /// let plate = Occluders::new(&[level(1.0)?, below]);
    /// let first = |z: f64, toward: DVec3| plate.first_along(DVec3::new(0.5, 0.25, z), toward, &[]).unwrap().0;
    /// assert_eq!([first(0.0, DVec3::Z), first(2.0, -DVec3::Z)], [1, 0]);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn first_along(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<(usize, DVec3)> {
        self.rays.first(from, toward, leave_out).map(|hit| (hit.polygon as usize, from + toward * hit.distance))
    }

    /// The same if the ray meets that polygon from the front, against its normal; nothing if it meets it from behind.
    #[must_use]
    pub fn first_front_along(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<(usize, DVec3)> {
        let hit = self.rays.first(from, toward, leave_out).filter(|hit| hit.is_front)?;
        Some((hit.polygon as usize, from + toward * hit.distance))
    }
}

/// Whether a segment meets a box.
fn enters([from, to]: [DVec3; 2]) -> impl Fn(&Bounds) -> bool {
    let inverse = inverse(to - from);
    move |bounds| {
        let (a, b) = ((bounds.low - from) * inverse, (bounds.high - from) * inverse);
        let (first, last) = (a.min(b).max_element(), a.max(b).min_element());
        first <= 1.0 + LEVEL && last >= -LEVEL && first <= last + LEVEL * last.abs()
    }
}

/// The share of a segment after which it goes through the inside of a polygon, if it does.
fn crossing(polygon: &Shape, [from, to]: [DVec3; 2]) -> Option<f64> {
    let (vertices, normal) = (&polygon.vertices, polygon.turning);
    let origin = vertices[0];
    let [above, below] = [from, to].map(|point| normal.dot(point - origin));
    if above * below >= 0.0 {
        return None;
    }
    let level = LEVEL * length(normal) * ((to - from).length() + (from - origin).length());
    if above.abs() <= level || below.abs() <= level {
        return None;
    }
    let share = above / (above - below);
    contains(vertices, normal, from + (to - from) * share).then_some(share)
}

/// Whether a point of a polygon's plane is inside the polygon: an odd number of edges is crossed along the axis seen best. In double
/// precision: a point on an edge may be either.
#[must_use]
pub fn contains(vertices: &[DVec3], normal: DVec3, point: DVec3) -> bool {
    let flat = |v: DVec3| best_axes(normal).map(|axis| v[usize::from(axis)]);
    let corners: SmallVec<[[f64; 2]; 8]> = vertices.iter().map(|v| flat(*v)).collect();
    is_inside(&corners, flat(point))
}
