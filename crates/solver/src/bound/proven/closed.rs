//! Whether every place of a scene's faces sees faces from their front in all directions, so that its form factors sum to 1.
//!
//! Faces hang together by edges. If each edge bounds two faces that run along it in opposite ways, and nothing crosses, what hangs
//! together is the boundary of a body. Let `w(p)` count the bodies that p is in, those that are seen from inside by 1 and those that are
//! seen from outside by -1. Along a ray w rises by 1 where it comes upon a face from behind and falls by 1 where it comes upon its front,
//! and far away it is 0. With one body seen from inside, which the others are in and each apart from the others, w is 1 in front of all
//! faces and nowhere more: so the first face on any ray from there is met from its front.

use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::edges::Edges;
use crate::mesh::Mesh;

/// Bodies beyond which it is not asked.
const MOST_BODIES: usize = 64;

/// How far a sum of solid angles may be from a whole number of turns.
const WHOLE: f64 = 1e-6;

pub(super) fn is_closed(mesh: &Mesh, edges: &Edges) -> bool {
    if !mesh.all_exchange() || !edges.are_matched() {
        return false;
    }
    let faces = 0..mesh.polygons().len();
    let mut bodies: Vec<usize> = faces.clone().map(|face| edges.solid(face)).collect();
    bodies.sort_unstable();
    bodies.dedup();
    if bodies.len() > MOST_BODIES {
        return false;
    }
    let triangles = |body: usize| -> Vec<[DVec3; 3]> {
        let of_face = |face: usize| {
            let parts = mesh.convex_parts(face).iter();
            parts.flat_map(|part| (1..part.len().saturating_sub(1)).map(|i| [part[0], part[i], part[i + 1]])).collect::<Vec<_>>()
        };
        faces.clone().filter(|&face| edges.solid(face) == body).flat_map(of_face).collect()
    };
    let of: Vec<Vec<[DVec3; 3]>> = bodies.iter().map(|&body| triangles(body)).collect();
    let volume = |of: &[[DVec3; 3]]| {
        let from = of[0][0];
        of.iter().map(|&[a, b, c]| (a - from).cross(b - from).dot(c - from)).sum::<f64>()
    };
    let inward: Vec<bool> = of.iter().map(|of| volume(of) < 0.0).collect();
    if inward.iter().filter(|inward| **inward).count() != 1 {
        return false;
    }
    (0..of.len()).all(|a| {
        let corner = of[a][0][0];
        (0..of.len()).filter(|&b| b != a && !inward[a]).all(|b| {
            let wanted = if inward[b] { -1.0 } else { 0.0 };
            (turns(corner, &of[b]) - wanted).abs() < WHOLE
        })
    })
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
