//! The difference of two points, rounded to the scalar or exact.

use glam::DVec3;

use crate::double_double::DoubleDouble;
use crate::exact;
use crate::power::normalising_power;
use crate::real::Real;
use crate::vec3::Vec3;

/// Offset of a point from the receiver, normalised.
#[inline]
pub fn offset<T: Real>(point: DVec3, x: DVec3, power: f64) -> Vec3<T> {
    let along = |a: f64, b: f64| T::difference(a, b, power);
    Vec3::new(along(point.x, x.x), along(point.y, x.y), along(point.z, x.z))
}

/// `(point - origin)`, exact, times a power of two.
#[inline]
pub fn exact_offset(point: DVec3, origin: DVec3, power: f64) -> Vec3<DoubleDouble> {
    let [x, y, z] = exact::difference(point.to_array(), origin.to_array(), power);
    Vec3::new(x, y, z)
}

/// Unit vector along `v`, and the length of `v`. The vector is scaled by its largest component, since the length of a needle's
/// normal may be far below 1.
pub fn unit_vector(v: Vec3<DoubleDouble>) -> (Vec3<DoubleDouble>, f64) {
    let largest = v.x.hi.abs().max(v.y.hi.abs()).max(v.z.hi.abs());
    let power = normalising_power(largest);
    let scaled = v.map(|c| c.scaled(power));
    let norm = scaled.norm_squared().sqrt();
    (scaled.map(|c| c.divided_by(norm)), norm.to_f64() / power)
}
