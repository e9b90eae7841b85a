//! The part of the emitter above the receiver's horizon, `n1.r >= 0`, by the walk of Sutherland and Hodgman (1974).
//!
//! A polygon that is not convex may fall into several parts; they stay joined by stretches along the horizon that are walked to
//! and fro, and cancel in every contour integral. A crossing is correct to a few ulp of the edge's ends.

use radgrad_core::DVec3;

/// A vertex as seen from the receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    /// `r_i = E_i - x`.
    pub(super) r: DVec3,
    /// `B_i`, emission there.
    pub(super) b: f64,
}

/// The vertices of the part with `n1.r >= 0`, no two neighbours the same point; none where that part has no area.
pub(super) fn part_above(polygon: &[Vertex], n1: DVec3) -> Vec<Vertex> {
    let heights: Vec<f64> = polygon.iter().map(|v| n1.dot(v.r)).collect();
    if heights.iter().all(|h| *h <= 0.0) {
        return Vec::new();
    }
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (i, here) in polygon.iter().enumerate() {
        let j = (i + 1) % polygon.len();
        if heights[i] >= 0.0 {
            part.push(*here);
        }
        if (heights[i] < 0.0) != (heights[j] < 0.0) && heights[i] != 0.0 && heights[j] != 0.0 {
            part.push(crossing([here, &polygon[j]], [heights[i], heights[j]]));
        }
    }
    part.dedup_by(|a, b| a.r == b.r);
    while part.len() > 1 && part.first().map(|v| v.r) == part.last().map(|v| v.r) {
        part.pop();
    }
    if part.len() < 3 { Vec::new() } else { part }
}

/// Where the edge between two vertices on different sides meets the horizon: a mean with weights of one sign, so nothing cancels
/// but the heights themselves.
fn crossing([start, end]: [&Vertex; 2], [from, to]: [f64; 2]) -> Vertex {
    let t = from / (from - to);
    Vertex { r: (1.0 - t) * start.r + t * end.r, b: (1.0 - t) * start.b + t * end.b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[(f64, f64)]) -> Vec<Vertex> {
        points.iter().map(|&(x, z)| Vertex { r: DVec3::new(x, 1.0, z), b: x + 2.0 * z }).collect()
    }

    #[test]
    fn a_triangle_loses_a_corner_and_keeps_its_emission() {
        let part = part_above(&polygon(&[(0.0, -1.0), (2.0, 1.0), (-2.0, 1.0)]), DVec3::Z);
        assert_eq!(part, polygon(&[(1.0, 0.0), (2.0, 1.0), (-2.0, 1.0), (-1.0, 0.0)]));
    }

    #[test]
    fn a_vertex_on_the_horizon_appears_once() {
        let part = part_above(&polygon(&[(0.0, 0.0), (0.0, -1.0), (2.0, 1.0)]), DVec3::Z);
        assert_eq!(part, polygon(&[(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)]));
        let touching = polygon(&[(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0)]);
        assert_eq!(part_above(&touching, DVec3::Z), touching);
        assert_eq!(part_above(&touching, -DVec3::Z), []);
    }

    #[test]
    fn two_parts_of_a_concave_polygon_have_the_area_of_both() {
        let w = polygon(&[(-2.0, 1.0), (-1.0, -1.0), (0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (0.0, -5.0)]);
        let part = part_above(&w, DVec3::Z);
        let twice_area: f64 = (0..part.len()).map(|i| part[i].r.cross(part[(i + 1) % part.len()].r).y).sum();
        // Two tips of base 1/6 and a middle of base 1, each of height 1.
        assert!((twice_area.abs() - 4.0 / 3.0).abs() < 4e-15, "{twice_area}");
    }
}
