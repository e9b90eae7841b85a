//! Eq. 1 and its gradient integrated directly, by a product Gauss rule: the reference where no published number exists.
//!
//! `B(x) = (rho/pi) int B(y) (n1.r)(-n2.r)/r^4 dA`, and for the gradient the kernel differentiated with respect to `x`. The
//! emitter is a fan of signed triangles from its first vertex, each clipped by the horizon, cut into 16 and mapped from a
//! square. Nothing is shared with either closed form but the problem's types. For receivers about as far as the emitter is
//! wide: the two orders must agree to 1e-13, or it panics.

use glam::DVec3;
use radgrad_core::{Emitter, Receiver};

use crate::RelativeError;

/// Radiosity and gradient, right to 1e-13.
///
/// # Panics
/// If two orders of the rule do not agree to 1e-13.
#[must_use]
pub fn radiosity_and_gradient(receiver: &Receiver, emitter: &Emitter) -> (f64, DVec3) {
    let [coarse, fine] = [20, 28].map(|order| by_order(receiver, emitter, order));
    let difference = RelativeError::new(coarse, fine);
    assert!(difference.largest() < 1e-13, "direct integration is not settled: {difference:?} at {receiver:?}");
    fine
}

fn by_order(receiver: &Receiver, emitter: &Emitter, order: usize) -> (f64, DVec3) {
    let n2 = emitter.polygon().normal();
    let vertices = emitter.polygon().vertices();
    if n2.dot(receiver.position() - vertices[0]) <= 0.0 {
        return (0.0, DVec3::ZERO);
    }
    let rule = gauss_legendre(order);
    let mut sum = (0.0, DVec3::ZERO);
    for pair in vertices[1..].windows(2) {
        let visible = above_horizon(&[vertices[0], pair[0], pair[1]], receiver);
        for fan in visible.get(1..).unwrap_or_default().windows(2) {
            for triangle in quartered([visible[0], fan[0], fan[1]]).into_iter().flat_map(quartered) {
                add_triangle(&mut sum, triangle, &rule, receiver, emitter);
            }
        }
    }
    let factor = receiver.reflectance() / std::f64::consts::PI;
    (factor * sum.0, factor * sum.1)
}

/// Part of a triangle with `n1.r >= 0`.
fn above_horizon(triangle: &[DVec3; 3], receiver: &Receiver) -> Vec<DVec3> {
    let height = |p: DVec3| receiver.normal().dot(p - receiver.position());
    let mut part = Vec::new();
    for (i, &a) in triangle.iter().enumerate() {
        let b = triangle[(i + 1) % 3];
        if height(a) >= 0.0 {
            part.push(a);
        }
        if height(a) * height(b) < 0.0 {
            part.push(a + (b - a) * (height(a) / (height(a) - height(b))));
        }
    }
    part
}

fn quartered([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
}

/// Adds the integral over one triangle, `y = a + u [(b - a) + v (c - b)]` with area element `2 A u du dv`.
fn add_triangle(sum: &mut (f64, DVec3), [a, b, c]: [DVec3; 3], rule: &[(f64, f64)], receiver: &Receiver, emitter: &Emitter) {
    let (n1, n2) = (receiver.normal(), emitter.polygon().normal());
    let twice_area = n2.dot((b - a).cross(c - a));
    for &(u, weight_u) in rule {
        for &(v, weight_v) in rule {
            let y = a + u * ((b - a) + v * (c - b));
            let r = y - receiver.position();
            let (cos_1, cos_2, rr) = (n1.dot(r), -n2.dot(r), r.length_squared());
            let weight = twice_area * u * weight_u * weight_v * emitter.emission_at(y) / (rr * rr);
            sum.0 += weight * cos_1 * cos_2;
            sum.1 += weight * (n2 * cos_1 - n1 * cos_2 + r * (4.0 * cos_1 * cos_2 / rr));
        }
    }
}

/// Nodes and weights on [0, 1]: zeros of the Legendre polynomial by Newton's method from Tricomi's estimate.
#[must_use]
pub fn gauss_legendre(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    (0..order)
        .map(|i| {
            let mut x = libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut previous, mut here) = (1.0, x);
                for k in 2..=order {
                    let k = k as f64;
                    (previous, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * previous) / k);
                }
                slope = n * (previous - x * here) / (1.0 - x * x);
                x -= here / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::paper_scene;

    #[test]
    fn published_values_of_the_papers_scene_are_met() {
        for case in paper_scene() {
            let answer = radiosity_and_gradient(&case.receiver, &case.emitter);
            let error = case.error_of(answer);
            assert!(error.largest() < 1e-13, "{}: {error:?}", case.id);
        }
    }
}
