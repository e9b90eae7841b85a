//! Whether opaque polygons block the view from a receiver to a point, by segment and polygon.
//!
//! A polygon blocks the open segment from `x` to `y` if its plane cuts it strictly between the ends and the cut is inside: the
//! winding number of a fan of triangles from the first vertex, seen from `x`, which is right for concave polygons too. Both
//! sides are opaque; an edge-on polygon, or one that only touches an end of the segment, does not block.

use glam::DVec3;
use radgrad_core::Polygon;

/// Rounding of a few sums of products, over the length of the ray.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Occluders as seen from one receiver.
#[derive(Debug)]
pub(crate) struct Occluders {
    pub(crate) polygons: Vec<SeenPolygon>,
}

/// A polygon relative to the receiver, in scaled lengths.
#[derive(Debug)]
pub(crate) struct SeenPolygon {
    /// Vertices less the position of the receiver.
    pub(crate) rays: Vec<DVec3>,
    normal: DVec3,
    /// Distance of the plane from the receiver along the normal.
    pub(crate) offset: f64,
}

impl Occluders {
    /// Lengths are multiplied by `scale`.
    pub(crate) fn new(position: DVec3, scale: f64, polygons: &[Polygon]) -> Self {
        Self { polygons: polygons.iter().map(|polygon| SeenPolygon::new(position, scale, polygon)).collect() }
    }

    /// Whether one of them blocks the segment along `ray` from the receiver.
    pub(crate) fn block(&self, ray: DVec3) -> bool {
        self.polygons.iter().any(|polygon| polygon.blocks(ray))
    }
}

impl SeenPolygon {
    pub(crate) fn new(position: DVec3, scale: f64, polygon: &Polygon) -> Self {
        let rays: Vec<DVec3> = polygon.vertices().iter().map(|vertex| (*vertex - position) * scale).collect();
        // The nearest vertex rounds least.
        let nearest = rays.iter().copied().min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        Self { normal: polygon.normal(), offset: nearest.map_or(0.0, |ray| polygon.normal().dot(ray)), rays }
    }

    /// Whether it blocks the segment along `ray`.
    pub(crate) fn blocks(&self, ray: DVec3) -> bool {
        let advance = self.normal.dot(ray);
        // The plane is met at the fraction offset / advance of the segment: strictly between 0 and 1, and before the end by more
        // than rounding, or a polygon in the plane of the emitter would hide it here and there.
        let rounding = ROUNDING * ray.length();
        self.offset * advance > 0.0 && self.offset.abs() < advance.abs() - rounding && self.covers(ray)
    }

    /// Whether the line along `ray` passes through it: the winding number of a fan of triangles from the first vertex. A line
    /// through a spoke of the fan belongs to the triangle on one side of it; a line through the border is outside.
    pub(crate) fn covers(&self, ray: DVec3) -> bool {
        // As a x (b - a): of two rays that are nearly parallel, far away, the cross product would have lost its digits.
        let side = |a: DVec3, b: DVec3| ray.dot(a.cross(b - a));
        let is_left = |vertex: DVec3| side(self.rays[0], vertex) >= 0.0;
        let winding = |pair: &[DVec3]| match (is_left(pair[0]), is_left(pair[1])) {
            (true, false) => i32::from(side(pair[0], pair[1]) > 0.0),
            (false, true) => -i32::from(side(pair[0], pair[1]) < 0.0),
            _ => 0,
        };
        self.rays[1..].windows(2).map(winding).sum::<i32>() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn l_shape(z: f64) -> Polygon {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec()).unwrap()
    }

    #[test]
    fn a_concave_polygon_blocks_where_it_is() {
        let position = DVec3::new(0.3, 0.3, 0.0);
        let occluders = Occluders::new(position, 1.0, &[l_shape(1.0)]);
        let blocked = |x: f64, y: f64| occluders.block((DVec3::new(x, y, 1.0) - position) * 3.0);
        assert!(blocked(0.45, 0.55) && blocked(1.7, 0.4) && blocked(0.6, 1.8));
        assert!(!blocked(1.5, 1.6) && !blocked(-0.1, 0.5) && !blocked(2.1, 0.5));
    }

    #[test]
    fn only_the_open_segment_counts() {
        let occluders = |z| Occluders::new(DVec3::new(0.5, 0.5, 0.0), 1.0, &[l_shape(z)]);
        assert!(occluders(1.0).block(DVec3::Z * 1.5));
        assert!(!occluders(1.0).block(DVec3::Z), "it ends on the occluder");
        assert!(!occluders(0.0).block(DVec3::Z), "it starts on the occluder");
        assert!(!occluders(-1.0).block(DVec3::Z), "it starts beyond");
        assert!(!occluders(2.0).block(DVec3::Z * 1.5), "it ends before");
    }

    #[test]
    fn both_sides_are_opaque() {
        let mut reversed = l_shape(1.0).vertices().to_vec();
        reversed.reverse();
        let occluders = Occluders::new(DVec3::new(0.5, 0.5, 0.0), 1.0, &[Polygon::new(reversed).unwrap()]);
        assert!(occluders.block(DVec3::Z * 1.5));
    }
}
