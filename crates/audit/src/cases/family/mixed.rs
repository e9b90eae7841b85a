//! Two difficulties at once: the remedy against the one must not lose the digits to the other.

use glam::DVec3;

use super::emission;
use super::frame::{Triangle, inside};
use super::horizon;
use super::many_sided::{self, OnLattice};
use super::near;
use super::scene::Scene;
use super::spread;
use crate::cases::sampler::Sampler;

/// A needle at 2^3 to 2^27 sizes.
pub(super) fn far_needle(sampler: &mut Sampler) -> Scene {
    spread::needle_at_sizes(sampler, 3, 27)
}

/// At 2^3 to 2^27 sizes, the horizon through a point of the inside.
pub(super) fn far_clipped(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::far(sampler);
    let toward = inside(sampler, corners(&scene)) - scene.position;
    scene.normal = sampler.perpendicular(toward / toward.length());
    scene
}

/// At 2^3 to 2^27 sizes, behind a screen that stands on it.
pub(super) fn far_screen(sampler: &mut Sampler) -> Scene {
    screened(sampler, 3, 27)
}

/// At 2^2 to 2^5 sizes behind a screen that stands on it, scaled by 2^600 to 2^900 or by the inverse.
pub(super) fn screen_scale(sampler: &mut Sampler) -> Scene {
    let scene = screened(sampler, 2, 5);
    extreme(sampler, scene)
}

/// At 2^low to 2^high sizes, behind a triangle that stands on a diagonal and hides the vertex which that cuts off: the two touch
/// along it.
fn screened(sampler: &mut Sampler, low: i64, high: i64) -> Scene {
    let lattice = many_sided::lattice(sampler);
    let count = 4 + sampler.below(8) as usize;
    let polygon = OnLattice::convex_with(sampler, lattice, count);
    let vertices = polygon.vertices();
    let cross = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
    let lit = cross / cross.length();
    let size = vertices.iter().map(|v| (*v - vertices[0]).length()).fold(0.0, f64::max);
    let position = vertices[0] + spread::well_above(sampler, lit) * (size * sampler.spread(low, high));
    let normal = spread::with_all_in_sight(sampler, position, &vertices, lit);
    // Vertex 0 stays in view, since a gradient is stated there.
    let hidden = 1 + sampler.below(u32::try_from(count - 1).unwrap_or(1)) as usize;
    let [before, corner, after] = [hidden - 1, hidden, (hidden + 1) % count].map(|k| vertices[k]);
    let beyond = corner + (corner - (before + after) * 0.5) * sampler.between(0.5, 3.0);
    let toward = (position - beyond) / (position - beyond).length();
    let top = beyond + toward * (size * sampler.spread(-3, 1));
    let mut scene = polygon.scene(sampler, position, normal);
    scene.occluders.push(vec![before, after, top]);
    scene
}

/// 2^-24 to 2^-3 sizes above the inside; a vertex, or the edge between two, looks over the horizon by 2^-24 to 2^-3 of the depth
/// of the other vertices below it.
pub(super) fn contact_sliver(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let position = inside(sampler, triangle.vertices) + triangle.normal * (triangle.longest * sampler.spread(-24, -3));
    let first = sampler.below(3) as usize;
    let [a, b, c] = [0, 1, 2].map(|k| (triangle.vertices[(first + k) % 3] - position).normalize());
    let [by_b, by_c] = [(b, c), (c, b)].map(|(level, below)| {
        let normal = a.cross(level).normalize();
        if normal.dot(below) > 0.0 { -normal } else { normal }
    });
    // Level with a and b, or with a alone.
    let with_an_edge = sampler.one_in(2);
    let share = if with_an_edge { 1.0 } else { sampler.between(0.1, 0.9) };
    let level = (by_b * share + by_c * (1.0 - share)).normalize();
    let depth = if with_an_edge { -level.dot(c) } else { -level.dot(b).max(level.dot(c)) };
    let toward = if with_an_edge { (a + b) * 0.5 } else { a };
    let normal = level + toward * (depth * sampler.spread(-24, -3));
    let emission = emission::on_triangle(sampler, &triangle.vertices);
    Scene::open(position, normal, triangle.vertices.to_vec(), emission)
}

/// Almost touching, scaled by 2^600 to 2^900 or by the inverse.
pub(super) fn contact_scale(sampler: &mut Sampler) -> Scene {
    let scene = near::contact(sampler);
    extreme(sampler, scene)
}

/// Just above the plane, scaled by 2^600 to 2^900 or by the inverse.
pub(super) fn grazing_scale(sampler: &mut Sampler) -> Scene {
    let scene = near::grazing(sampler);
    extreme(sampler, scene)
}

fn extreme(sampler: &mut Sampler, scene: Scene) -> Scene {
    let exponent = sampler.integer(600, 900);
    let exponent = if sampler.one_in(2) { exponent } else { -exponent };
    spread::in_unit(sampler, scene, exponent)
}

/// By the line of an edge, the emission steep.
pub(super) fn steep_extension(sampler: &mut Sampler) -> Scene {
    let mut scene = near::extension(sampler);
    scene.emission = emission::steep(sampler, &corners(&scene));
    scene
}

/// At 2^3 to 2^27 sizes, the emission polynomial.
pub(super) fn polynomial_far(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::far(sampler);
    scene.emission = emission::polynomial(sampler, &corners(&scene));
    scene
}

/// Cut by the horizon, the emission polynomial.
pub(super) fn polynomial_clipped(sampler: &mut Sampler) -> Scene {
    let mut scene = horizon::clipped(sampler);
    scene.emission = emission::polynomial(sampler, &corners(&scene));
    scene
}

/// The vertices of a triangle.
fn corners(scene: &Scene) -> [DVec3; 3] {
    std::array::from_fn(|k| scene.vertices[k])
}
