//! The emission as the rule sees it: its value at the nodes, its size, and its growth in the ellipses of the bound.
//!
//! A polynomial of degree n bounded by m on a segment is bounded by `m R^n` in the ellipse `E_R` around it (Bernstein's
//! inequality), an affine one by m times the ellipse's semi-axis. A polynomial is evaluated around the polygon's middle in its
//! unit, so that distance costs no digits.

use crate::number::ROUNDOFF;
use crate::polynomial::{Bivariate, InPlane};
use crate::{Emission, Emitter};

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
        let kind = if let Emission::Constant(_) = emitter.emission() { Kind::Constant } else { Kind::Linear };
        let largest = emitter.largest_emission() * emitter.power() * (1.0 + 8.0 * ROUNDOFF);
        let rounding = 24.0 * ROUNDOFF + emitter.vertex_error() / largest;
        Self { emitter, kind, largest, rounding, input_error: emitter.affine().residual / largest }
    }

    /// Bound on `|B|` over [`Self::largest`] in the ellipse with the semi-axes A = `stretch` and tau, `A + tau = ratio`.
    pub(super) fn growth(&self, stretch: f64, ratio: f64) -> f64 {
        match self.kind {
            Kind::Constant => 1.0,
            Kind::Linear => stretch,
            Kind::Polynomial(plane) => (0..plane.degree()).fold(1.01, |growth, _| growth * ratio),
        }
    }

    /// On the triangle with these vertices of the polygon.
    pub(super) fn on_triangle(&self, corners: [usize; 3]) -> OnTriangle {
        match self.kind {
            Kind::Constant => OnTriangle::Affine([self.emitter.affine().value, 0.0, 0.0]),
            Kind::Linear => {
                let at = corners.map(|vertex| self.emitter.vertex_value(vertex));
                OnTriangle::Affine([at[0], at[1] - at[0], at[2] - at[1]])
            }
            Kind::Polynomial(plane) => {
                let vertices = self.emitter.polygon().vertices();
                let [p, q, r] = corners.map(|vertex| plane.at(vertices[vertex]));
                let from_to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
                OnTriangle::Polynomial(plane.rounded(self.emitter.power()), [p, from_to(p, q), from_to(q, r)])
            }
        }
    }
}
