//! The emission as the rule sees it: its value at the nodes, its size, and its growth in the ellipses of the bound.
//!
//! A polynomial of degree n bounded by m on a segment is bounded by `m R^n` in the ellipse `E_R` around it (Bernstein's
//! inequality), an affine one by m times the ellipse's semi-axis. A polynomial is evaluated around the polygon's middle in its
//! unit, so that distance costs no digits.

use glam::DVec3;

use crate::Emitter;
use crate::emission::Affine;
use crate::number::ROUNDOFF;
use crate::polynomial::{Bivariate, InPlane};

/// An emission with the bounds that the rule needs of it, normalised.
#[derive(Debug)]
pub(super) struct Source<'a> {
    emitter: &'a Emitter,
    kind: Kind<'a>,
    /// Bound on `|B|` over the emitter and the triangles of its fan.
    pub(super) largest: f64,
    /// Relative to that: rounding of the values at nodes.
    pub(super) rounding: f64,
    /// Relative to that: what the input leaves open, vertices off the plane or values off the affine function.
    pub(super) input_error: f64,
}

#[derive(Debug)]
enum Kind<'a> {
    Constant,
    Linear,
    Polynomial(&'a InPlane),
}

/// The emission on a triangle `P + a (e1 + b e)`.
#[derive(Debug, Clone)]
pub(super) enum OnTriangle {
    /// At P, its increase along e1, and along e.
    Affine([f64; 3]),
    /// The polynomial, and P, e1 and e in its coordinates.
    Polynomial(Bivariate<f64>, [[f64; 2]; 3]),
}

impl<'a> Source<'a> {
    pub(super) fn new(emitter: &'a Emitter) -> Self {
        if let Some(plane) = emitter.polynomial() {
            // Coordinates of nodes err by 40 roundings of the largest, each factor of a monomial by as much; Horner's rule adds
            // four a degree.
            let rounding = (2 + 44 * plane.degree()) as f64 * ROUNDOFF + plane.uncertainty() / plane.largest();
            let input_error = 2.0 * plane.steepest() * emitter.polygon().planarity_defect() / plane.largest();
            let largest = plane.largest() * emitter.power();
            return Self { emitter, kind: Kind::Polynomial(plane), largest, rounding, input_error };
        }
        let Affine { value, residual, .. } = emitter.affine();
        let gradient = emitter.emission_gradient() * emitter.power();
        let vertices = emitter.polygon().vertices();
        let at = |v: &DVec3| value + gradient.dot(*v - vertices[0]);
        let largest = vertices.iter().map(|v| at(v).abs()).fold(0.0, f64::max) * (1.0 + 32.0 * ROUNDOFF);
        let kind = if gradient == DVec3::ZERO { Kind::Constant } else { Kind::Linear };
        Self { emitter, kind, largest, rounding: 24.0 * ROUNDOFF, input_error: residual / largest }
    }

    /// Bound on `|B|` over [`Self::largest`] in the ellipse with the semi-axes A = `stretch` and tau, `A + tau = ratio`.
    pub(super) fn growth(&self, stretch: f64, ratio: f64) -> f64 {
        match self.kind {
            Kind::Constant => 1.0,
            Kind::Linear => stretch,
            Kind::Polynomial(plane) => (0..plane.degree()).fold(1.01, |growth, _| growth * ratio),
        }
    }

    pub(super) fn on_triangle(&self, corners: [DVec3; 3]) -> OnTriangle {
        if let Kind::Polynomial(plane) = self.kind {
            let [p, q, r] = corners.map(|corner| plane.at(corner));
            let from_to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
            return OnTriangle::Polynomial(plane.rounded(self.emitter.power()), [p, from_to(p, q), from_to(q, r)]);
        }
        let Affine { value, .. } = self.emitter.affine();
        if let Kind::Constant = self.kind {
            return OnTriangle::Affine([value, 0.0, 0.0]);
        }
        let gradient = self.emitter.emission_gradient() * self.emitter.power();
        let origin = self.emitter.polygon().vertices()[0];
        let at = corners.map(|v| value + gradient.dot(v - origin));
        OnTriangle::Affine([at[0], at[1] - at[0], at[2] - at[1]])
    }
}
