//! Doubles at the ends of their range: receivers that are on the surface but for rounding, normals and lengths whose squares
//! underflow, numbers of very different exponents side by side, values that cancel.

use glam::DVec3;
use radgrad_scene::case::EmissionRecord;

use super::emission;
use super::frame::{Triangle, inside};
use super::many_sided;
use super::near;
use super::scene::{Scene, elevations, normal_where};
use super::spread;
use crate::cases::sampler::{Sampler, power_of_two};

/// A point of a triangle, inside or on an edge, as far as rounding allows: that decides whether it is in front.
pub(super) fn on_surface(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::random(sampler);
    let position = if sampler.one_in(2) {
        inside(sampler, triangle.vertices)
    } else {
        let (start, along) = triangle.edge(sampler);
        start + along * sampler.between(0.1, 0.9)
    };
    near::facing(sampler, &triangle, position)
}

/// Generic, the receiver's normal 2^-1040 to 2^-100 long: its square underflows, or it itself is subnormal.
pub(super) fn short_normal(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let exponent = sampler.integer(-1040, -100);
    scene.normal = times_power(scene.normal, exponent);
    scene
}

/// Generic, at a size of 2^-1040 to 2^-1010, so that coordinates are subnormal and have 34 bits at least; the emission is as small as
/// the gradient takes to be representable.
pub(super) fn subnormal(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::at_sizes(sampler, -2, 1);
    let exponent = sampler.integer(-1040, -1010);
    scene.position = times_power(scene.position, exponent);
    for vertex in &mut scene.vertices {
        *vertex = times_power(*vertex, exponent);
    }
    match &mut scene.emission {
        EmissionRecord::Constant { constant } => *constant *= power_of_two(-80),
        EmissionRecord::Vertices { vertices } => vertices.iter_mut().for_each(|value| *value *= power_of_two(-80)),
        EmissionRecord::Gradient { value, gradient } => {
            *value *= power_of_two(-80);
            *gradient = times_power(DVec3::from_array(*gradient), -80 - exponent).to_array();
        }
        EmissionRecord::Polynomial { .. } | EmissionRecord::Expression { .. } => {}
    }
    scene
}

/// Generic, but that one coordinate in three of position, vertices and normal is 2^-1000 to 2^-200, and the emission 2^-900 to
/// 2^900, at each vertex by itself.
pub(super) fn mixed_exponents(sampler: &mut Sampler) -> Scene {
    loop {
        let mut scene = spread::generic(sampler);
        let Scene { position, normal, vertices, .. } = &mut scene;
        for vector in vertices.iter_mut().chain([position, normal]) {
            for axis in 0..3 {
                if sampler.one_in(3) {
                    vector[axis] = sampler.sign() * sampler.spread(-1000, -200);
                }
            }
        }
        let [a, b, c] = [0, 1, 2].map(|k| scene.vertices[k]);
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let is_fat = cross.length() > 0.1 * longest * longest && scene.normal.length() > 0.1;
        if !is_fat || cross.dot(scene.position - a) < 0.05 * cross.length() * longest {
            continue;
        }
        if elevations(scene.normal / scene.normal.length(), scene.position, &scene.vertices).1 < 0.1 {
            continue;
        }
        let exponent = sampler.integer(-900, 899);
        match &mut scene.emission {
            EmissionRecord::Constant { constant } => *constant *= power_of_two(exponent),
            EmissionRecord::Vertices { vertices } => vertices.fill_with(|| sampler.spread(-900, 900)),
            EmissionRecord::Gradient { value, gradient } => {
                // So little that it takes nothing away, or all that is allowed, over the size of the triangle.
                *value *= power_of_two(exponent);
                let reach = longest.max(1.0);
                let slope = DVec3::from_array(*gradient);
                *gradient = times_power(slope / (slope.length() * 2.0 * reach), exponent - 4).to_array();
            }
            EmissionRecord::Polynomial { .. } | EmissionRecord::Expression { .. } => {}
        }
        return scene;
    }
}

/// Values at the vertices that cancel but for 2^-50 to 2^-3 of them: odd over a triangle with a plane of symmetry, in which the
/// receiver is.
pub(super) fn cancelling_values(sampler: &mut Sampler) -> Scene {
    let (half, low, high) = (sampler.between(0.3, 1.0), sampler.between(-1.0, 0.0), sampler.between(0.3, 1.0));
    let turn = sampler.below(3) as usize;
    // The first axis is across the plane of symmetry, the third along the normal.
    let turned = |v: [f64; 3]| DVec3::from_array([0, 1, 2].map(|axis| v[(axis + turn) % 3]));
    let vertices = [[-half, low, 0.0], [half, low, 0.0], [0.0, high, 0.0]].map(turned).to_vec();
    let position = turned([0.0, sampler.between(-2.0, 2.0), sampler.spread(-8, 3)]);
    let normal = loop {
        let normal = turned([0.0, sampler.between(-1.0, 1.0), sampler.between(-1.0, 0.3)]);
        if elevations(normal.normalize(), position, &vertices).1 > 0.1 {
            break normal;
        }
    };
    let value = sampler.spread(-4, 4);
    let third = value * sampler.sign() * sampler.spread(-50, -3);
    Scene::open(position, normal, vertices, EmissionRecord::Vertices { vertices: vec![-value, value, third] })
}

/// A horizontal triangle with a fourth vertex 2^-48 to 2^-20 of an edge's length from another, on the edge as far as rounding
/// allows; or two vertices of a triangle as near to each other.
pub(super) fn near_coincident_vertices(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::horizontal(sampler);
    let first = sampler.below(3) as usize;
    let [a, b, c] = [0, 1, 2].map(|k| triangle.vertices[(first + k) % 3]);
    let share = sampler.spread(-48, -20);
    let vertices = if sampler.one_in(2) { vec![a, a + (b - a) * share, b, c] } else { vec![a, a + (b - a) * share, c] };
    let over = inside(sampler, triangle.vertices);
    let aside = sampler.perpendicular(DVec3::Z);
    let foot = if sampler.one_in(2) { over } else { a + aside * sampler.between(0.0, 3.0) };
    let position = foot + DVec3::Z * sampler.spread(-10, 2);
    let normal = normal_where(sampler, position, &vertices, |_, high| high > 0.1);
    let emission = loop {
        match emission::on_triangle(sampler, &[a, b, c]) {
            EmissionRecord::Vertices { .. } => {}
            other => break other,
        }
    };
    Scene::open(position, normal, vertices, emission)
}

/// A star with a hundred vertices, exactly planar.
pub(super) fn hundred_vertices(sampler: &mut Sampler) -> Scene {
    many_sided::star(sampler, 100)
}

/// Occluders that hide nothing, exactly: in the emitter's plane, over it or sharing an edge with it; in the receiver's horizon;
/// and seen edge-on before the emitter.
pub(super) fn occluders_in_plane(sampler: &mut Sampler) -> Scene {
    let triangle = Triangle::horizontal(sampler);
    // On the line x = 0, which is the trace of the emitter seen edge-on; heights are multiples of 2^-20, so that they cancel
    // exactly.
    let height = (sampler.spread(-3, 3) * power_of_two(20)).floor() * power_of_two(-20);
    let position = DVec3::new(0.0, sampler.between(-1.0, 1.0), height);
    let normal =
        if sampler.one_in(2) { -DVec3::Z } else { normal_where(sampler, position, &triangle.vertices, |_, high| high > 0.1) };
    let emission = emission::on_triangle(sampler, &triangle.vertices);
    let mut scene = Scene::open(position, normal, triangle.vertices.to_vec(), emission);
    let other = Triangle::horizontal(sampler).vertices;
    let (start, along) = triangle.edge(sampler);
    let beyond = start + along * 0.5 + (start + along * 0.5 - triangle.centroid()).with_z(0.0);
    let mut edge_on = || DVec3::new(0.0, sampler.between(-1.5, 1.5), height * sampler.between(0.1, 0.9));
    let upright = [edge_on(), edge_on(), edge_on()];
    scene.occluders = vec![other.to_vec(), vec![start, start + along, beyond.with_z(0.0)], upright.to_vec()];
    if normal == -DVec3::Z {
        scene.occluders.push(other.map(|v| v.with_z(height)).to_vec());
    }
    scene
}

/// Times 2^exponent, which may be beyond the normal range: rounded once.
fn times_power(v: DVec3, exponent: i64) -> DVec3 {
    let first = exponent.clamp(-1000, 1000);
    v * power_of_two(first) * power_of_two(exponent - first)
}
