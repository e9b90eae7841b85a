//! Vectors in the frame of a region.

use std::ops::{Add, Mul, Sub};

use glam::DVec3;

/// A vector in the frame `(u, v, n2)` of a region, of another type than one in space so that none is taken for the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrameVector(DVec3);

impl FrameVector {
    pub(crate) const fn new(u: f64, v: f64, n2: f64) -> Self {
        Self(DVec3::new(u, v, n2))
    }

    pub(crate) const fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.0.dot(other.0)
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        Self(self.0.cross(other.0))
    }

    pub(crate) fn length(self) -> f64 {
        self.0.length()
    }

    pub(crate) fn length_squared(self) -> f64 {
        self.0.length_squared()
    }

    /// Of length 1; each component is rounded once more than the length.
    pub(crate) fn direction(self) -> Self {
        Self(self.0 / self.length())
    }
}

impl Add for FrameVector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for FrameVector {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul<FrameVector> for f64 {
    type Output = FrameVector;

    fn mul(self, vector: FrameVector) -> FrameVector {
        FrameVector(self * vector.0)
    }
}
