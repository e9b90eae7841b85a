//! Properties that files have and drawn scenes seldom do: things of very different size beside each other, walls that stand on
//! the floor, normals whose components are far apart, and vertices in single precision.

use glam::DVec3;
use radgrad_scene::case::EmissionRecord;

use super::emission;
use super::frame::{Triangle, inside};
use super::many_sided;
use super::occluded::on_the_way;
use super::scene::{Scene, normal_where};
use super::spread;
use crate::cases::sampler::{Sampler, power_of_two};

/// An occluder 2^-160 to 2^160 times as far away, or as large, as the emitter: beyond, the enclosure has no truth within its
/// budget. The receiver is at the origin, so that a nearer occluder is so exactly; a larger one ends in the way, and reaches out
/// along the axes.
pub(super) fn other_scale(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let origin = std::mem::replace(&mut scene.position, DVec3::ZERO);
    scene.vertices.iter_mut().for_each(|vertex| *vertex -= origin);
    let screen = on_the_way(sampler, &scene, 0.2, 0.8, 0.3);
    let screen = if sampler.one_in(2) {
        let near = sampler.spread(-160, -8);
        screen.iter().map(|v| *v * near).collect()
    } else {
        let first = sampler.below(3) as usize;
        let [along, outward] = [(first + 1) % 3, (first + 2) % 3];
        let (reach, side) = (power_of_two(sampler.integer(8, 160)), sampler.sign());
        let mut corners = [screen[0]; 3];
        (corners[0][along], corners[1][along], corners[2][outward]) = (-reach, reach, side * reach);
        corners.to_vec()
    };
    scene.occluders.push(screen);
    scene
}

/// A wall in the way that stands on the receiver's floor, with an edge or a corner exactly in its plane.
pub(super) fn standing(sampler: &mut Sampler) -> Scene {
    let (position, vertices) = loop {
        let position = DVec3::new(sampler.between(-0.5, 0.5), sampler.between(-0.5, 0.5), 0.0);
        let over = DVec3::new(sampler.between(-2.0, 2.0), sampler.between(-2.0, 2.0), sampler.between(1.2, 3.0));
        let [a, b, c] = Triangle::random(sampler).vertices.map(|v| v + over);
        let facing = (b - a).cross(c - a).dot(position - a);
        if facing.abs() > 0.2 {
            break (position, if facing > 0.0 { [a, b, c] } else { [a, c, b] });
        }
    };
    let way = inside(sampler, vertices) - position;
    let share = sampler.between(0.2, 0.7);
    let foot = position + way.with_z(0.0) * share;
    let across = DVec3::new(-way.y, way.x, 0.0) + DVec3::new(sampler.between(-0.2, 0.2), sampler.between(-0.2, 0.2), 0.0);
    let [left, right] = [1.0, -1.0].map(|side| foot + across * (side * sampler.between(0.1, 0.8)));
    let height = way.z * share * sampler.between(0.6, 1.5);
    let [over_left, over_right] = [left, right].map(|v| v.with_z(height));
    let wall = if sampler.one_in(3) { vec![foot, over_right, over_left] } else { vec![left, right, over_right, over_left] };
    let emission = emission::on_triangle(sampler, &vertices);
    Scene { occluders: vec![wall], ..Scene::open(position, DVec3::Z, vertices.to_vec(), emission) }
}

/// A receiver's normal whose components are 2^60 to 2^240 apart, and an emitter that reaches just up to the horizon of the large
/// one: the part that is seen is as narrow as the small one is. The radiosity is as the square of that, and the enclosure's radii
/// are doubles.
pub(super) fn steep_normal(sampler: &mut Sampler) -> Scene {
    let turn = sampler.below(3) as usize;
    let turned = |v: [f64; 3]| DVec3::from_array([0, 1, 2].map(|axis| v[(axis + turn) % 3]));
    let exponent = sampler.integer(60, 240);
    // So that neither leaves the normal range.
    let largest = sampler.integer(exponent - 1020, 1000);
    let small = sampler.between(1.0, 2.0) * power_of_two(largest - exponent);
    let normal = turned([small, 0.0, power_of_two(largest)]);
    let [near, far] = [-1.0, 1.0].map(|side| side * sampler.between(0.2, 2.0));
    let [low, lower] = [0; 2].map(|_| -sampler.between(0.2, 2.0));
    let distance = sampler.between(0.5, 2.0);
    let corners = [[near, low], [near, 0.0], [far, 0.0], [far, lower]];
    let vertices = corners.map(|[across, height]| turned([distance, across, height])).to_vec();
    let constant = sampler.between(0.5, 1.0) * power_of_two(exponent);
    Scene::open(DVec3::ZERO, normal, vertices, EmissionRecord::Constant { constant })
}

/// A convex polygon, and in half of the cases a quadrilateral on the way to it: all moved by up to 2^8 along each axis and rounded to single
/// precision. The receiver is a tenth or more over the polygon's plane. No vertex is on the line of its neighbours: of a triangle as narrow
/// as the rounding the surface may face either way, where the enclosure takes one of them.
pub(super) fn single(sampler: &mut Sampler) -> Scene {
    let mut scene = many_sided::few_sided(sampler);
    let around = |k: usize| scene.vertices[k] - scene.vertices[0];
    let lit = (2..scene.vertices.len()).fold(DVec3::ZERO, |sum, k| sum + around(k - 1).cross(around(k)));
    scene.position += lit * (sampler.between(0.1, 1.0) / lit.length());
    scene.normal = normal_where(sampler, scene.position, &scene.vertices, |_, highest| highest > 0.1);
    scene.emission = emission::in_space(sampler, &scene.vertices);
    if sampler.one_in(2) {
        let mut screen = on_the_way(sampler, &scene, 0.2, 0.8, 0.3);
        screen.push(screen[0] + screen[2] - screen[1]);
        scene.occluders.push(screen);
    }
    let by = sampler.cube() * sampler.spread(-1, 8);
    scene.position += by;
    let outlines = scene.occluders.iter_mut().chain([&mut scene.vertices]).flatten();
    let mut largest: f64 = 0.0;
    for vertex in outlines {
        *vertex = (*vertex + by).as_vec3().as_dvec3();
        largest = largest.max(vertex.abs().max_element());
    }
    // Half an ulp of the largest coordinate.
    Scene { precision: largest * power_of_two(-24), ..scene }
}
