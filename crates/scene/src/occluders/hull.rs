//! The convex hull of a polygon's vertices.

use radgrad_core::{DVec3, Polygon};
use robust::{Coord, orient2d};

use crate::projection::Projection;

/// The vertices that are corners of the hull, in the polygon's order (A. M. Andrew 1979). A convex polygon is its own hull.
pub(super) fn convex_hull(polygon: &Polygon) -> Vec<DVec3> {
    let vertices = polygon.vertices();
    let projection = Projection::onto_largest(vertices);
    let points: Vec<Coord<f64>> = vertices.iter().map(|&v| projection.point(v)).collect();
    let left_turn = |[a, b, c]: [usize; 3]| orient2d(points[a], points[b], points[c]) > 0.0;
    let count = points.len();
    if (0..count).all(|i| left_turn([i, (i + 1) % count, (i + 2) % count])) {
        return vertices.to_vec();
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&i, &j| points[i].x.total_cmp(&points[j].x).then(points[i].y.total_cmp(&points[j].y)));
    let chain = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for next in order {
            while let [.., a, b] = chain[..] {
                if left_turn([a, b, next]) {
                    break;
                }
                chain.pop();
            }
            chain.push(next);
        }
        chain.pop();
        chain
    };
    let lower = chain(&mut order.iter().copied());
    let upper = chain(&mut order.iter().rev().copied());
    lower.into_iter().chain(upper).map(|i| vertices[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull(outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let polygon = Polygon::new(outline.iter().map(|&[x, y]| DVec3::new(x, y, 1.0 - x)).collect()).unwrap();
        convex_hull(&polygon).iter().map(|v| [v.x, v.y]).collect()
    }

    #[test]
    fn corners_in_notches_and_on_straight_edges_are_left_out() {
        let notched = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5], [0.0, 2.0]];
        assert_eq!(hull(&notched), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        let reversed: Vec<[f64; 2]> = notched.iter().rev().copied().collect();
        assert_eq!(hull(&reversed).len(), 4);
    }

    #[test]
    fn a_convex_polygon_keeps_its_order() {
        let quadrilateral = [[1.0, 0.0], [2.0, 1.0], [1.0, 3.0], [0.0, 1.0]];
        assert_eq!(hull(&quadrilateral), quadrilateral);
    }
}
