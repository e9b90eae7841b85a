//! Whether every place of a scene's faces sees faces from their front in all directions, so that its form factors sum to 1.
//!
//! Let along each edge as many faces run one way as the other. Then `w(p)`, how many more faces a ray from far away to p comes upon from
//! behind than from their front, is the same for all rays, and changes only where p crosses a face: it is greater by 1 in front. No face
//! crosses another, so that w is the same all over a face's back. If it is 0 behind every face it is 1 in front of every face: so the first
//! face on any ray from there is met from its front.
//!
//! What stands on a face may have no bottom: where edges that bound one face alone run around a part of other faces, all in the plane of these
//! and turned to it, that part closes the body, as a bottom would, and nothing gets in between the two.
//!
//! A place that something lies on, a bottom or a face that touches it, sees nothing, and nothing sees it: a ray from there that gets
//! through what lies on it is where w is 0, and the first face that it comes upon is met from behind.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use rayon::prelude::*;

use super::edges::{Edges, before, near};
use crate::mesh::element::Element;
use crate::mesh::overlap::are_beside;
use crate::mesh::{Mesh, convex_parts};

/// Triangles beyond which it is not asked.
const MOST_TRIANGLES: usize = 2000;

/// How far a sum of solid angles may be from a whole number of turns.
const WHOLE: f64 = 1e-6;

/// Depth behind a triangle, over its size, at which it is asked how often faces turn around that.
const DEPTH: f64 = 1e-6;

/// Fraction of sizes within which planes are one, and areas.
pub(super) const SAME: f64 = 1e-9;

/// Whether a scene is closed, and from where.
#[derive(Debug)]
pub(super) struct Closure {
    is_closed: bool,
    /// For each face, convex polygons that lie on it.
    covers: Vec<Vec<Vec<DVec3>>>,
}

impl Closure {
    pub(super) fn of(mesh: &Mesh, edges: &Edges) -> Self {
        let mut covers = vec![Vec::new(); mesh.polygons().len()];
        let is_closed = mesh.all_exchange() && closed(mesh, edges, &mut covers).unwrap_or(false);
        Self { is_closed, covers }
    }

    /// Whether the form factors of every place of an element sum to 1.
    pub(super) fn is_closed_from(&self, element: &Element) -> bool {
        let (v, normal) = (element.polygon().vertices(), element.polygon().normal());
        let reach = SAME * element.radius();
        let is_apart = |cover: &Vec<DVec3>| are_beside(v, normal, cover, reach) || are_beside(cover, -normal, v, reach);
        self.is_closed && self.covers[element.face()].iter().all(is_apart)
    }

    /// The part of an element's area that something lies on: 0 if there is none.
    pub(super) fn covered(&self, element: &Element) -> f64 {
        if self.is_closed_from(element) {
            return 0.0;
        }
        let (of, covers) = (element.polygon(), &self.covers[element.face()]);
        covers.iter().map(|cover| common_area(of.vertices(), of.normal(), cover)).sum::<f64>() / element.area()
    }

    pub(super) const fn is_closed(&self) -> bool {
        self.is_closed
    }
}

/// Whether a scene of faces that all exchange light is closed, but where something lies on them; `None` if it is not asked.
fn closed(mesh: &Mesh, edges: &Edges, covers: &mut [Vec<Vec<DVec3>>]) -> Option<bool> {
    let polygons = mesh.polygons();
    let mut parts: Vec<Vec<DVec3>> = (0..polygons.len()).flat_map(|face| mesh.convex_parts(face).iter().cloned()).collect();
    let (rims, rimmed) = edges.rims()?;
    for rim in rims {
        let bottom = Polygon::new(rim).ok()?;
        let (convex, mut area) = (convex_parts(&bottom)?, 0.0);
        for face in faces_beneath(polygons, &bottom) {
            if rimmed.contains(&face) {
                return Some(false);
            }
            let pairs = mesh.convex_parts(face).iter().flat_map(|of| convex.iter().map(move |part| (of, part)));
            area += pairs.map(|(of, part)| common_area(of, polygons[face].normal(), part)).sum::<f64>();
            covers[face].extend(convex.iter().cloned());
        }
        if (area - bottom.area()).abs() > SAME * bottom.area() {
            return Some(false);
        }
        parts.extend(convex);
    }
    for pair in near(polygons) {
        let [a, b] = pair.faces;
        if lies_on(&polygons[a], &polygons[b]) {
            covers[a].extend(mesh.convex_parts(b).iter().cloned());
            covers[b].extend(mesh.convex_parts(a).iter().cloned());
        }
    }
    let fan = |part: &Vec<DVec3>| -> Vec<[DVec3; 3]> {
        let all = (1..part.len().saturating_sub(1)).map(|i| [part[0], part[i], part[i + 1]]);
        // Corners on an edge leave triangles without area.
        all.filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() > SAME * (*c - *a).length_squared()).collect()
    };
    let triangles: Vec<[DVec3; 3]> = parts.iter().flat_map(fan).collect();
    (triangles.len() <= MOST_TRIANGLES).then(|| triangles.par_iter().all(|of| turns(behind(of), &triangles).abs() < WHOLE))
}

/// A point behind the middle of a triangle.
fn behind(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let size = (b - a).length() + (c - a).length();
    (a + b + c) / 3.0 - (b - a).cross(c - a).normalize_or_zero() * (DEPTH * size)
}

/// The faces in the plane of a polygon that turn to it.
fn faces_beneath(polygons: &[Polygon], bottom: &Polygon) -> Vec<usize> {
    polygons.iter().enumerate().filter(|(_, face)| lies_on(face, bottom)).map(|(face, _)| face).collect()
}

/// Whether two polygons are in one plane and turn to each other.
fn lies_on(a: &Polygon, b: &Polygon) -> bool {
    let reach = SAME * (a.size() + b.size());
    let is_in = |of: &Polygon, v: &DVec3| of.normal().dot(*v - of.vertices()[0]).abs() <= reach;
    a.normal().dot(b.normal()) < 0.0 && a.vertices().iter().all(|v| is_in(b, v)) && b.vertices().iter().all(|v| is_in(a, v))
}

/// The area that two convex polygons in one plane have in common; the first turns around a normal.
fn common_area(of: &[DVec3], normal: DVec3, part: &[DVec3]) -> f64 {
    let mut common = part.to_vec();
    for (i, &corner) in of.iter().enumerate() {
        common = before([corner, normal.cross(of[(i + 1) % of.len()] - corner).normalize_or_zero()], &common);
    }
    let Some(&from) = common.first() else { return 0.0 };
    0.5 * common.windows(2).map(|ends| (ends[0] - from).cross(ends[1] - from)).sum::<DVec3>().length()
}

/// How often a surface turns around a point: its solid angle by A. van Oosterom and J. Strackee (1983).
fn turns(point: DVec3, triangles: &[[DVec3; 3]]) -> f64 {
    let angle = |triangle: &[DVec3; 3]| {
        let [a, b, c] = triangle.map(|p| p - point);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.cross(b).dot(c).atan2(scale)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Quad = [[f64; 3]; 4];

    const SIDES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

    /// A cuboid seen from outside; its first side is the bottom.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<Quad> {
        let corner = |i: usize| [[low[0], high[0]][i & 1], [low[1], high[1]][i >> 1 & 1], [low[2], high[2]][i >> 2 & 1]];
        SIDES.iter().map(|side| side.map(corner)).collect()
    }

    /// The same seen from inside.
    fn room() -> Vec<Quad> {
        cuboid([0.0; 3], [4.0, 4.0, 3.0]).into_iter().map(|[a, b, c, d]| [d, c, b, a]).collect()
    }

    fn closure(faces: &[Vec<[f64; 3]>]) -> (Mesh, Closure) {
        let mesh = Mesh::of_faces(faces, 0);
        let closure = Closure::of(&mesh, &Edges::of(&mesh));
        (mesh, closure)
    }

    fn polygons(quads: &[&[Quad]]) -> Vec<Vec<[f64; 3]>> {
        quads.iter().flat_map(|quads| quads.iter().map(|quad| quad.to_vec())).collect()
    }

    #[test]
    fn rooms_are_closed_where_things_stand_or_hang_in_them_but_not_with_a_hole_or_in_each_other() {
        let (empty, block) = (room(), cuboid([1.0, 1.0, 0.0], [2.0, 2.5, 1.0]));
        let hanging = cuboid([1.0, 1.0, 0.5], [2.0, 2.5, 1.0]);
        let on_the_block = cuboid([1.2, 1.2, 1.0], [1.6, 1.6, 1.4]);
        let in_a_corner = cuboid([0.0, 0.0, 0.0], [0.5, 0.5, 1.0]);
        let through_the_floor = cuboid([1.0, 1.0, -0.5], [2.0, 2.5, 1.0]);
        let outside = cuboid([5.0, 1.0, 0.0], [6.0, 2.0, 1.0]);
        let over_the_edge = cuboid([3.0, 1.0, 1.0], [5.0, 2.0, 2.0]);
        let at = |x: f64, y: f64| [x, y, 0.0];
        let cases = [
            (polygons(&[&empty]), true),
            (polygons(&[&empty[1..]]), false),
            (polygons(&[&empty, &block]), true),
            (polygons(&[&empty, &block[1..]]), true),
            (polygons(&[&empty, &block[1..], &on_the_block[1..]]), true),
            (polygons(&[&empty, &in_a_corner]), true),
            (polygons(&[&empty, &hanging]), true),
            (polygons(&[&empty, &hanging[1..]]), false),
            (polygons(&[&empty, &hanging[..5]]), false),
            (polygons(&[&empty, &through_the_floor]), false),
            (polygons(&[&empty, &through_the_floor[1..]]), false),
            (polygons(&[&empty, &outside]), false),
            (polygons(&[&empty, &over_the_edge]), false),
            (polygons(&[&empty, &hanging, &cuboid([1.2, 1.2, 0.6], [1.8, 1.8, 0.8])]), false),
            (polygons(&[&block]), false),
            (polygons(&[&empty, &hanging[..1]]), false),
            (polygons(&[&empty, &hanging[1..2]]), false),
            (polygons(&[&hanging[..1], &[[at(0.0, 0.0), at(4.0, 0.0), at(4.0, 4.0), at(0.0, 4.0)]]]), false),
        ];
        for (index, (faces, expected)) in cases.iter().enumerate() {
            assert_eq!(closure(faces).1.is_closed(), *expected, "case {index}");
        }
    }

    #[test]
    fn what_has_no_bottom_stands_on_any_number_of_faces_but_on_no_hole() {
        let block = cuboid([1.0, 1.0, 0.0], [2.0, 2.5, 1.0]);
        let at = |x: f64, y: f64| [x, y, 0.0];
        let halves = [vec![at(0.0, 0.0), at(4.0, 0.0), at(4.0, 4.0)], vec![at(0.0, 0.0), at(4.0, 4.0), at(0.0, 4.0)]];
        let rest = polygons(&[&room()[1..], &block[1..]]);
        assert!(closure(&[&rest[..], &halves].concat()).1.is_closed());
        // A floor around a pit under a part of the block.
        let floor = |x: f64, y: f64| {
            let strip = |from: [f64; 2], to: [f64; 2]| {
                vec![at(from[0], from[1]), at(to[0], from[1]), at(to[0], to[1]), at(from[0], to[1])]
            };
            vec![
                strip([0.0; 2], [x, 4.0]),
                strip([x, 0.0], [x + 0.5, y]),
                strip([x, y + 0.5], [x + 0.5, 4.0]),
                strip([x + 0.5, 0.0], [4.0; 2]),
            ]
        };
        for (x, y) in [(1.2, 1.2), (1.8, 1.2), (3.0, 3.0)] {
            let pit = cuboid([x, y, -0.5], [x + 0.5, y + 0.5, 0.0]);
            let pit: Vec<Quad> =
                pit.into_iter().enumerate().filter(|(side, _)| *side != 1).map(|(_, [a, b, c, d])| [d, c, b, a]).collect();
            let faces = [&rest[..], &floor(x, y), &polygons(&[&pit])].concat();
            assert_eq!(closure(&faces).1.is_closed(), x == 3.0, "{x}");
        }
    }

    /// Along the line in which it is cut into convex parts.
    #[test]
    fn a_plate_through_a_wall_with_a_notch_crosses_it_wherever_that_is() {
        let wall = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
        let polygon = Polygon::new(wall.to_vec()).unwrap();
        let parts = convex_parts(&polygon).unwrap();
        assert!(parts.len() > 1);
        let is_outer = |a: DVec3, b: DVec3| (0..5).any(|i| [wall[i], wall[(i + 1) % 5]] == [a, b]);
        let sides = parts.iter().flat_map(|part| (0..3).map(|i| [part[i], part[(i + 1) % 3]]));
        for [a, b] in sides.filter(|[a, b]| !is_outer(*a, *b)) {
            let [a, b] = [a + (b - a) * 0.2, b - (b - a) * 0.2];
            let plate = [a - DVec3::Y, b - DVec3::Y, b + DVec3::Y, a + DVec3::Y];
            let mesh = Mesh::of_faces(&[wall.map(|p| p.to_array()).to_vec(), plate.map(|p| p.to_array()).to_vec()], 0);
            let edges = Edges::of(&mesh);
            assert!((0..edges.all.len()).any(|line| edges.crosses(line)), "{a} {b}");
        }
    }

    #[test]
    fn what_something_lies_on_is_not_closed_and_what_is_beside_it_is() {
        let block = cuboid([1.0, 1.0, 0.0], [2.0, 2.5, 1.0]);
        for first in [0, 1] {
            let (mesh, closure) = closure(&polygons(&[&room(), &block[first..]]));
            assert!(closure.is_closed());
            for element in mesh.elements() {
                let middle = element.centre();
                let is_under = middle.z == 0.0 && middle.x > 1.0 && middle.x < 2.0 && middle.y > 1.0 && middle.y < 2.5;
                assert_eq!(closure.is_closed_from(element), !is_under, "{middle}");
                let is_bottom = middle.z == 0.0 && element.polygon().normal().z < 0.0;
                let covered = if is_under || is_bottom { 1.0 } else { 0.0 };
                assert!((closure.covered(element) - covered).abs() < 1e-12, "{middle}");
            }
        }
    }
}
