//! Scenes that have an exact solution, and one that nearly has.

use glam::DVec3;
use radgrad_oracle::scene::known::{FacingRectangles, furnace_emission};
use radgrad_scene::Quantity;

use super::{Room, between_rectangles, finish, quad, turned_or_not};
use crate::cases::sampler::Sampler;
use crate::scenes::model::{Exact, Grid, Model, Part};

/// Two rectangles up to eight times as long as wide, at about the distance of their width.
pub(in crate::scenes) fn strips(s: &mut Sampler) -> Model {
    let length = s.between(3.0, 8.0);
    let rectangles = FacingRectangles {
        low: [[0.0, 0.0], [0.0, 0.0]],
        high: [[1.0, length], [1.0, length]],
        gap: s.between(0.7, 1.5),
        reflectance: [s.between(0.1, 0.9), s.between(0.1, 0.9)],
        emitted: [s.between(0.1, 1.0), s.between(0.1, 1.0)],
    };
    between_rectangles(rectangles, s)
}

/// The faces of an octahedron, each cut into four so often, their corners at distance 1 from the middle: all emit and reflect the same,
/// `B = E / (1 - rho)`.
pub(in crate::scenes) fn sphere(s: &mut Sampler) -> Model {
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for z in [DVec3::Z, DVec3::NEG_Z] {
        let rim = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        triangles.extend((0..4).map(|i| {
            let [a, b] = [rim[i], rim[(i + 1) % 4]];
            if z.z > 0.0 { [z, b, a] } else { [z, a, b] }
        }));
    }
    for _ in 0..s.below(3) {
        let cut = |[a, b, c]: [DVec3; 3]| {
            // Division and square root alone, so that neighbours have the same bits.
            let middle = |p: DVec3, q: DVec3| {
                let sum = p + q;
                sum / sum.length()
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    let (rho, emitted) = (s.between(0.05, 0.98), s.between(0.1, 1.0));
    let parts = triangles.into_iter().map(|corners| Part::new(corners.to_vec(), rho, emitted)).collect();
    let mut model = turned_or_not(finish(parts, s), s);
    model.exact = Exact::Even(emitted / (1.0 - rho));
    model.closed = true;
    model
}

/// Two rectangles with an edge in common, at any angle: far more light near it than elsewhere.
pub(in crate::scenes) fn groove(s: &mut Sampler) -> Model {
    let across = s.direction();
    let along = s.perpendicular(across) * s.between(0.5, 3.0);
    let flat = along.cross(across);
    let flat = flat / flat.length();
    let other = across * s.between(0.3, 1.5);
    let first = flat * s.between(0.3, 1.0) + across * s.between(-0.5, 0.5);
    let mut part = |corners: Vec<DVec3>, glows: bool| {
        let emitted = if glows { s.between(0.1, 1.0) } else { 0.0 };
        Part::new(corners, s.between(0.1, 0.9), emitted)
    };
    // The first is seen from where the second goes.
    let parts = vec![part(quad(DVec3::ZERO, first, along), true), part(quad(DVec3::ZERO, along, other), false)];
    finish(parts, s)
}

/// A furnace whose reflectance varies by texels, and its emission with it.
pub(in crate::scenes) fn manufactured(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.95);
    let count = s.below(2);
    room.boxes(s, count, false);
    for part in &mut room.parts {
        let rho = part.reflectance[0];
        if s.one_in(2) {
            part.emitted = vec![furnace_emission(rho)];
            continue;
        }
        let size = [1 + s.below(4) as usize, 1 + s.below(4) as usize];
        let texels: Vec<f64> = (0..size[0] * size[1]).map(|_| s.uniform()).collect();
        let glows = texels.iter().map(|texel| furnace_emission(rho * texel)).collect();
        part.grids = vec![
            Grid { size, texels, quantity: Quantity::Reflectance },
            Grid { size, texels: glows, quantity: Quantity::Radiance },
        ];
        part.emitted = vec![1.0];
    }
    let mut model = room.finish(s);
    model.exact = Exact::Even(1.0);
    model.closed = true;
    model
}
