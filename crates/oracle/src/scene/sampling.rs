//! Points of faces, directions and points of lamps as they are seen.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardUniform};

use super::Face;
use super::distance::Corners3;
use crate::monte_carlo::sampling::Corners;
use crate::region::plane::{Triangle, Vertex};

/// A number in [0, 1).
pub(super) fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    StandardUniform.sample(generator)
}

/// A point of a triangle, uniform over its area (G. Turk 1990).
pub(super) fn on_triangle([a, b, c]: &Corners3, generator: &mut ChaCha8Rng) -> DVec3 {
    let (root, v) = (uniform(generator).sqrt(), uniform(generator));
    *a * (1.0 - root) + *b * (root * (1.0 - v)) + *c * (root * v)
}

pub(super) fn area([a, b, c]: &Corners3) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// A direction with the density `cos / pi` around a unit normal: a uniform point of the disk, raised to the hemisphere.
pub(super) fn by_cosine(normal: DVec3, generator: &mut ChaCha8Rng) -> DVec3 {
    let [tangent, other] = tangents(normal);
    loop {
        let bits = generator.next_u64();
        let half = |bits: u64| (bits & 0xffff_ffff) as f64 / f64::from(1_u32 << 31) - 1.0;
        let [x, y] = [half(bits), half(bits >> 32)];
        let square = x * x + y * y;
        if square < 1.0 {
            return tangent * x + other * y + normal * (1.0 - square).sqrt();
        }
    }
}

/// Two unit vectors that make a right-handed frame with a unit normal (T. Duff et al., JCGT 2017).
pub(super) fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0_f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// A triangle of a lamp.
#[derive(Debug)]
pub(super) struct LampTriangle {
    pub(super) face: usize,
    pub(super) corners: Corners3,
    pub(super) emitted: f64,
    area: f64,
    normal: DVec3,
    tangents: [DVec3; 2],
}

impl LampTriangle {
    pub(super) fn new(face: usize, corners: Corners3, surface: &Face) -> Self {
        let normal = surface.polygon.normal();
        Self { face, emitted: surface.emitted, area: area(&corners), normal, tangents: tangents(normal), corners }
    }

    pub(super) fn power(&self) -> f64 {
        self.emitted * self.area
    }

    /// How it is seen from a point: nothing from behind.
    pub(super) fn seen_from(&self, point: DVec3) -> Option<Corners> {
        let height = self.normal.dot(point - self.corners[0]);
        if height <= 0.0 {
            return None;
        }
        let [tangent, other] = self.tangents;
        let corner = |c: DVec3| Vertex { p: tangent.dot(c - point), q: other.dot(c - point), s: 0.0, b: 0.0 };
        Some(Corners::new(&Triangle { corners: self.corners.map(corner), area: self.area }, height))
    }

    /// The point with these weights of the corners.
    pub(super) fn point(&self, weights: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.corners;
        a * weights[0] + b * weights[1] + c * weights[2]
    }
}

/// `k(x, y)` for the vector from x to y, 0 where one does not face the other.
pub(super) fn kernel(from: DVec3, to: DVec3, ray: DVec3) -> f64 {
    let (leaves, arrives, square) = (from.dot(ray), -to.dot(ray), ray.length_squared());
    if leaves > 0.0 && arrives > 0.0 { leaves * arrives / (PI * square * square) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn directions_follow_the_cosine() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let normal = DVec3::new(0.48, -0.6, -0.64);
        let count = 40_000;
        let cosines: Vec<f64> = (0..count).map(|_| by_cosine(normal, &mut generator).dot(normal)).collect();
        let mean = |power: i32| cosines.iter().map(|c| c.powi(power)).sum::<f64>() / f64::from(count);
        // The density of the cosine c is 2 c.
        assert!((mean(1) - 2.0 / 3.0).abs() < 5e-3 && (mean(2) - 0.5).abs() < 5e-3, "{} {}", mean(1), mean(2));
        let frame = tangents(normal);
        assert!(frame[0].cross(frame[1]).dot(normal) > 1.0 - 1e-15);
    }
}
