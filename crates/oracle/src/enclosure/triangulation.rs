//! Triangles of a simple polygon by ear clipping with exact predicates.
//!
//! A polygon with more than three vertices is planar only up to the rounding of its vertices; the integral is over these triangles,
//! each in its own exact plane. Decisions are made on the projection along the largest component of the normal, with the predicate
//! of Shewchuk (Discrete Comput. Geom. 18, 1997), so they are those of exact arithmetic.

use radgrad_core::Polygon;
use robust::{Coord, orient2d};

use crate::enclosure::exact::{Exact, scaled};

/// Indices of the corners of each triangle, in the polygon's order.
pub(crate) fn triangles(polygon: &Polygon) -> Vec<[usize; 3]> {
    let points = projection(polygon);
    let mut rest: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while rest.len() > 3 {
        let find = |kind: fn(&[Coord<f64>], &[usize], usize) -> bool| (0..rest.len()).find(|place| kind(&points, &rest, *place));
        // A simple polygon always has an ear (Meisters 1975).
        let Some(place) = find(is_flat).or_else(|| find(is_ear)) else { break };
        if !is_flat(&points, &rest, place) {
            triangles.push(around(&rest, place));
        }
        rest.remove(place);
    }
    if rest.len() == 3 && !is_flat(&points, &rest, 1) {
        triangles.push([rest[0], rest[1], rest[2]]);
    }
    triangles
}

/// The vertices scaled to avoid underflow and projected so that the lit side sees them counter-clockwise.
fn projection(polygon: &Polygon) -> Vec<Coord<f64>> {
    let largest = polygon.vertices().iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let power = -Exact::from(largest).exponent();
    let n = polygon.normal();
    let axis = (0..3).fold(0, |best, axis| if n[axis].abs() > n[best].abs() { axis } else { best });
    let (mut i, mut j) = ((axis + 1) % 3, (axis + 2) % 3);
    if n[axis] < 0.0 {
        std::mem::swap(&mut i, &mut j);
    }
    polygon.vertices().iter().map(|v| Coord { x: scaled(v[i], power), y: scaled(v[j], power) }).collect()
}

fn around(rest: &[usize], place: usize) -> [usize; 3] {
    let count = rest.len();
    [rest[(place + count - 1) % count], rest[place], rest[(place + 1) % count]]
}

/// Whether the vertex is on the line of its neighbours: no area, nothing to integrate.
fn is_flat(points: &[Coord<f64>], rest: &[usize], place: usize) -> bool {
    let [a, b, c] = around(rest, place).map(|i| points[i]);
    orient2d(a, b, c) == 0.0
}

/// Whether the vertex is convex and its triangle holds no other vertex.
fn is_ear(points: &[Coord<f64>], rest: &[usize], place: usize) -> bool {
    let corners = around(rest, place);
    let [a, b, c] = corners.map(|i| points[i]);
    let inside = |p: Coord<f64>| orient2d(a, b, p) >= 0.0 && orient2d(b, c, p) >= 0.0 && orient2d(c, a, p) >= 0.0;
    orient2d(a, b, c) > 0.0 && !rest.iter().any(|i| !corners.contains(i) && inside(points[*i]))
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
