//! Vectors in the frame of a region.

use std::ops::{Add, Mul, Sub};

/// A vector in the frame `(u, v, n2)` of a region, of another type than one in space so that none is taken for the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrameVector {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

impl FrameVector {
    pub(crate) const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        Self::new(self.y * other.z - self.z * other.y, self.z * other.x - self.x * other.z, self.x * other.y - self.y * other.x)
    }

    pub(crate) fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    pub(crate) fn norm(self) -> f64 {
        self.norm_squared().sqrt()
    }

    /// The unit vector along this one.
    pub(crate) fn unit(self) -> Self {
        let norm = self.norm();
        Self::new(self.x / norm, self.y / norm, self.z / norm)
    }
}

impl Add for FrameVector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for FrameVector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<FrameVector> for f64 {
    type Output = FrameVector;
    fn mul(self, v: FrameVector) -> FrameVector {
        FrameVector::new(self * v.x, self * v.y, self * v.z)
    }
}
