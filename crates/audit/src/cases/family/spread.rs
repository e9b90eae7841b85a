//! Fat triangles in free sight, at varied distances, widths, units and origins.

use glam::DVec3;
use radgrad_scene::case::EmissionRecord;

use super::emission;
use super::frame::Triangle;
use super::many_sided;
use super::scene::{Scene, elevations};
use crate::cases::sampler::{Sampler, power_of_two};

/// Wholly above the horizon at 1/4 to 8 sizes.
pub(super) fn generic(sampler: &mut Sampler) -> Scene {
    at_sizes(sampler, -2, 3)
}

/// Wholly above the horizon at 2^low to 2^high sizes.
pub(super) fn at_sizes(sampler: &mut Sampler, low: i64, high: i64) -> Scene {
    let triangle = Triangle::random(sampler);
    let distance = triangle.longest * sampler.spread(low, high);
    in_sight(sampler, triangle.vertices, triangle.normal, distance)
}

/// At 2^3 to 2^27 sizes: 10 to 10^8 and a little on both ends.
pub(super) fn far(sampler: &mut Sampler) -> Scene {
    at_sizes(sampler, 3, 27)
}

/// A triangle on one long edge, its height 2^-27 to 2^-3 of it, at 1/4 to 8 sizes.
pub(super) fn needle(sampler: &mut Sampler) -> Scene {
    needle_at_sizes(sampler, -2, 3)
}

/// The same at 2^low to 2^high sizes.
pub(super) fn needle_at_sizes(sampler: &mut Sampler, low: i64, high: i64) -> Scene {
    let (start, along) = (sampler.cube(), sampler.direction());
    let across = sampler.perpendicular(along);
    let length = sampler.between(0.5, 2.0);
    let top = start + (along * sampler.between(-0.2, 1.2) + across * sampler.spread(-27, -3)) * length;
    let vertices = [start, start + along * length, top];
    let distance = length * sampler.spread(low, high);
    in_sight(sampler, vertices, along.cross(across), distance)
}

/// A receiver at `distance` from the centroid on the lit side, 1/10 of it above the plane at least, facing so that all is in
/// sight.
fn in_sight(sampler: &mut Sampler, vertices: [DVec3; 3], lit: DVec3, distance: f64) -> Scene {
    let centroid = (vertices[0] + vertices[1] + vertices[2]) / 3.0;
    let position = centroid + well_above(sampler, lit) * distance;
    let normal = with_all_in_sight(sampler, position, &vertices, lit);
    let emission = emission::on_triangle(sampler, &vertices);
    Scene::open(position, normal, vertices.to_vec(), emission)
}

/// A direction 1/10 or more above the plane with the normal `lit`.
pub(super) fn well_above(sampler: &mut Sampler, lit: DVec3) -> DVec3 {
    loop {
        let v = sampler.hemisphere(lit);
        if v.dot(lit) > 0.1 {
            return v;
        }
    }
}

/// A random normal with all vertices above the horizon. Facing the plane does it; the tilt away from that is drawn until it does.
pub(super) fn with_all_in_sight(sampler: &mut Sampler, position: DVec3, vertices: &[DVec3], lit: DVec3) -> DVec3 {
    loop {
        let normal = sampler.direction() * sampler.between(0.0, 2.0) - lit;
        if elevations(normal.normalize(), position, vertices).0 > 0.01 {
            return normal;
        }
    }
}

/// Generic, scaled by 2^-300 to 2^300.
pub(super) fn scale(sampler: &mut Sampler) -> Scene {
    let scene = generic(sampler);
    let exponent = sampler.integer(-300, 300);
    in_unit(sampler, scene, exponent)
}

/// The scene in another unit of length: exact, as is the power of two on the normal, which has no unit.
pub(super) fn in_unit(sampler: &mut Sampler, mut scene: Scene, exponent: i64) -> Scene {
    let power = power_of_two(exponent);
    scene.position *= power;
    scene.normal *= power_of_two(sampler.integer(-300, 300));
    for point in scene.vertices.iter_mut().chain(scene.occluders.iter_mut().flatten()) {
        *point *= power;
    }
    if let EmissionRecord::Gradient { gradient, .. } = &mut scene.emission {
        *gradient = gradient.map(|c| c * power_of_two(-exponent));
    }
    scene
}

/// A triangle up to 2^40 sizes from the origin, its coordinates rounded there; or a lattice polygon at 2^19, its coordinates
/// exact.
pub(super) fn far_origin(sampler: &mut Sampler) -> Scene {
    if sampler.one_in(2) {
        return many_sided::far_origin(sampler);
    }
    let mut scene = generic(sampler);
    let shift = sampler.direction() * sampler.spread(3, 41);
    scene.position += shift;
    for vertex in &mut scene.vertices {
        *vertex += shift;
    }
    scene
}
