//! Random emitters and receivers for the tests of four edges at a time.

use glam::DVec3;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Components from -size to size.
pub(crate) fn vector(random: &mut ChaCha8Rng, size: f64) -> DVec3 {
    DVec3::from([(); 3].map(|()| random.random_range(-size..size)))
}

/// A convex polygon of `count` vertices somewhere, a receiver in front of or behind it at up to `e^far` sizes that looks about
/// its way, and the size; `None` where the vertices are no polygon.
pub(crate) fn polygon_and_receiver(random: &mut ChaCha8Rng, count: usize, far: f64) -> Option<(Polygon, Receiver, f64)> {
    // Vertices of a circle, in order of their angles, pulled into an ellipse.
    let mut angles: Vec<f64> = (0..count).map(|_| random.random_range(0.0..6.0)).collect();
    angles.sort_unstable_by(f64::total_cmp);
    let mut vector = |size| vector(random, size);
    let (centre, a, b, size) = (vector(1.0), vector(1.0), vector(1.0), libm::exp(vector(6.0).x));
    let vertices = angles.iter().map(|t| (centre + a * libm::cos(*t) + b * libm::sin(*t)) * size).collect();
    let polygon = Polygon::new(vertices).ok()?;
    let x = centre * size + polygon.normal() * size * libm::exp(vector(far).y) + vector(size);
    let receiver = Receiver::new(x, centre * size - x + vector(size) * 0.5, 1.0).ok()?;
    Some((polygon, receiver, size))
}
