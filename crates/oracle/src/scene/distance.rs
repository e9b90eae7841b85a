//! Distances between triangles and points (C. Ericson, Real-Time Collision Detection, 2005, chapter 5), to rounding.

use glam::DVec3;
use radgrad_core::Polygon;

use crate::enclosure::triangulation;

/// Corners of a triangle.
pub(super) type Corners3 = [DVec3; 3];

/// The triangles of a polygon, oriented as it is.
pub(super) fn triangles(polygon: &Polygon) -> Vec<Corners3> {
    let vertices = polygon.vertices();
    triangulation::triangles(polygon).into_iter().map(|corners| corners.map(|i| vertices[i])).collect()
}

/// Distance of a point from a triangle.
pub(super) fn to_point(triangle: &Corners3, point: DVec3) -> f64 {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a);
    let inside = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) >= 0.0;
    let length = normal.length();
    if length > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return (normal.dot(point - a) / length).abs();
    }
    [(a, b), (b, c), (c, a)].map(|(p, q)| to_segment(p, q, point)).into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment(p: DVec3, q: DVec3, point: DVec3) -> f64 {
    let along = q - p;
    let t = ((point - p).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (p + along * t - point).length()
}

/// Distance of two triangles: 0 where they cross, else that of an edge and an edge or of a vertex and a triangle.
pub(super) fn between_triangles(s: &Corners3, t: &Corners3) -> f64 {
    let edges = |corners: &Corners3| [0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3]]);
    if edges(s).iter().any(|edge| crosses(edge, t)) || edges(t).iter().any(|edge| crosses(edge, s)) {
        return 0.0;
    }
    let vertices = s.iter().map(|v| to_point(t, *v)).chain(t.iter().map(|v| to_point(s, *v)));
    let pairs = edges(s).into_iter().flat_map(|e| edges(t).into_iter().map(move |f| between_segments(e, f)));
    vertices.chain(pairs).fold(f64::INFINITY, f64::min)
}

/// Whether a segment passes through a triangle.
fn crosses([p, q]: &[DVec3; 2], [a, b, c]: &Corners3) -> bool {
    let normal = (*b - *a).cross(*c - *a);
    let (low, high) = (normal.dot(*p - *a), normal.dot(*q - *a));
    if low * high > 0.0 || low == high {
        return false;
    }
    let crossing = *p + (*q - *p) * (low / (low - high));
    [(a, b), (b, c), (c, a)].into_iter().all(|(v, w)| (*w - *v).cross(crossing - *v).dot(normal) >= 0.0)
}

fn between_segments([p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> f64 {
    let (along, other, between) = (q - p, b - a, p - a);
    let (ee, ff, ef) = (along.length_squared(), other.length_squared(), along.dot(other));
    let (c, f) = (along.dot(between), other.dot(between));
    let denominator = ee * ff - ef * ef;
    let mut s = if denominator > 0.0 { ((ef * f - c * ff) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (ef * s + f) / ff;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((ef * t - c) / ee).clamp(0.0, 1.0);
    }
    (p + along * s - a - other * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Corners3 = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn moved(by: DVec3) -> Corners3 {
        T.map(|v| v + by)
    }

    #[test]
    fn distances_are_those_of_simple_places() {
        assert_eq!(to_point(&T, DVec3::new(0.25, 0.25, -2.0)), 2.0);
        assert_eq!(to_point(&T, DVec3::new(-3.0, -4.0, 0.0)), 5.0);
        assert_eq!(between_triangles(&T, &moved(DVec3::Z * 0.5)), 0.5);
        assert_eq!(between_triangles(&T, &moved(DVec3::X * 3.0)), 2.0);
        let across = [DVec3::new(0.2, 0.2, -1.0), DVec3::new(0.2, 0.2, 1.0), DVec3::new(5.0, 5.0, 0.0)];
        assert_eq!(between_triangles(&T, &across), 0.0);
        let beside = [DVec3::new(0.5, -1.0, -1.0), DVec3::new(0.5, -1.0, 1.0), DVec3::new(0.5, -2.0, 0.0)];
        assert_eq!(between_triangles(&T, &beside), 1.0, "edge to edge");
    }
}
