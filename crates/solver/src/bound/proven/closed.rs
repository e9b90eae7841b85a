//! Whether every place of a scene's faces sees faces from their front in all directions, so that its form factors sum to 1.
//!
//! Faces hang together by edges. If each edge bounds two faces that run along it in opposite ways, and nothing crosses, what hangs
//! together is the boundary of a body. Let `w(p)` count the bodies that p is in, those that are seen from inside by 1 and those that are
//! seen from outside by -1. Along a ray w rises by 1 where it comes upon a face from behind and falls by 1 where it comes upon its front,
//! and far away it is 0. With one body seen from inside, which the others are in and each apart from the others, w is 1 in front of all
//! faces and nowhere more: so the first face on any ray from there is met from its front.
//!
//! What stands on a face may have no bottom: where edges that bound one face alone run around a part of other faces, all in the plane of these
//! and turned to it, that part closes the body, as a bottom would, and nothing gets in between the two.
//!
//! A place that something lies on, a bottom or a face that touches it, sees nothing: there form factors do not sum to 1.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};

use super::edges::{Edges, before, near};
use crate::mesh::element::Element;
use crate::mesh::overlap::are_beside;
use crate::mesh::{Mesh, convex_parts};

/// Bodies beyond which it is not asked, and pairs of triangles of different ones.
const MOST_BODIES: usize = 64;
const MOST_PAIRS: usize = 4_000_000;

/// How far a sum of solid angles may be from a whole number of turns.
const WHOLE: f64 = 1e-6;

/// Depth below a triangle, over its size, at which it is asked what that is in: bodies may touch each other.
const DEPTH: f64 = 1e-6;

/// Fraction of sizes within which planes are one, and areas.
const SAME: f64 = 1e-9;

/// Whether a scene is closed, and from where.
#[derive(Debug, Default)]
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

    pub(super) const fn is_closed(&self) -> bool {
        self.is_closed
    }
}

/// Whether a scene of faces that all exchange light is closed, but where something lies on them; `None` if it is not asked.
fn closed(mesh: &Mesh, edges: &Edges, covers: &mut [Vec<Vec<DVec3>>]) -> Option<bool> {
    let polygons = mesh.polygons();
    let mut parts: Vec<(usize, Vec<DVec3>)> = Vec::new();
    for (solid, rim) in edges.rims()? {
        let bottom = Polygon::new(rim).ok()?;
        let convex = convex_parts(&bottom)?;
        let (mut area, beneath) = (0.0, faces_beneath(polygons, &bottom));
        for &face in &beneath {
            let pairs = mesh.convex_parts(face).iter().flat_map(|of| convex.iter().map(move |part| (of, part)));
            area += pairs.map(|(of, part)| common_area(of, polygons[face].normal(), part)).sum::<f64>();
            covers[face].extend(convex.iter().cloned());
        }
        if (area - bottom.area()).abs() > SAME * bottom.area() {
            return Some(false);
        }
        parts.extend(convex.into_iter().map(|part| (solid, part)));
    }
    for pair in near(polygons) {
        let [a, b] = pair.faces;
        if lies_on(&polygons[a], &polygons[b]) {
            covers[a].extend(mesh.convex_parts(b).iter().cloned());
            covers[b].extend(mesh.convex_parts(a).iter().cloned());
        }
    }
    for face in 0..polygons.len() {
        parts.extend(mesh.convex_parts(face).iter().map(|part| (edges.solid(face), part.clone())));
    }
    let mut bodies: Vec<usize> = parts.iter().map(|(solid, _)| *solid).collect();
    bodies.sort_unstable();
    bodies.dedup();
    if bodies.len() > MOST_BODIES {
        return None;
    }
    let fan = |part: &[DVec3]| -> Vec<[DVec3; 3]> {
        let all = (1..part.len().saturating_sub(1)).map(|i| [part[0], part[i], part[i + 1]]);
        // Corners on an edge leave triangles without area.
        all.filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() > SAME * (*c - *a).length_squared()).collect()
    };
    let of_body = |body: &usize| parts.iter().filter(|(solid, _)| solid == body).flat_map(|(_, part)| fan(part)).collect();
    let of: Vec<Vec<[DVec3; 3]>> = bodies.iter().map(of_body).collect();
    let volume = |of: &[[DVec3; 3]]| {
        let from = of[0][0];
        of.iter().map(|&[a, b, c]| (a - from).cross(b - from).dot(c - from)).sum::<f64>()
    };
    let inward: Vec<bool> = of.iter().map(|of| volume(of) < 0.0).collect();
    let all: usize = of.iter().map(Vec::len).sum();
    let pairs: usize = of.iter().zip(&inward).filter(|(_, inward)| !**inward).map(|(of, _)| of.len() * (all - of.len())).sum();
    if inward.iter().filter(|inward| **inward).count() != 1 || pairs > MOST_PAIRS {
        return None;
    }
    let is_in_its_place = |a: usize, b: usize| {
        let wanted = if inward[b] { -1.0 } else { 0.0 };
        of[a].iter().all(|triangle| (turns(below(triangle), &of[b]) - wanted).abs() < WHOLE)
    };
    Some((0..of.len()).filter(|&a| !inward[a]).all(|a| (0..of.len()).filter(|&b| b != a).all(|b| is_in_its_place(a, b))))
}

/// A point in the body that a triangle of its boundary belongs to, under the triangle's middle.
fn below(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
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
