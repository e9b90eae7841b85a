//! Emission for the families, positive all over the emitter: constant, by vertex values and by gradient in equal parts; or steep;
//! or polynomial.

use glam::DVec3;
use radgrad_scene::case::{EmissionRecord, PolynomialRecord, TermRecord};

use crate::cases::lattice::Site;
use crate::cases::sampler::{Sampler, power_of_two};

/// For a triangle.
pub(super) fn on_triangle(sampler: &mut Sampler, vertices: &[DVec3; 3]) -> EmissionRecord {
    match sampler.below(3) {
        0 => EmissionRecord::Constant { constant: sampler.spread(-4, 4) },
        1 => EmissionRecord::Vertices { vertices: vertices.iter().map(|_| sampler.spread(-3, 3)).collect() },
        _ => by_gradient(sampler, vertices),
    }
}

/// For a polygon on lattice sites. Vertex values are an affine function of the sites with integer coefficients, exact in doubles.
pub(super) fn on_sites(sampler: &mut Sampler, vertices: &[DVec3], sites: &[Site]) -> EmissionRecord {
    match sampler.below(3) {
        0 => EmissionRecord::Constant { constant: sampler.spread(-4, 4) },
        1 => {
            let [base, along, across] = [sampler.integer(1, 1 << 13), sampler.integer(-4, 4), sampler.integer(-4, 4)];
            let value = |s: &Site| along * s[0] + across * s[1];
            let lowest = sites.iter().map(value).min().unwrap_or(0);
            let exact = |s: &Site| (value(s) - lowest + base) as f64 * power_of_two(-14);
            EmissionRecord::Vertices { vertices: sites.iter().map(exact).collect() }
        }
        _ => by_gradient(sampler, vertices),
    }
}

/// For a polygon that may be flat up to a rounding only, where vertex values would contradict each other.
pub(super) fn in_space(sampler: &mut Sampler, vertices: &[DVec3]) -> EmissionRecord {
    if sampler.one_in(2) {
        return EmissionRecord::Constant { constant: sampler.spread(-4, 4) };
    }
    by_gradient(sampler, vertices)
}

/// A value at vertex 0 and a gradient of random direction, its part along the normal included, that takes away at most 9/10 of
/// it.
fn by_gradient(sampler: &mut Sampler, vertices: &[DVec3]) -> EmissionRecord {
    let value = sampler.spread(-3, 3);
    let reach = reach(vertices);
    let gradient = sampler.direction() * (value * sampler.between(0.0, 0.9) / reach);
    EmissionRecord::Gradient { value, gradient: gradient.to_array() }
}

/// Linear and steep: vertex values from 2^-20 to 2^20, or a gradient that makes of the value at vertex 0 up to 2^30 times as
/// much.
pub(super) fn steep(sampler: &mut Sampler, vertices: &[DVec3; 3]) -> EmissionRecord {
    if sampler.one_in(2) {
        return EmissionRecord::Vertices { vertices: vertices.iter().map(|_| sampler.spread(-20, 20)).collect() };
    }
    let [a, b, c] = *vertices;
    let value = sampler.spread(-3, 3);
    // Within a right angle of both edges at vertex 0, so that nothing is taken away.
    let ascent = (b - a).normalize() + (c - a).normalize();
    let gradient = ascent * (value * sampler.spread(0, 30) / reach(vertices));
    EmissionRecord::Gradient { value, gradient: gradient.to_array() }
}

/// A polynomial of degree 2 to 6 about a point near vertex 0: a value, terms that take away at most 9/10 of it, and one time in
/// two a square of up to 2^10 times as much.
pub(super) fn polynomial(sampler: &mut Sampler, vertices: &[DVec3; 3]) -> EmissionRecord {
    let value = sampler.spread(-3, 3);
    let size = reach(vertices);
    let origin = vertices[0] + sampler.cube() * (0.5 * size);
    let far = vertices.iter().map(|v| (*v - origin).length()).fold(0.0, f64::max);
    let over = |degree: u8| (0..degree).fold(1.0, |power, _| power * far);
    let mut terms = vec![TermRecord { coefficient: value, powers: [0; 3] }];
    let count = 1 + sampler.below(4);
    for _ in 0..count {
        let share = sampler.sign() * sampler.between(0.0, 0.9) / f64::from(count);
        let degree = 2 + small(sampler, 5);
        let first = small(sampler, degree + 1);
        let second = small(sampler, degree - first + 1);
        terms.push(TermRecord { coefficient: value * share / over(degree), powers: [first, second, degree - first - second] });
    }
    if sampler.one_in(2) {
        let mut powers = [0; 3];
        powers[sampler.below(3) as usize] = 2;
        terms.push(TermRecord { coefficient: value * sampler.spread(-3, 10) / over(2), powers });
    }
    EmissionRecord::Polynomial { polynomial: PolynomialRecord { origin: origin.to_array(), terms } }
}

/// Uniform in 0..count.
fn small(sampler: &mut Sampler, count: u8) -> u8 {
    u8::try_from(sampler.below(u32::from(count))).unwrap_or(0)
}

/// Largest distance of a vertex from vertex 0.
fn reach(vertices: &[DVec3]) -> f64 {
    vertices.iter().map(|v| (*v - vertices[0]).length()).fold(0.0, f64::max)
}
