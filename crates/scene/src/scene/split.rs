//! A face that is not planar, as triangles through its vertices.
//!
//! Seen along the axis that shows it largest, the face must be a simple polygon. If it is convex there, the triangles are a fan
//! from its first vertex, so that whoever writes a file knows the diagonals; else the ears are cut off one by one (Meisters
//! 1975). Signs are exact, and no vertex is left out, so that neighbours keep their common edges.

use radgrad_core::{DVec3, Polygon, effort};
use robust::{Coord, orient2d};

use crate::extremes::largest;
use crate::projection::Projection;

/// The fourth corner of a parallelogram may be off by this fraction of its longest diagonal: the rounding of coordinates.
const PARALLEL: f64 = 1e-12;

/// Whether an outline is a parallelogram up to rounding.
///
/// ```
/// use radgrad_core::DVec3;
/// let outline = [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
/// assert!(radgrad_scene::is_parallelogram(&outline) && !radgrad_scene::is_parallelogram(&outline[..3]));
/// ```
#[must_use]
pub fn is_parallelogram(outline: &[DVec3]) -> bool {
    let &[a, b, c, d] = outline else { return false };
    (a - b + c - d).length() <= PARALLEL * largest((c - a).length(), (d - b).length())
}

/// Indices of the vertices of each triangle, counter-clockwise as the face is; `None` if the projected face is no polygon.
pub fn triangles(vertices: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let projection = Projection::onto_largest(vertices);
    let points: Vec<Coord<f64>> = vertices.iter().map(|&v| projection.point(v)).collect();
    // This refuses an outline that crosses or touches itself. The projection keeps orientation, so that the outline is
    // counter-clockwise.
    Polygon::new(points.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect()).ok()?;
    let count = points.len();
    let turn = |a: usize, b: usize, c: usize| orient2d(points[a], points[b], points[c]);
    let convex = (0..count).all(|i| turn(i, (i + 1) % count, (i + 2) % count) >= 0.0);
    if convex && (1..count - 1).all(|i| turn(0, i, i + 1) > 0.0) {
        return Some((1..count - 1).map(|i| [0, i, i + 1]).collect());
    }
    let mut uncut: Vec<usize> = (0..count).collect();
    let corner = |vertices: &[usize], k: usize| {
        [vertices[(k + vertices.len() - 1) % vertices.len()], vertices[k], vertices[(k + 1) % vertices.len()]]
    };
    let is_ear = |vertices: &[usize], k: usize| {
        effort::spend(vertices.len() as u64);
        let [a, b, c] = corner(vertices, k);
        let clear = |p: usize| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
        turn(a, b, c) > 0.0 && vertices.iter().all(|&p| [a, b, c].contains(&p) || clear(p))
    };
    let mut ears: Vec<bool> = (0..count).map(|k| is_ear(&uncut, k)).collect();
    let mut triangles = Vec::with_capacity(count - 2);
    while uncut.len() > 3 {
        // A simple polygon has two ears.
        let ear = ears.iter().position(|is_ear| *is_ear)?;
        triangles.push(corner(&uncut, ear));
        uncut.remove(ear);
        ears.remove(ear);
        // Cutting it off changes no other corner but its neighbours.
        for k in [(ear + uncut.len() - 1) % uncut.len(), ear % uncut.len()] {
            ears[k] = is_ear(&uncut, k);
        }
    }
    triangles.push([uncut[0], uncut[1], uncut[2]]);
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_seen(triangles: &[[usize; 3]], vertices: &[DVec3]) -> f64 {
        let area = |&[a, b, c]: &[usize; 3]| 0.5 * (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).z;
        triangles
            .iter()
            .map(|triangle| {
                assert!(area(triangle) > 0.0, "{triangle:?}");
                area(triangle)
            })
            .sum()
    }

    #[test]
    fn a_convex_face_is_a_fan_from_its_first_vertex() {
        let warped = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.1], [2.5, 1.0, 0.0], [2.0, 2.0, 0.2], [0.0, 2.0, 0.0]].map(DVec3::from);
        assert_eq!(triangles(&warped).unwrap(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn a_concave_face_keeps_its_outline_and_every_vertex() {
        // An L whose long side has a vertex on it, where a neighbour ends.
        let l = [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        for turned in 0..l.len() {
            let mut outline = l;
            outline.rotate_left(turned);
            let warped = outline.map(|[x, y]| DVec3::new(x, y, 0.01 * x * y));
            let triangles = triangles(&warped).unwrap();
            assert_eq!(triangles.len(), 5);
            assert_eq!(area_seen(&triangles, &warped), 5.0);
            assert!((0..7).all(|vertex| triangles.iter().flatten().any(|&v| v == vertex)));
        }
    }

    #[test]
    fn a_face_that_crosses_itself_is_refused() {
        let bow_tie = [[0.0, 0.0, 0.1], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(DVec3::from);
        assert_eq!(triangles(&bow_tie), None);
    }
}
