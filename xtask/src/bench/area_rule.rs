//! A product Gauss rule over the emitter's area: Eq. 1 (HS95) and its kernel differentiated with respect to x, `n x n` points on
//! each triangle of the part above the horizon.
//!
//! The square is mapped to the triangle a, b, c by `a + s (b - a) + s t (c - b)` with Jacobian `2 A s` (conical product: Stroud
//! 1971; Duffy 1982). With `r = y - x`, `h = -n2.r`: `grad_x (n1.r) h / r^4 = ((n1.r) n2 - h n1 + 4 (n1.r) h r / r^2) / r^4`; the
//! moving horizon adds nothing, since `n1.r = 0` there.

use nalgebra::Vector3;
use radgrad_core::DVec3;

use super::output::Output;
use super::regime::Case;
use super::visible::{above, constant, relative_to};

/// Radiosity and gradient with the given one-dimensional rule in both directions.
pub(crate) fn evaluate(case: &Case, rule: &[(f64, f64)]) -> Output {
    let (receiver, polygon) = (&case.receiver, case.emitter.polygon());
    let x = Vector3::from(receiver.position().to_array());
    let whole = relative_to(polygon.vertices(), x);
    let part = above(whole, receiver.normal());
    let (n1, n2) = (constant::<f64>(receiver.normal()), constant::<f64>(polygon.normal()));
    let height = -n2.dot(&whole[0]);
    let (base, slope) = (case.emitter.emission_at(polygon.vertices()[0]), constant::<f64>(case.emitter.emission_gradient()));
    let (mut value, mut gradient, mut evaluations) = (0.0, Vector3::zeros(), 0);
    let corners = part.as_slice();
    for pair in corners.windows(2).skip(1) {
        let (a, along, across) = (corners[0], pair[0] - corners[0], pair[1] - pair[0]);
        let twice_area = along.cross(&across).norm();
        for (s, weight_s) in rule {
            for (t, weight_t) in rule {
                let r = a + (along + across * *t) * *s;
                let (cosine, squared) = (n1.dot(&r), r.norm_squared());
                let emission = base + slope.dot(&(r - whole[0]));
                let weight = twice_area * s * weight_s * weight_t * emission / (squared * squared);
                value += weight * cosine * height;
                gradient += (n2 * cosine - n1 * height + r * (4.0 * cosine * height / squared)) * weight;
            }
        }
        evaluations += rule.len() * rule.len();
    }
    let factor = receiver.reflectance() / std::f64::consts::PI;
    Output::new((factor * value, DVec3::from_array(gradient.into()) * factor), evaluations)
}
