//! Emission for the families: constant, by vertex values and by gradient in equal parts, positive all over the emitter.

use glam::DVec3;
use radgrad_scene::case::EmissionRecord;

use crate::lattice::Site;
use crate::sampler::{Sampler, power_of_two};

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

/// A value at vertex 0 and a gradient of random direction, its part along the normal included, that takes away at most 9/10 of
/// it.
fn by_gradient(sampler: &mut Sampler, vertices: &[DVec3]) -> EmissionRecord {
    let value = sampler.spread(-3, 3);
    let reach = vertices.iter().map(|v| (*v - vertices[0]).length()).fold(0.0, f64::max);
    let gradient = sampler.direction() * (value * sampler.between(0.0, 0.9) / reach);
    EmissionRecord::Gradient { value, gradient: gradient.to_array() }
}
