//! Receivers close to the emitter, its boundary, the line of an edge or its plane.
//!
//! One triangle in two lies in the plane z = 0, where a height is an exact double however small; the other is anywhere, where the
//! receiver's coordinates round the height, which is then a number with few digits but an exact input all the same.

use glam::DVec3;

use super::emission;
use super::frame::{Triangle, inside};
use super::scene::{Scene, normal_where};
use crate::cases::sampler::Sampler;

/// 2^-40 to 2^-3: 1e-12 to 1e-1.
fn small(sampler: &mut Sampler) -> f64 {
    sampler.spread(-40, -3)
}

/// Above the inside.
pub(super) fn contact(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let foot = inside(sampler, triangle.vertices);
    let position = foot + triangle.normal * (triangle.longest * small(sampler));
    facing(sampler, &triangle, position)
}

/// Beside or above the inside of an edge.
pub(super) fn edge(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let (start, along) = triangle.edge(sampler);
    let foot = start + along * sampler.between(0.1, 0.9);
    let position = foot + off_line(sampler, &triangle, along);
    facing(sampler, &triangle, position)
}

/// About a vertex.
pub(super) fn vertex(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let corner = triangle.edge(sampler).0;
    let offset = loop {
        let v = sampler.hemisphere(triangle.normal);
        if v.dot(triangle.normal) > 0.05 {
            break v * (triangle.longest * small(sampler));
        }
    };
    facing(sampler, &triangle, corner + offset)
}

/// By the line of an edge, 1/10 to 2 lengths beyond an end.
pub(super) fn extension(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let (start, along) = triangle.edge(sampler);
    let beyond = sampler.between(0.1, 2.0);
    let foot = start + along * if sampler.one_in(2) { 1.0 + beyond } else { -beyond };
    let position = foot + off_line(sampler, &triangle, along);
    facing(sampler, &triangle, position)
}

/// Beside the triangle, just above its plane.
pub(super) fn grazing(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random_or_horizontal(sampler);
    let aside = sampler.perpendicular(triangle.normal) * sampler.between(1.1, 3.0);
    let position = triangle.centroid() + (aside + triangle.normal * small(sampler)) * triangle.longest;
    facing(sampler, &triangle, position)
}

/// A small vector perpendicular to an edge, to the lit side.
fn off_line(sampler: &mut Sampler, triangle: &Triangle, along: DVec3) -> DVec3 {
    loop {
        let v = sampler.perpendicular(along / along.length());
        if v.dot(triangle.normal).abs() > 0.05 {
            let toward = if v.dot(triangle.normal) < 0.0 { -v } else { v };
            return toward * (triangle.longest * small(sampler));
        }
    }
}

/// Any normal from which some of the triangle is well above the horizon, cut or not. Where rounding put the receiver into the
/// plane or behind it, the case stays: its answer is 0.
pub(super) fn facing(sampler: &mut Sampler, triangle: &Triangle, position: DVec3) -> Scene {
    let normal = normal_where(sampler, position, &triangle.vertices, |_, high| high > 0.1);
    let emission = emission::on_triangle(sampler, &triangle.vertices);
    Scene::open(position, normal, triangle.vertices.to_vec(), emission)
}
