//! Whether a polygon is between two points, and the first one along a ray: in double precision, for estimates by samples.

use radgrad_core::DVec3;

use super::Occluders;
use super::shape::{Bounds, Shape};
use super::tree::Content;

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
        let is_before = |index: usize| !leave_out.contains(&index) && crossing(&self.polygons[index], segment).is_some();
        self.visit(enters(segment), is_before)
    }

    /// The polygons that cross the segment from one point to another, likewise, each with the share of it before.
    pub(crate) fn all_between(&self, segment: [DVec3; 2], leave_out: &[usize]) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        self.visit(enters(segment), |index| {
            if !leave_out.contains(&index) {
                found.extend(crossing(&self.polygons[index], segment).map(|share| (index, share)));
            }
            false
        });
        found
    }

    /// The first polygon that a ray meets, but for those of `leave_out`, and the point where it does: of polygons that it starts in the plane
    /// of, up to rounding, none.
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
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn first_along(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<(usize, DVec3)> {
        let inverse = inverse(toward);
        let enters = |node: usize| {
            let bounds = &self.tree.nodes[node].bounds;
            let (a, b) = ((bounds.low - from) * inverse, (bounds.high - from) * inverse);
            let (first, last) = (a.min(b).max_element(), a.max(b).min_element());
            (last >= 0.0 && first <= last + LEVEL * last.abs()).then_some(first)
        };
        let mut open: Vec<(usize, f64)> = Vec::with_capacity(64);
        open.extend(self.tree.root().and_then(|root| Some((root, enters(root)?))));
        let mut nearest: Option<(usize, f64)> = None;
        while let Some((node, enters_at)) = open.pop() {
            if nearest.is_some_and(|(_, distance)| enters_at > distance * (1.0 + LEVEL)) {
                continue;
            }
            match &self.tree.nodes[node].content {
                // The nearer one is taken first.
                &Content::Branch([a, b]) => match (enters(a), enters(b)) {
                    (Some(to_a), Some(to_b)) if to_a < to_b => open.extend_from_slice(&[(b, to_b), (a, to_a)]),
                    (Some(to_a), Some(to_b)) => open.extend_from_slice(&[(a, to_a), (b, to_b)]),
                    (Some(to_a), None) => open.push((a, to_a)),
                    (None, Some(to_b)) => open.push((b, to_b)),
                    (None, None) => {}
                },
                Content::Leaf => {
                    for &index in
                        self.tree.order[self.tree.nodes[node].range.clone()].iter().filter(|index| !leave_out.contains(index))
                    {
                        let met = meets(&self.polygons[index], from, toward);
                        if let Some(distance) = met.filter(|at| nearest.is_none_or(|(_, distance)| *at < distance)) {
                            nearest = Some((index, distance));
                        }
                    }
                }
            }
        }
        nearest.map(|(index, distance)| (index, from + toward * distance))
    }
}

/// One over each component of a direction. One of 0 is as good as one that is far below all lengths, and its inverse is finite.
fn inverse(along: DVec3) -> DVec3 {
    let steep = |along: f64| if along.abs() < 1e-290 { 1e290 } else { 1.0 / along };
    DVec3::new(steep(along.x), steep(along.y), steep(along.z))
}

/// How many times its direction a ray goes to the inside of a polygon.
fn meets(polygon: &Shape, from: DVec3, toward: DVec3) -> Option<f64> {
    let (vertices, normal) = (&polygon.vertices, polygon.turning);
    let origin = vertices[0];
    let (above, falls) = (normal.dot(from - origin), -normal.dot(toward));
    if above.abs() <= LEVEL * normal.length() * (from - origin).length() || above * falls <= 0.0 {
        return None;
    }
    let distance = above / falls;
    (distance.is_finite() && contains(vertices, normal, from + toward * distance)).then_some(distance)
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
    let level = LEVEL * normal.length() * ((to - from).length() + (from - origin).length());
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
