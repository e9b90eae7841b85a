//! The emission as the rule sees it: its value at the nodes, its size, and its growth in the ellipses of the bound.
//!
//! A polynomial of degree n bounded by m on a segment is bounded by `m R^n` in the ellipse `E_R` around it (Bernstein's
//! inequality), an affine one by m times the ellipse's semi-axis. A polynomial is evaluated around the polygon's middle in its
//! unit, so that distance costs no digits.

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;

use crate::problem::emission::{Emission, Emitter};
use crate::problem::polygon::Polygon;
use crate::problem::polynomial::bivariate::Bivariate;
use crate::problem::polynomial::plane::InPlane;

/// An emission with the bounds that the rule needs of it, normalised.
#[derive(Debug)]
pub(super) struct Source<'a> {
    emitter: &'a Emitter,
    kind: Kind<'a>,
    /// Bound on `|B|` over the emitter and the triangles of its fan.
    pub(super) largest: f64,
    /// Relative to that: rounding of the values at nodes; the part of it that is not relative to the values themselves; and the
    /// error for each roundoff of a node.
    pub(super) rounding: f64,
    pub(super) crossing: f64,
    pub(super) per_node: f64,
    /// Relative to that: the uncertainty of the input, vertices off the plane or values off the affine function.
    pub(super) input_error: f64,
}

#[derive(Debug)]
enum Kind<'a> {
    Constant,
    Linear,
    Polynomial(&'a InPlane),
}

/// The emission at a corner: its value where it is affine, else the corner's coordinates in the plane.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lit {
    Value(f64),
    At([f64; 2]),
}

/// The emission on a triangle `P + a (e1 + b e)`.
#[derive(Debug, Clone)]
pub(super) enum OnTriangle {
    /// Values of an affine emission at the corners.
    Affine([f64; 3]),
    /// The polynomial, and P, e1 and e in its coordinates.
    Polynomial(Bivariate<f64>, [[f64; 2]; 3]),
}

impl Lit {
    /// The emission at a point a fraction of the way to `end`.
    pub(super) fn towards(&self, end: &Self, fraction: f64) -> Self {
        match (self, end) {
            (Self::At(p), Self::At(q)) => Self::At([0, 1].map(|i| p[i] + (q[i] - p[i]) * fraction)),
            _ => Self::Value(self.value() + (end.value() - self.value()) * fraction),
        }
    }

    /// Whether an affine emission is not negative here.
    pub(super) fn is_bright(&self) -> bool {
        matches!(self, Self::Value(value) if *value >= 0.0)
    }

    fn value(&self) -> f64 {
        if let Self::Value(value) = self { *value } else { 0.0 }
    }

    fn place(&self) -> [f64; 2] {
        if let Self::At(place) = self { *place } else { [0.0; 2] }
    }
}

impl<'a> Source<'a> {
    pub(super) fn new(emitter: &'a Emitter, is_clipped: bool) -> Self {
        if let Some(plane) = emitter.polynomial() {
            // Coordinates of nodes err by 40 roundings of the largest, or 60 beside a crossing of the horizon, each factor of a
            // monomial by as much; Horner's rule adds four a degree.
            let factor = if is_clipped { 64 } else { 44 };
            let rounding = (2 + factor * plane.degree()) as f64 * ROUNDOFF + plane.uncertainty() / plane.largest();
            let input_error = 2.0 * plane.steepest() * emitter.polygon().planarity_defect() / plane.largest();
            let largest = plane.largest() * emitter.power();
            return Self {
                emitter,
                kind: Kind::Polynomial(plane),
                largest,
                crossing: rounding,
                rounding,
                per_node: 0.0,
                input_error,
            };
        }
        let kind = if let Emission::Constant(_) = emitter.emission() { Kind::Constant } else { Kind::Linear };
        let largest = emitter.largest_emission() * emitter.power() * (1.0 + 8.0 * ROUNDOFF);
        let is_linear = matches!(kind, Kind::Linear);
        // Values at a crossing of the horizon err by 21 roundings, those between corners by 6 relative where no value is negative,
        // else of the largest; an affine function changes by the largest, or twice that, where a node moves by 1.
        let at_crossings = if is_linear && is_clipped { 21.0 * ROUNDOFF } else { 0.0 };
        let crossing = at_crossings + emitter.vertex_error() / largest;
        let rounding = crossing + 6.0 * ROUNDOFF;
        let per_node = if is_linear { ROUNDOFF } else { 0.0 };
        Self { emitter, kind, largest, crossing, rounding, per_node, input_error: emitter.affine().residual / largest }
    }

    /// Bound on `|B|` over [`Self::largest`] in the ellipse with the semi-axes A = `stretch` and tau, `A + tau = ratio`.
    pub(super) fn growth(&self, stretch: f64, ratio: f64) -> f64 {
        match self.kind {
            Kind::Constant => 1.0,
            Kind::Linear => stretch,
            Kind::Polynomial(plane) => (0..plane.degree()).fold(1.01, |growth, _| growth * ratio),
        }
    }

    pub(super) const fn polygon(&self) -> &'a Polygon {
        self.emitter.polygon()
    }

    pub(super) const fn degree(&self) -> usize {
        match self.kind {
            Kind::Constant => 0,
            Kind::Linear => 1,
            Kind::Polynomial(plane) => plane.degree(),
        }
    }

    /// The emission at vertex `vertex` of the polygon, which is at `place`.
    pub(super) fn at_vertex(&self, vertex: usize, place: DVec3) -> Lit {
        match self.kind {
            Kind::Constant => Lit::Value(self.emitter.affine().value),
            Kind::Linear => Lit::Value(self.emitter.vertex_value(vertex)),
            Kind::Polynomial(plane) => Lit::At(plane.coordinates(place)),
        }
    }

    /// On the triangle with these vertices, which are at `places`; and whether it is known to be nowhere negative.
    #[inline]
    pub(super) fn on_corners(&self, vertices: [usize; 3], places: [DVec3; 3]) -> (OnTriangle, bool) {
        if let Kind::Constant = self.kind {
            let value = self.emitter.affine().value;
            return (OnTriangle::Affine([value; 3]), value >= 0.0);
        }
        let lit = [0, 1, 2].map(|i| self.at_vertex(vertices[i], places[i]));
        (self.on_triangle([&lit[0], &lit[1], &lit[2]]), lit.iter().all(Lit::is_bright))
    }

    /// On the triangle with these corners.
    pub(super) fn on_triangle(&self, corners: [&Lit; 3]) -> OnTriangle {
        if let Kind::Polynomial(plane) = self.kind {
            let [p, q, r] = corners.map(Lit::place);
            let from_to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
            OnTriangle::Polynomial(plane.rounded(self.emitter.power()), [p, from_to(p, q), from_to(q, r)])
        } else {
            OnTriangle::Affine(corners.map(Lit::value))
        }
    }
}
