//! Random problems that proptest can shrink: a star-shaped emitter about 1 across, a receiver 0.3 to 2.5 in front of its plane.
//!
//! Cosines come from `libm`, so that the cases are the same on every machine.

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use radgrad_core::{Emission, Emitter, Polygon, Receiver};

/// A receiver and an emitter by their numbers, so that both can be changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Receiver point x.
    pub position: DVec3,
    /// Receiver normal, of any length.
    pub normal: DVec3,
    /// Reflectance rho.
    pub reflectance: f64,
    /// Vertices of the emitter.
    pub vertices: Vec<DVec3>,
    /// Emission at vertex 0.
    pub value: f64,
    /// Gradient of the emission over the emitter's plane.
    pub gradient: DVec3,
}

impl Problem {
    /// The receiver.
    ///
    /// # Panics
    /// If the numbers make none, as [`Self::emitter`].
    #[must_use]
    pub fn receiver(&self) -> Receiver {
        Receiver::new(self.position, self.normal, self.reflectance).unwrap()
    }

    /// The emitter: constant where the gradient is 0.
    ///
    /// # Panics
    /// If the numbers make none.
    #[must_use]
    pub fn emitter(&self) -> Emitter {
        let emission = if self.gradient == DVec3::ZERO {
            Emission::Constant(self.value)
        } else {
            Emission::gradient(self.value, self.gradient)
        };
        Emitter::new(Polygon::new(self.vertices.clone()).unwrap(), emission).unwrap()
    }

    /// The same problem turned about the origin, then shifted.
    #[must_use]
    pub fn moved(&self, rotation: DMat3, shift: DVec3) -> Self {
        Self {
            position: rotation * self.position + shift,
            normal: rotation * self.normal,
            vertices: self.vertices.iter().map(|v| rotation * *v + shift).collect(),
            gradient: rotation * self.gradient,
            ..*self
        }
    }

    /// The same receiver before an emitter with some of the vertices, the first among them.
    #[must_use]
    pub fn with_vertices(&self, vertices: Vec<DVec3>) -> Self {
        assert_eq!(vertices[0], self.vertices[0], "the emission is given at vertex 0");
        Self { vertices, ..*self }
    }

    /// Height of the receiver over the emitter's plane.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.emitter().polygon().normal().dot(self.position - self.vertices[0])
    }

    /// Smallest distance of a vertex from the receiver's horizon.
    #[must_use]
    pub fn horizon_distance(&self) -> f64 {
        let n1 = self.receiver().normal();
        self.vertices.iter().map(|v| n1.dot(*v - self.position).abs()).fold(f64::INFINITY, f64::min)
    }

    /// How the answer answers to small changes of the input.
    #[must_use]
    pub fn condition(&self) -> Condition {
        let (emitter, d) = (self.emitter(), self.height());
        let area = emitter.polygon().area();
        let next = self.vertices.iter().cycle().skip(1);
        let perimeter: f64 = self.vertices.iter().zip(next).map(|(a, b)| a.distance(*b)).sum();
        let (emission, slope) = (emitter.largest_emission(), emitter.emission_gradient().length());
        let factor = self.reflectance / std::f64::consts::PI;
        Condition {
            radiosity: factor * (emission * (6.0 * area / d + perimeter + 2.0 * area) + slope * area) / (d * d),
            gradient: factor * (emission * (50.0 * area / d + 18.0 * perimeter + 12.0 * area) + 6.0 * slope * area) / (d * d * d),
        }
    }
}

/// Largest change of the answer over the displacement of the points that causes it (and of the normals, in radians).
///
/// With d a lower bound of |r|, the kernel `K = (n1.r)(n2.r)/r^4` of Eq. 1 is at most `d^-2`, `|grad K|` at most `6 d^-3` and the
/// derivative of that at most `50 d^-4`; a displaced contour adds its length times the integrand, a displaced horizon at most
/// twice that of the gradient's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Condition of the radiosity.
    pub radiosity: f64,
    /// Condition of the gradient, by its Euclidean norm.
    pub gradient: f64,
}

prop_compose! {
    /// A problem whose emitter has its vertices at the given distances from its centre, 1 and 1 for a convex one.
    pub fn problem(nearest: f64, farthest: f64)(
        corners in prop::collection::vec((0.0..0.4, nearest..=farthest), 3..=7),
        position in (-1.5..1.5, -1.5..1.5, 0.3..2.5),
        tilt in (-1.5..1.5, -1.5..1.5),
        reflectance in 0.05..1.0,
        value in 1.2..3.0,
        slope in prop_oneof![Just((0.0, 0.0)), (-0.3..0.3, -0.3..0.3)],
        turn in rotation(),
        shift in shift(),
    ) -> Problem {
        let count = corners.len() as f64;
        let vertices = corners.iter().enumerate().map(|(i, (jitter, radius))| {
            let angle = std::f64::consts::TAU * (i as f64 + jitter) / count;
            DVec3::new(radius * libm::cos(angle), radius * libm::sin(angle), 0.0)
        });
        let level = Problem {
            position: DVec3::from(position),
            normal: DVec3::new(tilt.0, tilt.1, -1.0),
            reflectance,
            vertices: vertices.collect(),
            value,
            gradient: DVec3::new(slope.0, slope.1, 0.0),
        };
        level.moved(turn, shift)
    }
}

/// Any rotation.
pub fn rotation() -> impl Strategy<Value = DMat3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0)
        .prop_map(|(x, y, z, w)| DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()))
}

/// A shift of about the size of the emitter.
pub fn shift() -> impl Strategy<Value = DVec3> {
    (-2.0..2.0, -2.0..2.0, -2.0..2.0).prop_map(DVec3::from)
}
