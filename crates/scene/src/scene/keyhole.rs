//! Outlines that run to a hole and back along one edge, as CAD writes faces with holes, and others that meet themselves at vertices.
//!
//! Such an outline is cut wherever it comes back to a vertex: the edges run since are a loop of their own. Bridges, whole or of
//! several edges, are loops of two vertices, and are dropped; so is an edge that is run forth and back. Loops that turn as the
//! face does bound it, and the others are holes in it.

use std::collections::HashMap;

use radgrad_core::DVec3;

use super::overlaps::flat::{Frame, Part, area, convex_parts, root, tolerance};
use crate::extremes::largest;
use crate::projection::normalising_power;

/// Vertices that differ in no coordinate by more than this many roundings are one: a unit of the last place is two.
const SAME: f64 = 1.5;

/// Simple outlines that add up to a face whose outline comes back to a vertex of its own, with coordinates rounded by at most `rounding`.
/// `None` if it does not, or if no such outlines add up to it.
pub(crate) fn keyhole(vertices: &[DVec3], rounding: f64) -> Option<Vec<Vec<DVec3>>> {
    let loops = loops(&joined(vertices, SAME * rounding));
    if loops.len() == 1 && loops[0].len() == vertices.len() {
        return None;
    }
    let farthest = vertices.iter().map(|v| v.abs().max_element()).fold(0.0, largest);
    let power = normalising_power(farthest);
    let offsets: Vec<DVec3> = vertices.iter().map(|&v| (v - vertices[0]) * power).collect();
    let turning: DVec3 = offsets.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    let frame = Frame::new(vertices, turning.try_normalize()?, power);
    let tolerance = tolerance(power * rounding, power * farthest);
    let (mut bounds, mut holes, mut wanted, mut perimeter) = (Vec::new(), Vec::new(), 0.0, 0.0);
    for of_loop in &loops {
        let mut outline: Vec<DVec3> = of_loop.iter().map(|&vertex| vertices[vertex]).collect();
        let whole = Part::new(outline.iter().map(|&v| frame.corner(v)).collect());
        wanted += whole.area();
        perimeter += whole.perimeter();
        let is_hole = whole.area() < 0.0;
        if is_hole {
            outline.reverse();
        }
        let parts = convex_parts(&outline, &frame, tolerance)?;
        let part = |part: &Vec<usize>| Part::new(part.iter().map(|&i| frame.corner(outline[i])).collect());
        let parts: Vec<Part> = parts.iter().map(part).collect();
        if is_hole { holes.extend(parts) } else { bounds.push((outline, parts)) }
    }
    let meet =
        |some: &[Part], others: &[Part]| some.iter().any(|part| others.iter().any(|other| part.common(other).is_wide(tolerance)));
    if (0..bounds.len()).any(|i| bounds[..i].iter().any(|(_, parts)| meet(parts, &bounds[i].1))) {
        return None;
    }
    let (mut outlines, mut covered) = (Vec::new(), 0.0);
    for (outline, parts) in bounds {
        if meet(&parts, &holes) {
            for piece in parts.into_iter().flat_map(|part| part.without(&holes, tolerance)) {
                covered += piece.area();
                outlines.push(piece.corners.iter().map(|corner| corner.point).collect());
            }
        } else {
            covered += area(&outline.iter().map(|&v| frame.corner(v)).collect::<Vec<_>>());
            outlines.push(outline);
        }
    }
    // Holes outside the face, or in each other, do not add up.
    ((covered - wanted).abs() <= tolerance * perimeter && !outlines.is_empty()).then_some(outlines)
}

/// The loops of three vertices or more of an outline, cut where it comes back to a vertex.
fn loops(same: &[usize]) -> Vec<Vec<usize>> {
    let (mut path, mut loops): (Vec<usize>, Vec<Vec<usize>>) = (Vec::new(), Vec::new());
    let mut places: HashMap<usize, usize> = HashMap::new();
    for (vertex, &which) in same.iter().enumerate() {
        if let Some(&place) = places.get(&which) {
            let closed = path.split_off(place);
            for &passed in &closed {
                places.remove(&same[passed]);
            }
            loops.push(closed);
        }
        places.insert(which, path.len());
        path.push(vertex);
    }
    loops.push(path);
    loops.retain(|of_loop| of_loop.len() >= 3);
    loops
}

/// One of the vertices that each is the same as.
fn joined(vertices: &[DVec3], distance: f64) -> Vec<usize> {
    // A direction along which few vertices are level.
    let key = |index: usize| vertices[index].dot(DVec3::new(0.411, 0.587, 0.698));
    let mut order: Vec<usize> = (0..vertices.len()).collect();
    order.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
    let mut same: Vec<usize> = (0..vertices.len()).collect();
    for (place, &vertex) in order.iter().enumerate() {
        let near = order[place + 1..].iter().take_while(|&&other| key(other) - key(vertex) <= 2.0 * distance);
        for &other in near.filter(|&&other| (vertices[other] - vertices[vertex]).abs().max_element() <= distance) {
            let [one, joined] = [vertex, other].map(|index| root(&mut same, index));
            same[joined] = one;
        }
    }
    (0..vertices.len()).map(|index| root(&mut same, index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_core::Polygon;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];

    fn slanted([x, y]: [f64; 2]) -> DVec3 {
        DVec3::new(0.6 * x - 0.2, y + 0.1, 0.8 * x)
    }

    /// The area of the face without its holes, where all parts are polygons that face as it does.
    fn area_of(outline: &[[f64; 2]], rounding: f64) -> Option<f64> {
        let vertices: Vec<DVec3> = outline.iter().map(|&at| slanted(at)).collect();
        let parts = keyhole(&vertices, rounding)?;
        Some(
            parts
                .into_iter()
                .map(|part| {
                    let polygon = Polygon::new(part).unwrap();
                    assert!(polygon.normal().dot(DVec3::new(-0.8, 0.0, 0.6)) > 1.0 - 1e-6);
                    polygon.area()
                })
                .sum(),
        )
    }

    /// A hole of 0.5 by 0.5, clockwise from its first corner and back to it.
    fn hole(x: f64, y: f64) -> [[f64; 2]; 5] {
        [[x, y], [x, y + 0.5], [x + 0.5, y + 0.5], [x + 0.5, y], [x, y]]
    }

    #[test]
    fn a_hole_is_cut_out_at_its_bridge_wherever_the_outline_starts() {
        let mut outline = SQUARE.to_vec();
        outline.extend([SQUARE[0]]);
        outline.extend(hole(1.0, 1.0));
        for turned in 0..outline.len() {
            let mut outline = outline.clone();
            outline.rotate_left(turned);
            assert!((area_of(&outline, 0.0).unwrap() - 8.75).abs() < 1e-12, "{turned}");
        }
        // With vertices that repeat their predecessor, and a bridge of two edges.
        let doubled: Vec<[f64; 2]> = outline.iter().flat_map(|&at| [at, at]).collect();
        assert!((area_of(&doubled, 0.0).unwrap() - 8.75).abs() < 1e-12);
        outline.insert(5, [0.5, 0.2]);
        outline.push([0.5, 0.2]);
        assert!((area_of(&outline, 0.0).unwrap() - 8.75).abs() < 1e-12);
    }

    #[test]
    fn holes_may_hang_on_each_other_and_on_several_corners() {
        // From the first corner to a hole and from that to another, and from the third corner to one more.
        let mut outline = vec![SQUARE[0]];
        outline.extend(&hole(0.5, 0.5)[..3]);
        outline.extend(hole(1.5, 1.5));
        outline.extend(&hole(0.5, 0.5)[2..]);
        outline.extend(SQUARE);
        outline.splice(outline.len() - 1.., [[2.0, 0.3], [2.0, 0.8], [2.5, 0.8], [2.5, 0.3], [2.0, 0.3]]);
        // The last hole hangs on the third corner: out and back.
        outline.extend([SQUARE[2], SQUARE[3]]);
        assert!((area_of(&outline, 0.0).unwrap() - 8.25).abs() < 1e-12);
    }

    #[test]
    fn vertices_of_a_bridge_agree_within_the_rounding() {
        let q = 5e-4;
        let mut outline = SQUARE.to_vec();
        outline.extend([[0.0, 0.5 * q]]);
        outline.extend(hole(1.0, 1.0));
        outline[9][0] += q;
        assert!((area_of(&outline, q).unwrap() - 8.75).abs() < 4.0 * q);
        assert_eq!(area_of(&outline, 0.0), None);
    }

    #[test]
    fn an_edge_run_forth_and_back_is_dropped_and_parts_that_meet_in_a_vertex_are_told_apart() {
        let mut outline = SQUARE.to_vec();
        outline.splice(1..1, [[1.0, 0.0], [1.0, 1.0], [1.0, 0.0]]);
        assert_eq!(area_of(&outline, 0.0), Some(9.0));
        let twins = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]];
        assert!((area_of(&twins, 0.0).unwrap() - 2.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_face_with_holes_is_left_alone() {
        assert_eq!(area_of(&SQUARE, 0.0), None);
        // A second turn through the same points, a hole outside, one that turns as the face does, and a bow tie.
        let twice: Vec<[f64; 2]> = SQUARE.iter().chain(&SQUARE).copied().collect();
        assert_eq!(area_of(&twice, 0.0), None);
        let mut outside = SQUARE.to_vec();
        outside.extend([SQUARE[0]]);
        outside.extend(hole(-1.0, -1.0));
        assert_eq!(area_of(&outside, 0.0), None);
        let mut turned = SQUARE.to_vec();
        turned.extend([SQUARE[0]]);
        turned.extend(hole(1.0, 1.0).iter().rev());
        assert_eq!(area_of(&turned, 0.0), None);
        assert_eq!(area_of(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]], 0.0), None);
        assert_eq!(keyhole(&[], 0.0), None);
    }
}
