//! Two other forms of the same integrals, partly along the contour of what is seen: HS95 Eqs. 6 and 9, and the visible boundary form.
//!
//! With `k = n1 x (grad B x n2)`, counter-clockwise contour, and the printed Eq. 9 corrected (sign of its left side; second integrand):
//! - Eq. 6: `(2pi/rho) B(x) = -oint B n1.(r x dy)/r^2 + int k.r/r^2 dA`
//! - Eq. 9: `-(2pi/rho) grad B(x) = oint B (n1 x dy)/r^2 + 2 oint B (n1.(r x dy)) r/r^4 + int k/r^2 dA - 2 int (k.r) r/r^4 dA`
//!
//! Both are Stokes' theorem on a fixed region, so every edge of the clipped polygon counts, the horizon's too, though the sum of
//! what the horizon's edges give to Eq. 9 must vanish. Far away Eq. 6 cancels: it loses `2 log10(distance / size)` digits.
//!
//! The visible boundary form lets the contour move and integrates by parts; it vanishes on the horizon, where `s = n1.r = 0`, and
//! it is the one that keeps the digits of the gradient near contact:
//! `grad B(x) = (rho/pi) { int (h grad B + (r.grad B) n2) s/r^4 dA - oint B s (r x dy)/r^4 }`.

use crate::integrand::Integrand;
use crate::piece::{Four, Piece};
use crate::region::{Edge, Vertex};

impl Integrand<'_> {
    /// Eqs. 6 and 9, times `pi/rho`.
    pub(crate) fn contour(&self, piece: &Piece, at: &Vertex) -> Four {
        let (r, inverse) = self.ray(at);
        let half = match piece {
            Piece::Edge(edge) => {
                let weight = 0.5 * self.emission(at) * inverse;
                let moment = dot(self.normal, self.moment(edge));
                let turned = cross(self.normal, [edge.along[0], edge.along[1], 0.0]);
                let pull = 2.0 * moment * inverse;
                [moment, turned[0] + pull * r[0], turned[1] + pull * r[1], turned[2] + pull * r[2]].map(|c| -weight * c)
            }
            Piece::Triangle(_) => {
                let [gu, gv] = self.emission_gradient(at);
                let k = cross(self.normal, [gv, -gu, 0.0]);
                let along = dot(k, r);
                let pull = 2.0 * along * inverse;
                let weight = 0.5 * inverse;
                [along, pull * r[0] - k[0], pull * r[1] - k[1], pull * r[2] - k[2]].map(|c| weight * c)
            }
        };
        half
    }

    /// Eq. 1 and the visible boundary form of its gradient, times `pi/rho`.
    pub(crate) fn boundary(&self, piece: &Piece, at: &Vertex) -> Four {
        match piece {
            Piece::Triangle(_) => self.boundary_surface(at),
            Piece::Edge(edge) => {
                let (_, inverse) = self.ray(at);
                let moment = self.moment(edge);
                let weight = -self.emission(at) * at.s * inverse * inverse;
                [0.0, weight * moment[0], weight * moment[1], weight * moment[2]]
            }
        }
    }

    /// The surface part of that.
    pub(crate) fn boundary_surface(&self, at: &Vertex) -> Four {
        let (r, inverse) = self.ray(at);
        let weight = at.s * inverse * inverse;
        let [gu, gv] = self.emission_gradient(at);
        let h = self.height;
        [weight * h * self.emission(at), weight * h * gu, weight * h * gv, weight * (gu * r[0] + gv * r[1])]
    }

    /// `r x dy/dt`, the same all along the edge.
    fn moment(&self, edge: &Edge) -> [f64; 3] {
        [self.height * edge.along[1], -self.height * edge.along[0], edge.moment]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
