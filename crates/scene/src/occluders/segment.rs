//! Whether a polygon is between two points: in double precision, for estimates by samples.

use radgrad_core::DVec3;

use super::Occluders;
use super::shape::Bounds;

/// Heights over a polygon's plane, relative to the lengths at hand, below which a point is in the plane.
const LEVEL: f64 = 1e-10;

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
        let is_before = |index: usize| !leave_out.contains(&index) && crossing(&self.polygons[index].vertices, segment).is_some();
        self.visit(|bounds| enters(bounds, segment), is_before)
    }

    /// The polygons that cross the segment from one point to another, likewise, each with the share of it before.
    pub(crate) fn all_between(&self, segment: [DVec3; 2], leave_out: &[usize]) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        self.visit(
            |bounds| enters(bounds, segment),
            |index| {
                if !leave_out.contains(&index) {
                    found.extend(crossing(&self.polygons[index].vertices, segment).map(|share| (index, share)));
                }
                false
            },
        );
        found
    }
}

/// Whether a segment meets a box.
fn enters(bounds: &Bounds, [from, to]: [DVec3; 2]) -> bool {
    // A direction of 0 is as good as one that is far below all lengths, and its inverse is finite.
    let steep = |along: f64| if along.abs() < 1e-290 { 1e290 } else { 1.0 / along };
    let along = to - from;
    let inverse = DVec3::new(steep(along.x), steep(along.y), steep(along.z));
    let (a, b) = ((bounds.low - from) * inverse, (bounds.high - from) * inverse);
    let (first, last) = (a.min(b).max_element(), a.max(b).min_element());
    first <= 1.0 + LEVEL && last >= -LEVEL && first <= last + LEVEL * last.abs()
}

/// The share of a segment after which it goes through the inside of a polygon, if it does.
fn crossing(vertices: &[DVec3], [from, to]: [DVec3; 2]) -> Option<f64> {
    let origin = vertices[0];
    let normal: DVec3 = vertices[1..].windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum();
    let [above, below] = [from, to].map(|point| normal.dot(point - origin));
    let level = LEVEL * normal.length() * ((to - from).length() + (from - origin).length());
    if above * below >= 0.0 || above.abs() <= level || below.abs() <= level {
        return None;
    }
    let share = above / (above - below);
    contains(vertices, normal, from + (to - from) * share).then_some(share)
}

/// Whether a point of a polygon's plane is inside the polygon: an odd number of edges is crossed along the axis seen best. In double
/// precision: a point on an edge may be either.
#[must_use]
pub fn contains(vertices: &[DVec3], normal: DVec3, point: DVec3) -> bool {
    let size = normal.abs();
    let flat = |v: DVec3| {
        if size.z >= size.x && size.z >= size.y {
            [v.x, v.y]
        } else if size.y >= size.x {
            [v.z, v.x]
        } else {
            [v.y, v.z]
        }
    };
    let [x, y] = flat(point);
    let crossed = |i: &usize| {
        let ([ax, ay], [bx, by]) = (flat(vertices[*i]), flat(vertices[(i + 1) % vertices.len()]));
        (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax)
    };
    (0..vertices.len()).filter(crossed).count() % 2 == 1
}
