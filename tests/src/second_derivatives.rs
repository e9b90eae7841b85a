//! Second derivatives as central differences of gradients with many digits.
//!
//! A receiver at the origin can be moved by any power of two exactly, so that the step can be a tiny part of the distance to
//! whatever the gradient is not smooth at: the plane of the emitter, or a position from which a vertex is in the horizon. With a
//! part p the difference is off by about p^2, and p of the digits go into the step.

use glam::{DMat3, DVec3};
use radgrad_core::{Emission, Emitter, Polygon, Receiver};

use crate::many_digits::{ManyDigits, distance};

/// A constant emitter seen from the origin.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Where the receiver faces, at any length.
    pub normal: DVec3,
    /// The emitter.
    pub emitter: Emitter,
    /// The polygons that may hide it.
    pub occluders: Vec<Polygon>,
}

impl Seen {
    /// The scene moved such that the receiver is at the origin, the emission made constant, in a unit in which the Hessian is in
    /// range: `None` where rounding leaves no polygon.
    #[must_use]
    pub fn moved(receiver: &Receiver, emitter: &Emitter) -> Option<Self> {
        let vertices: Vec<DVec3> = emitter.polygon().vertices().iter().map(|v| *v - receiver.position()).collect();
        let farthest = vertices.iter().fold(0.0, |most: f64, v| most.max(v.abs().max_element()));
        let emission = 1.25 * 2f64.powi((2 * libm::ilogb(farthest)).clamp(-1000, 1000));
        let emitter = Emitter::new(Polygon::new(vertices).ok()?, Emission::Constant(emission)).ok()?;
        Some(Self { normal: receiver.direction(), emitter, occluders: Vec::new() })
    }

    /// The receiver at a point near the origin.
    ///
    /// # Panics
    /// If the normal is zero.
    #[must_use]
    pub fn receiver(&self, position: DVec3) -> Receiver {
        Receiver::new(position, self.normal, 0.75).unwrap()
    }

    /// Distance to the nearest position at which the gradient is not smooth.
    #[must_use]
    pub fn smooth_range(&self) -> f64 {
        let (polygon, n1) = (self.emitter.polygon(), self.receiver(DVec3::ZERO).normal());
        let to_horizon = polygon.vertices().iter().map(|v| n1.dot(*v).abs());
        to_horizon.fold(polygon.normal().dot(polygon.vertices()[0]).abs(), f64::min)
    }

    /// The Hessian from gradients in decimal digits, with a step of the power of two next to `part` of the smooth range.
    ///
    /// # Panics
    /// If a gradient is no decimal number.
    #[must_use]
    pub fn hessian(&self, part: f64, gradient: impl Fn(&Receiver) -> [String; 3]) -> Matrix {
        let step = 2f64.powi(libm::ilogb(self.smooth_range() * part));
        let columns = DVec3::AXES.map(|axis| {
            let [after, before] = [step, -step].map(|step| gradient(&self.receiver(axis * step)));
            [0, 1, 2].map(|i| ManyDigits::new(&after[i]).minus(&ManyDigits::new(&before[i])).over(2.0 * step))
        });
        Matrix(columns.into_iter().flatten().collect())
    }
}

/// A matrix of many digits, by columns.
#[derive(Debug, Clone)]
pub struct Matrix(Vec<ManyDigits>);

impl Matrix {
    /// Frobenius norm.
    #[must_use]
    pub fn norm(&self) -> f64 {
        self.distance(&DMat3::ZERO)
    }

    /// Frobenius norm of the difference from a matrix of doubles.
    #[must_use]
    pub fn distance(&self, other: &DMat3) -> f64 {
        distance(&self.0, &other.to_cols_array().map(ManyDigits::from))
    }

    /// Frobenius norm of the difference from another.
    #[must_use]
    pub fn distance_to(&self, other: &Self) -> f64 {
        distance(&self.0, &other.0)
    }
}
