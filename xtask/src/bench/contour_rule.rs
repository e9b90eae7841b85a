//! A Gauss rule along the contour of the emitter: every term of value and gradient as an integral over its edges.
//!
//! With `r = r_i + t e`, `w = r_i x e`, `B(y) = beta + g.r`, `h = -n2.r`, sums over the edges of the part above the horizon:
//! - irradiance vector of the solid angle `Phi = -1/2 sum w int dt/r^2` (Lambert's sum, HS95 Eq. 6);
//! - for a linear emission `Q = int (g.r)(n1.r)/r^4 dA` over the plane: by the divergence theorem `1/2 (X1 g.n1 - sum n1.m
//!   int (g.r)/r^2 dt) - (n1.n2)(g.Phi)` with `m = e x n2` outward and `X1 = int dA/r^2 = 1/2 sum r.m int ln(1 + p^2/h^2)/p^2 dt`,
//!   `p` the distance from the receiver's foot in the plane;
//! - value `(rho/pi) (beta Phi.n1 + h Q)`, gradient `(rho/pi) (g (Phi.n1) + n2 Q + sum' int B (n1.r)(e x r)/r^4 dt)`, the last
//!   sum without edges on the horizon (Green's theorem on HS95 Eq. 9).

use nalgebra::Vector3;
use radgrad_core::{DVec3, Emission};

use super::output::Output;
use super::regime::Case;
use super::visible::{above, constant, relative_to};

/// Radiosity and gradient with the given rule on each edge.
pub(crate) fn evaluate(case: &Case, rule: &[(f64, f64)]) -> Output {
    let (receiver, polygon) = (&case.receiver, case.emitter.polygon());
    let whole = relative_to(polygon.vertices(), Vector3::from(receiver.position().to_array()));
    let part = above(whole, receiver.normal());
    let (n1, n2) = (constant::<f64>(receiver.normal()), constant::<f64>(polygon.normal()));
    let height = -n2.dot(&whole[0]);
    let is_linear = !matches!(case.emitter.emission(), Emission::Constant(_));
    let (base, slope) = (case.emitter.emission_at(polygon.vertices()[0]), constant::<f64>(case.emitter.emission_gradient()));

    let (mut phi, mut along_edges) = (Vector3::zeros(), Vector3::zeros());
    let (mut x1, mut moment, mut evaluations) = (0.0, 0.0, 0);
    for (from, to, on_horizon) in part.edges() {
        let e = to - from;
        let (w, outward) = (from.cross(&e), e.cross(&n2));
        let (mut inverse_square, mut of_edge) = (0.0, 0.0);
        let (mut of_slope, mut of_plane) = (0.0, 0.0);
        for (t, weight) in rule {
            let r = from + e * *t;
            let inverse = 1.0 / r.norm_squared();
            inverse_square += weight * inverse;
            if is_linear {
                of_slope += weight * slope.dot(&r) * inverse;
                let in_plane = (r + n2 * height).norm_squared();
                of_plane += weight * (in_plane / (height * height)).ln_1p() / in_plane;
            }
            if !on_horizon {
                of_edge += weight * (base + slope.dot(&(r - whole[0]))) * n1.dot(&r) * inverse * inverse;
            }
        }
        phi -= w * (0.5 * inverse_square);
        along_edges -= w * of_edge;
        x1 += 0.5 * from.dot(&outward) * of_plane;
        moment += n1.dot(&outward) * of_slope;
        evaluations += rule.len();
    }
    let quotient = if is_linear { 0.5 * (x1 * slope.dot(&n1) - moment) - n1.dot(&n2) * slope.dot(&phi) } else { 0.0 };
    // g has no part along n2, but n1 has: X1 belongs to the part of n1 in the plane, and g.n1 is that.
    let value = (base - slope.dot(&whole[0])) * phi.dot(&n1) + height * quotient;
    let gradient = slope * phi.dot(&n1) + n2 * quotient + along_edges;
    let factor = receiver.reflectance() / std::f64::consts::PI;
    Output::new((factor * value, DVec3::from_array(gradient.into()) * factor), evaluations)
}
