//! Three-vectors over any scalar with ring operations. glam's `DVec3` is the type at the border of the crate; formulas that
//! serve several precisions are written on this one.

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use crate::power::normalising_power;
use crate::real::Real;

/// A vector with components of type `T`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vec3<T> {
    /// The first component.
    pub x: T,
    /// The second one.
    pub y: T,
    /// The third one.
    pub z: T,
}

impl<T: Copy> Vec3<T> {
    /// The vector with these components.
    #[inline(always)]
    pub const fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }

    /// A function of each component.
    #[inline(always)]
    pub fn map<U>(self, f: impl Fn(T) -> U) -> Vec3<U> {
        Vec3 { x: f(self.x), y: f(self.y), z: f(self.z) }
    }
}

impl<T: Real> Vec3<T> {
    /// The origin.
    pub fn zero() -> Self {
        let zero = T::exact(0.0);
        Self::new(zero, zero, zero)
    }

    /// The unit vector along this one.
    pub fn unit(self) -> Self {
        self * (T::exact(1.0) / self.norm_squared().sqrt())
    }
}

impl<T> Vec3<T>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// The square of the length.
    #[inline(always)]
    pub fn norm_squared(self) -> T {
        self.dot(self)
    }
}

impl Vec3<f64> {
    /// Euclidean length of a vector not far from 1 in size. Always inlined: calls out of a vector unit's code cost more than it
    /// does.
    #[inline(always)]
    pub fn norm(self) -> f64 {
        self.norm_squared().sqrt()
    }

    /// Euclidean length, to a few roundings; lengths whose squares leave the range of a double are answered too.
    #[inline(always)]
    pub fn length(self) -> f64 {
        let power = normalising_power(self.x.abs().max(self.y.abs()).max(self.z.abs()));
        (self * power).norm_squared().sqrt() / power
    }
}

impl<T: Copy + Add<Output = T>> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<T: Copy + Sub<Output = T>> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<T: Copy + Neg<Output = T>> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<T: Copy + Mul<Output = T>> Mul<T> for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl From<DVec3> for Vec3<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vec3<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vec3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}
