//! Triangles of a simple polygon by ear clipping with exact predicates.
//!
//! A polygon with more than three vertices is planar only up to the rounding of its vertices; the integral is over these triangles,
//! each in its own exact plane. Decisions are made on the projection along the largest component of the normal, with the predicate
//! of Shewchuk (Discrete Comput. Geom. 18, 1997), so they are those of exact arithmetic. A vertex is left out only if it is on the line of its
//! neighbours in space: one that is off it along the projection alone is on the outline seen from elsewhere.

use radgrad_core::Polygon;
use robust::{Coord, orient2d};

use crate::enclosure::exact::{Exact, scaled};

/// Indices of the corners of each triangle, in the polygon's order.
pub(crate) fn triangles(polygon: &Polygon) -> Vec<[usize; 3]> {
    let [points, others @ ..] = projections(polygon);
    let is_straight =
        |remaining: &[usize], place: usize| others.iter().chain([&points]).all(|points| is_flat(points, remaining, place));
    let mut remaining: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while remaining.len() > 3 {
        let straight = (0..remaining.len()).find(|&place| is_straight(&remaining, place));
        // A simple polygon always has an ear (Meisters 1975).
        let Some(place) = straight.or_else(|| (0..remaining.len()).find(|&place| is_ear(&points, &remaining, place))) else {
            break;
        };
        if straight.is_none() {
            triangles.push(around(&remaining, place));
        }
        remaining.remove(place);
    }
    if remaining.len() == 3 && !is_flat(&points, &remaining, 1) {
        triangles.push([remaining[0], remaining[1], remaining[2]]);
    }
    triangles
}

/// The vertices scaled to avoid underflow and projected along each axis: first along the one that shows the polygon largest, so that the
/// lit side sees them counter-clockwise.
fn projections(polygon: &Polygon) -> [Vec<Coord<f64>>; 3] {
    let largest = polygon.vertices().iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let power = -Exact::from(largest).exponent();
    let n = polygon.normal();
    let axis = (0..3).fold(0, |best, axis| if n[axis].abs() > n[best].abs() { axis } else { best });
    let (mut i, mut j) = ((axis + 1) % 3, (axis + 2) % 3);
    if n[axis] < 0.0 {
        std::mem::swap(&mut i, &mut j);
    }
    let onto = |i: usize, j: usize| {
        polygon.vertices().iter().map(|v| Coord { x: scaled(v[i], power), y: scaled(v[j], power) }).collect()
    };
    [onto(i, j), onto(j, axis), onto(axis, i)]
}

fn around(remaining: &[usize], place: usize) -> [usize; 3] {
    let count = remaining.len();
    [remaining[(place + count - 1) % count], remaining[place], remaining[(place + 1) % count]]
}

/// Whether the vertex is seen on the line of its neighbours.
fn is_flat(points: &[Coord<f64>], remaining: &[usize], place: usize) -> bool {
    let [a, b, c] = around(remaining, place).map(|i| points[i]);
    orient2d(a, b, c) == 0.0
}

/// Whether the vertex is convex and its triangle holds no other vertex.
fn is_ear(points: &[Coord<f64>], remaining: &[usize], place: usize) -> bool {
    let corners = around(remaining, place);
    let [a, b, c] = corners.map(|i| points[i]);
    let inside = |p: Coord<f64>| orient2d(a, b, p) >= 0.0 && orient2d(b, c, p) >= 0.0 && orient2d(c, a, p) >= 0.0;
    orient2d(a, b, c) > 0.0 && !remaining.iter().any(|i| !corners.contains(i) && inside(points[*i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn area(polygon: &Polygon) -> f64 {
        let v = polygon.vertices();
        triangles(polygon).into_iter().map(|[a, b, c]| 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).dot(polygon.normal())).sum()
    }

    #[test]
    fn a_vertex_off_the_line_of_its_neighbours_along_the_projection_alone_is_kept() {
        let corners = |height: f64| [(0.0, 0.0, 0.0), (1.0, 0.0, height), (2.0, 0.0, 0.0), (2.0, 2.0, 0.0), (0.0, 2.0, 0.0)];
        let polygon =
            |height: f64| Polygon::from_rounded(corners(height).map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(), 1e-6).unwrap();
        assert_eq!([0.0, 1e-7].map(|height| triangles(&polygon(height)).len()), [2, 3]);
        assert!((area(&polygon(1e-7)) - 4.0).abs() < 1e-6);
    }

    #[test]
    fn triangles_fill_concave_polygons_and_skip_flat_corners() {
        let comb = [(0, 0), (6, 0), (6, 3), (5, 1), (4, 3), (3, 1), (2, 3), (1, 1), (0, 3), (0, 2), (0, 1)];
        for turn in [DVec3::X, DVec3::Y, DVec3::Z] {
            let (u, v) = (turn.any_orthonormal_vector(), turn.cross(turn.any_orthonormal_vector()));
            for sign in [1.0, -1.0] {
                let points = comb.map(|(x, y)| (u * f64::from(x) * sign + v * f64::from(y)) * 2f64.powi(-300));
                let polygon = Polygon::new(points.to_vec()).unwrap();
                assert_eq!(area(&polygon), polygon.area());
                assert_eq!(triangles(&polygon).len(), 7);
            }
        }
    }
}
