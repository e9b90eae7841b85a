//! Convex parts of a simple polygon: itself where it is convex, else the triangles of ear clipping (Meisters 1975), with exact
//! predicates.

use robust::{Coord, orient2d};
use smallvec::{SmallVec, smallvec};

use crate::problem::polygon::Polygon;

/// A list that is seldom longer than the corners of a quadrilateral, and then needs no memory of its own.
pub(crate) type Few<T> = SmallVec<[T; 4]>;

/// Vertex indices of each part, in the polygon's order.
pub(crate) fn convex_parts(polygon: &Polygon) -> SmallVec<[Few<usize>; 1]> {
    let count = polygon.vertices().len();
    let mut remaining: Few<usize> = (0..count).collect();
    if polygon.is_convex() {
        return smallvec![remaining];
    }
    let points = polygon.projected();
    let mut parts = SmallVec::with_capacity(count - 2);
    let mut ears: Vec<bool> = (0..count).map(|k| is_ear(&points, &remaining, k)).collect();
    while remaining.len() > 3 {
        // A simple polygon always has an ear; were rounding in the projection to hide it, the flattest corner is cut.
        let ear = ears.iter().position(|is_ear| *is_ear).unwrap_or(0);
        parts.push(SmallVec::from_slice(&corner(&remaining, ear)));
        remaining.remove(ear);
        ears.remove(ear);
        // No other corner becomes or ceases to be an ear: the diagonals of the others are inside the remaining polygon if they
        // were inside before.
        for k in [(ear + remaining.len() - 1) % remaining.len(), ear % remaining.len()] {
            ears[k] = is_ear(&points, &remaining, k);
        }
    }
    parts.push(remaining);
    // A corner on a straight run has no area and no boundary of its own.
    parts.retain(|part: &mut Few<usize>| turn(&points, part[0], part[1], part[2]) > 0.0);
    parts
}

fn turn(points: &[Coord<f64>], a: usize, b: usize, c: usize) -> f64 {
    orient2d(points[a], points[b], points[c])
}

/// Vertex `k` of the rest between its neighbours.
fn corner(remaining: &[usize], k: usize) -> [usize; 3] {
    let count = remaining.len();
    [remaining[(k + count - 1) % count], remaining[k], remaining[(k + 1) % count]]
}

/// Whether the corner can be cut off: it turns left, or runs straight, and no other vertex is in its triangle.
fn is_ear(points: &[Coord<f64>], remaining: &[usize], k: usize) -> bool {
    let [a, b, c] = corner(remaining, k);
    let turning = turn(points, a, b, c);
    turning > 0.0
        && remaining
            .iter()
            .filter(|&&p| p != a && p != b && p != c)
            .all(|&p| turn(points, a, b, p) < 0.0 || turn(points, b, c, p) < 0.0 || turn(points, c, a, p) < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn polygon(points: &[[f64; 2]]) -> Polygon {
        Polygon::new(points.iter().map(|p| DVec3::new(p[0], p[1], p[0] - p[1])).collect()).unwrap()
    }

    #[test]
    fn a_convex_polygon_stays_whole() {
        assert_eq!(
            convex_parts(&polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))[..],
            [Few::from_slice(&[0, 1, 2, 3])]
        );
    }

    #[test]
    fn triangles_of_a_concave_polygon_have_its_area_in_either_orientation() {
        let comb = [[0.0, 0.0], [7.0, 0.0], [7.0, 3.0], [6.0, 1.0], [4.0, 1.0], [4.0, 4.0], [3.0, 1.0], [1.0, 1.0], [0.0, 5.0]];
        let reversed: Vec<[f64; 2]> = comb.iter().rev().copied().collect();
        for points in [comb.to_vec(), reversed] {
            let whole = polygon(&points);
            let area: f64 = convex_parts(&whole)
                .iter()
                .map(|part| Polygon::new(part.iter().map(|&i| whole.vertices()[i]).collect()).unwrap())
                .map(|triangle| {
                    assert!(triangle.normal().dot(whole.normal()) > 0.99);
                    triangle.area()
                })
                .sum();
            assert!((area - whole.area()).abs() < 1e-12 * whole.area());
        }
    }
}
