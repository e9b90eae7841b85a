//! The bare Lambert sum of a constant triangle, `B = -(rho B2 / 2 pi) sum gamma_i n1.(r_i x r_{i+1}) / |r_i x r_{i+1}|` (HS95 Eq.
//! 8) with `gamma_i` by std's `atan2`: no bound, no care near an edge or far away. In doubles it is the baseline for the time of
//! core's closed form; in dual numbers (crate `num-dual`) it gives the gradient by forward differentiation.

use nalgebra::{SVector, Vector3};
use num_dual::gradient;
use radgrad_core::{DVec3, Emission};

use super::regime::Case;
use super::visible::{Scalar, above, constant, relative_to};

/// Radiosity of a constant triangle without regard to the horizon: the sum and nothing else.
pub(crate) fn radiosity(case: &Case) -> f64 {
    let receiver = &case.receiver;
    let corners = relative_to(case.emitter.polygon().vertices(), Vector3::from(receiver.position().to_array()));
    factor(case) * sum(&corners, receiver.normal())
}

/// Radiosity and gradient of a constant triangle without regard to the horizon, one edge after the other: the sums of HS95 Eqs. 10, 11
/// and A.1, `grad B = -(rho B2/pi) sum w (n1.r I2 + n1.e J2)`, `w = r x e`, and nothing else.
pub(crate) fn bare_radiosity_and_gradient(case: &Case) -> (f64, DVec3) {
    let (x, n1, vertices) = (case.receiver.position(), case.receiver.normal(), case.emitter.polygon().vertices());
    let (mut value, mut slope) = (0.0, DVec3::ZERO);
    for (i, vertex) in vertices.iter().enumerate() {
        let (r, r_next) = (*vertex - x, vertices[if i + 1 == vertices.len() { 0 } else { i + 1 }] - x);
        let e = r_next - r;
        let w = r.cross(e);
        let square = w.length_squared();
        let length = square.sqrt();
        let gamma = length.atan2(r.dot(r_next));
        let (start, end, side) = (r.length_squared(), r_next.length_squared(), e.length_squared());
        let i2 = 0.5 / square * (e.dot(r_next) / end - e.dot(r) / start + side * gamma / length);
        let j2 = 0.5 / side * (1.0 / start - 1.0 / end) - r.dot(e) / side * i2;
        value += gamma * n1.dot(w) / length;
        slope += w * (2.0 * (n1.dot(r) * i2 + n1.dot(e) * j2));
    }
    (factor(case) * value, slope * factor(case))
}

/// Radiosity and gradient of a constant triangle, cut by the horizon, in dual numbers.
pub(crate) fn radiosity_and_gradient(case: &Case) -> (f64, DVec3) {
    let receiver = &case.receiver;
    let position = SVector::<f64, 3>::from(receiver.position().to_array());
    let of_position = |x| {
        let part = above(relative_to(case.emitter.polygon().vertices(), x), receiver.normal());
        sum(part.as_slice(), receiver.normal())
    };
    let (value, slope) = gradient(of_position, &position);
    (factor(case) * value, DVec3::new(slope.x, slope.y, slope.z) * factor(case))
}

/// `sum gamma_i n1.N_i` over a polygon's edges.
#[inline]
fn sum<D: Scalar>(corners: &[Vector3<D>], n1: DVec3) -> D {
    let n1 = constant(n1);
    let mut total = D::from(0.0);
    for (i, from) in corners.iter().enumerate() {
        let to = &corners[if i + 1 == corners.len() { 0 } else { i + 1 }];
        let normal = from.cross(to);
        let length = normal.dot(&normal).sqrt();
        total += length.atan2(from.dot(to)) * normal.dot(&n1) / length;
    }
    total
}

fn factor(case: &Case) -> f64 {
    let emission = match case.emitter.emission() {
        Emission::Constant(emission) => *emission,
        _ => f64::NAN,
    };
    -case.receiver.reflectance() * emission / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::regime::{Kind, Regime};

    #[test]
    fn dual_numbers_give_the_closed_forms_gradient_with_and_without_a_horizon() {
        for regime in [Regime::Easy, Regime::Clipped] {
            for case in regime.cases(Kind::Constant).unwrap() {
                let (value, slope) = radgrad_core::radiosity_and_gradient(&case.receiver, &case.emitter).unwrap();
                let (found, found_slope) = radiosity_and_gradient(&case);
                assert!((found / value - 1.0).abs() < 1e-12, "{found} {value}");
                assert!((found_slope - slope).length() < 1e-11 * slope.length(), "{found_slope} {slope}");
                if regime == Regime::Easy {
                    assert!((radiosity(&case) / found - 1.0).abs() < 1e-14);
                    let (bare, bare_slope) = bare_radiosity_and_gradient(&case);
                    assert!((bare / value - 1.0).abs() < 1e-12 && (bare_slope - slope).length() < 1e-11 * slope.length());
                }
            }
        }
    }
}
