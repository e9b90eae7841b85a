//! An affine function over the plane of a polygon.

use radgrad_numbers::ball::Ball;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

/// The emission as `value + gradient . (y - vertex 0)`, with the gradient in the polygon's plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    pub(crate) value: f64,
    pub(crate) gradient: Vec3<DoubleDouble>,
    /// Bound on the error of each component of `gradient`.
    pub(super) gradient_error: f64,
    /// Largest difference between a vertex value as given and this function.
    pub(crate) residual: f64,
}

/// The larger of two bounds; NaN bounds nothing.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

impl Affine {
    /// Bound on the error of each component of the gradient.
    pub(crate) const fn gradient_error(&self) -> f64 {
        self.gradient_error
    }

    pub(crate) fn new(value: f64, gradient: Vec3<Ball<DoubleDouble>>) -> Self {
        let gradient_error = [gradient.x, gradient.y, gradient.z].map(Real::error).into_iter().fold(0.0, larger);
        Self { value, gradient: gradient.map(Ball::middle), gradient_error, residual: 0.0 }
    }
}
