//! Second derivatives as central differences of gradients with many digits.
//!
//! A receiver at the origin can be moved by any power of two exactly, so that the step can be a tiny part of the distance to
//! whatever the gradient is not smooth at: the plane of the emitter, or a position from which a vertex is in the horizon. With a
//! part p the difference is off by about p^2, and p of the digits go into the step.

use astro_float::{BigFloat, Consts, Radix, RoundingMode, Sign};
use glam::{DMat3, DVec3};
use radgrad_core::{Emission, Emitter, Polygon, Receiver};

/// Bits of the differences: enough for gradients of 450 digits.
const BITS: usize = 1536;
const NEAREST: RoundingMode = RoundingMode::ToEven;

/// A constant emitter seen from the origin.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Where the receiver faces, at any length.
    pub normal: DVec3,
    /// The emitter.
    pub emitter: Emitter,
}

impl Seen {
    /// The scene moved such that the receiver is at the origin, the emission made constant: `None` where rounding leaves no
    /// polygon.
    #[must_use]
    pub fn moved(receiver: &Receiver, emitter: &Emitter) -> Option<Self> {
        let vertices = emitter.polygon().vertices().iter().map(|v| *v - receiver.position()).collect();
        let emitter = Emitter::new(Polygon::new(vertices).ok()?, Emission::Constant(emitter.largest_emission())).ok()?;
        Some(Self { normal: receiver.direction(), emitter })
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
        let mut constants = Consts::new().unwrap();
        let mut parse = |text: &str| {
            let number = BigFloat::parse(text, Radix::Dec, BITS, NEAREST, &mut constants);
            assert!(!number.is_nan(), "{text}");
            number
        };
        let twice = BigFloat::from_f64(2.0 * step, 64);
        let columns = DVec3::AXES.map(|axis| {
            let [after, before] = [step, -step].map(|step| gradient(&self.receiver(axis * step)));
            [0, 1, 2].map(|i| parse(&after[i]).sub(&parse(&before[i]), BITS, NEAREST).div(&twice, BITS, NEAREST))
        });
        Matrix(columns)
    }
}

/// A matrix of many digits, by columns.
#[derive(Debug, Clone)]
pub struct Matrix([[BigFloat; 3]; 3]);

impl Matrix {
    /// Frobenius norm.
    #[must_use]
    pub fn norm(&self) -> f64 {
        self.distance(&DMat3::ZERO)
    }

    /// Frobenius norm of the difference from a matrix of doubles.
    #[must_use]
    pub fn distance(&self, other: &DMat3) -> f64 {
        let entries = self.0.iter().flatten().zip(other.to_cols_array());
        frobenius(entries.map(|(own, other)| to_f64(&own.sub(&BigFloat::from_f64(other, 64), BITS, NEAREST))).collect())
    }

    /// Frobenius norm of the difference from another.
    #[must_use]
    pub fn distance_to(&self, other: &Self) -> f64 {
        let entries = self.0.iter().flatten().zip(other.0.iter().flatten());
        frobenius(entries.map(|(own, other)| to_f64(&own.sub(other, BITS, NEAREST))).collect())
    }
}

/// Squares of entries far from 1 would leave the range of a double.
fn frobenius(entries: Vec<f64>) -> f64 {
    let largest = entries.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    let part = |e: f64| e / largest * (e / largest);
    if largest == 0.0 { 0.0 } else { largest * entries.into_iter().map(part).sum::<f64>().sqrt() }
}

fn to_f64(number: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = number.as_raw_parts() else { return f64::NAN };
    let size = libm::scalbn(words.last().copied().unwrap_or(0) as f64, exponent - 64);
    if sign == Sign::Neg { -size } else { size }
}
