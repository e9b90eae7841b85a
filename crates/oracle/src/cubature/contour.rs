//! Two other forms of the same integrals, partly along the contour of the visible part: HS95 Eqs. 6 and 9, and the visible boundary
//! form.
//!
//! With `k = n1 x (grad B x n2)`, counter-clockwise contour, and the printed Eq. 9 corrected (sign of its left side; second
//! integrand):
//! - Eq. 6: `(2pi/rho) B(x) = -oint B n1.(r x dy)/r^2 + int k.r/r^2 dA`
//! - Eq. 9: `-(2pi/rho) grad B(x) = oint B (n1 x dy)/r^2 + 2 oint B (n1.(r x dy)) r/r^4 + int k/r^2 dA - 2 int (k.r) r/r^4 dA`
//!
//! Both are Stokes' theorem on a fixed region, so every edge of the clipped polygon counts, the horizon's too. They cancel
//! where little is seen: `log10(distance / size)` digits far away, three times `log10(size / width)` for the value of a sliver
//! over the horizon.
//!
//! The visible boundary form lets the contour move and integrates by parts; it vanishes on the horizon, where `s = n1.r = 0`, and
//! it is the one that keeps the digits of the gradient near contact:
//! `grad B(x) = (rho/pi) { int (h grad B + (r.grad B) n2) s/r^4 dA - oint B s (r x dy)/r^4 }`.

use crate::cubature::integrand::Integrand;
use crate::cubature::piece::{Four, Piece};
use crate::region::FrameVector;
use crate::region::plane::{Edge, Vertex};

impl Integrand<'_> {
    /// Eqs. 6 and 9, times `pi/rho`.
    pub(crate) fn contour(&self, piece: &Piece, at: &Vertex) -> Four {
        let (r, inverse) = self.ray(at);
        match piece {
            Piece::Edge(edge) => {
                let weight = 0.5 * self.emission(at) * inverse;
                let moment = self.normal.dot(&self.moment(edge));
                let gradient = self.normal.cross(&in_plane(edge.along)) + 2.0 * moment * inverse * r;
                [moment, gradient.x, gradient.y, gradient.z].map(|c| -weight * c)
            }
            Piece::Triangle(_) => {
                let [gu, gv] = self.emission_gradient(at);
                let k = self.normal.cross(&in_plane([gv, -gu]));
                let along = k.dot(&r);
                let gradient = 2.0 * along * inverse * r - k;
                [along, gradient.x, gradient.y, gradient.z].map(|c| 0.5 * inverse * c)
            }
        }
    }

    /// Eq. 1 and the visible boundary form of its gradient, times `pi/rho`.
    pub(crate) fn boundary(&self, piece: &Piece, at: &Vertex) -> Four {
        match piece {
            Piece::Triangle(_) => self.boundary_surface(at),
            Piece::Edge(edge) => {
                let (_, inverse) = self.ray(at);
                let moment = self.moment(edge);
                let weight = -self.emission(at) * at.s * inverse * inverse;
                [0.0, weight * moment.x, weight * moment.y, weight * moment.z]
            }
        }
    }

    /// The surface part of that.
    pub(crate) fn boundary_surface(&self, at: &Vertex) -> Four {
        let (r, inverse) = self.ray(at);
        let weight = at.s * inverse * inverse;
        let [gu, gv] = self.emission_gradient(at);
        let h = self.height;
        [weight * h * self.emission(at), weight * h * gu, weight * h * gv, weight * (gu * r.x + gv * r.y)]
    }

    /// `r x dy/dt`, the same all along the edge.
    pub(crate) fn moment(&self, edge: &Edge) -> FrameVector {
        FrameVector::new(self.height * edge.along[1], -self.height * edge.along[0], edge.moment)
    }
}

fn in_plane([u, v]: [f64; 2]) -> FrameVector {
    FrameVector::new(u, v, 0.0)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use radgrad_core::{Emission, Emitter, Polygon, Receiver};

    use super::*;
    use crate::cubature::adaptive::{self, Goal};
    use crate::region::Region;
    use crate::source_function::SourceFunction;

    /// Eqs. 6 and 9 with changes to the integrand: relative errors of value and gradient against Eq. 1.
    fn errors_with(emission: Emission, change: impl Fn(&Integrand<'_>, &Piece, &Vertex, Four) -> Four) -> [f64; 2] {
        let corners = [[0.0, 0.0, 2.0], [0.5, 1.0, 2.5], [1.0, 0.25, 2.25]].map(DVec3::from);
        let emitter = Emitter::new(Polygon::new(corners.to_vec()).unwrap(), emission).unwrap();
        let receiver = Receiver::new(DVec3::ZERO, DVec3::new(0.25, 0.5, 1.0), 1.0).unwrap();
        let source = SourceFunction::Emitter(&emitter);
        let region = Region::new(&receiver, emitter.polygon(), &source).unwrap();
        let integrand = Integrand::new(&region, source);
        let triangles = || region.triangles.iter().copied().map(Piece::Triangle);
        let edges = || region.outline.iter().copied().map(Piece::Edge);
        let goal = Goal { tolerance: 1e-10, budget: 1_000_000, longest: f64::INFINITY, is_wary: false };
        let integrate = |pieces: Vec<Piece>, f: &dyn Fn(&Piece, &Vertex) -> Four| {
            adaptive::integrate(pieces, region.height, &|piece: &Piece, at: &Vertex| f(piece, at), goal).unwrap().integral
        };
        let right = integrate(triangles().collect(), &|_, at| integrand.surface(at));
        let pieces = edges().chain(triangles()).collect();
        let form = integrate(pieces, &|piece, at| change(&integrand, piece, at, integrand.contour(piece, at)));
        let gradient = |[_, u, v, n]: Four| FrameVector::new(u, v, n);
        let difference = gradient(form) - gradient(right);
        [(form[0] / right[0] - 1.0).abs(), difference.norm() / gradient(right).norm()]
    }

    fn constant() -> Emission {
        Emission::Constant(1.0)
    }

    fn linear() -> Emission {
        Emission::at_vertices(vec![1.0, 2.0, 1.5])
    }

    #[test]
    fn corrected_eqs_6_and_9_hold() {
        for emission in [constant(), linear()] {
            let errors = errors_with(emission, |_, _, _, f| f);
            assert!(errors[0] < 1e-9 && errors[1] < 1e-9, "{errors:?}");
        }
    }

    #[test]
    fn printed_sign_of_eq_9_fails() {
        for emission in [constant(), linear()] {
            let errors = errors_with(emission, |_, _, _, [value, gu, gv, gn]| [value, -gu, -gv, -gn]);
            assert!(errors[0] < 1e-9 && (errors[1] - 2.0).abs() < 1e-9, "{errors:?}");
        }
    }

    /// `(n1.r)(r x dy)/r^4` on edges, as printed, with the first integrand or without.
    fn printed_second_integrand(integrand: &Integrand<'_>, piece: &Piece, at: &Vertex, f: Four, first: bool) -> Four {
        let Piece::Edge(edge) = piece else { return f };
        let (_, inverse) = integrand.ray(at);
        let weight = 0.5 * integrand.emission(at) * inverse;
        let moment = integrand.moment(edge);
        let turned = integrand.normal.cross(&in_plane(edge.along));
        let first_term = if first { 1.0 } else { 0.0 };
        let component = |i: usize| -weight * (first_term * turned[i] + 2.0 * at.s * inverse * moment[i]);
        [f[0], component(0), component(1), component(2)]
    }

    #[test]
    fn printed_second_integrand_of_eq_9_fails() {
        for emission in [constant(), linear()] {
            let printed = |i: &Integrand<'_>, p: &Piece, at: &Vertex, f| printed_second_integrand(i, p, at, f, true);
            let errors = errors_with(emission, printed);
            assert!(errors[1] > 1e-2, "{errors:?}");
        }
    }

    #[test]
    fn printed_second_integrand_holds_for_constant_emission_without_the_first() {
        let alone = |i: &Integrand<'_>, p: &Piece, at: &Vertex, f| printed_second_integrand(i, p, at, f, false);
        assert!(errors_with(constant(), alone)[1] < 1e-9);
    }
}
