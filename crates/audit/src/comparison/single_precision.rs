//! How real-time renderers compute it: Lambert's sum over the edges in single precision, the angle of an edge by a rational fit.
//!
//! `B = rho B_e sum n1.(u_i x u_(i+1)) f(u_i.u_(i+1))` over the unit vectors to the vertices, with `f(c) ~ acos c / (2 pi
//! sqrt(1 - c^2))`: a quotient of quadratic polynomials in `|c|`, reflected for `c < 0`, whose coefficients are those of
//! S. Hill and E. Heitz, "Real-Time Area Lighting: a Journey from Research to Production", SIGGRAPH 2016 course. The emitter is
//! clipped at the horizon. It has five digits at its best, no gradient and no bound; here to be compared with.

use radgrad_core::Emission;
use radgrad_scene::case::Problem;

/// The vectors of a shader.
type Single = [f32; 3];

/// Radiosity by the fit; `None` for an emission that is not constant, or behind occluders, for which it is not meant.
///
/// Not a number where single precision leaves its range: that is an answer too.
#[must_use]
pub(crate) fn radiosity(problem: &Problem) -> Option<f64> {
    let (receiver, polygon) = (&problem.receiver, problem.emitter.polygon());
    let Emission::Constant(emitted) = *problem.emitter.emission() else { return None };
    if !problem.occluders.is_empty() {
        return None;
    }
    let single = |v: radgrad_core::DVec3| v.as_vec3().to_array();
    let (x, n1) = (single(receiver.position()), single(receiver.normal()));
    let corners: Vec<Single> = polygon.vertices().iter().map(|&v| minus(single(v), x)).collect();
    if dot(single(polygon.normal()), corners[0]) >= 0.0 {
        return Some(0.0);
    }
    let above = above_horizon(&corners, n1);
    let units: Vec<Single> = above.iter().map(|&r| scaled(r, 1.0 / dot(r, r).sqrt())).collect();
    let next = units.iter().cycle().skip(1);
    let sum: f32 = units.iter().zip(next).map(|(&u, &v)| dot(n1, cross(u, v)) * angle_over_sine(dot(u, v))).sum();
    // Counter-clockwise seen from the lit side is clockwise seen from the receiver's: the sum is negative.
    Some(-receiver.reflectance() * emitted * f64::from(sum))
}

/// `acos c / (2 pi sqrt(1 - c^2))`, to 2e-6 where `c > -0.99`.
fn angle_over_sine(cosine: f32) -> f32 {
    let c = cosine.abs();
    let fit = (0.854_398_5 + (0.496_515_5 + 0.014_520_6 * c) * c) / (3.417_594 + (4.161_672_4 + c) * c);
    if cosine > 0.0 { fit } else { 0.5 / (1.0 - c * c).max(1e-7).sqrt() - fit }
}

/// The part of a polygon with `n.r > 0`.
fn above_horizon(corners: &[Single], n: Single) -> Vec<Single> {
    let mut clipped = Vec::with_capacity(corners.len() + 2);
    for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (a, b) = (dot(n, from), dot(n, to));
        if a > 0.0 {
            clipped.push(from);
        }
        if (a > 0.0) != (b > 0.0) {
            let t = a / (a - b);
            clipped.push([0, 1, 2].map(|i| from[i] + t * (to[i] - from[i])));
        }
    }
    clipped
}

fn minus(a: Single, b: Single) -> Single {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scaled(a: Single, factor: f32) -> Single {
    a.map(|c| c * factor)
}

fn dot(a: Single, b: Single) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Single, b: Single) -> Single {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use radgrad_core::evaluate;

    #[test]
    fn the_fit_has_five_digits_of_the_angle_over_its_sine() {
        for step in 0..=200u8 {
            let cosine = f32::from(step) / 100.0 - 1.0;
            let c = f64::from(cosine);
            if c > -0.99 {
                let right = if c < 1.0 { arc_cosine(c) / (1.0 - c * c).sqrt() } else { 1.0 } / std::f64::consts::TAU;
                let fit = f64::from(angle_over_sine(cosine));
                assert!((fit / right - 1.0).abs() < 2e-6, "{c}: {fit} {right}");
            }
        }
    }

    /// By the half angle, which keeps the digits near 1.
    fn arc_cosine(c: f64) -> f64 {
        2.0 * (1.0 - c).sqrt().atan2((1.0 + c).sqrt())
    }

    #[test]
    fn it_has_some_digits_where_it_is_easy_and_none_for_what_it_is_not_meant() {
        let (mut answered, mut not_meant) = (0, 0);
        for index in 0..60 {
            let problem = Family::Generic.case(1, index).problem().unwrap();
            let right = evaluate(&problem.receiver, &problem.emitter, &[]).unwrap().radiosity;
            match radiosity(&problem) {
                Some(fit) => {
                    assert!((fit / right - 1.0).abs() < 0.05, "generic:1:{index}: {fit} {right}");
                    answered += 1;
                }
                None => not_meant += 1,
            }
        }
        assert!(answered > 10 && not_meant > 10);
        let dark = Family::BackFacing.case(1, 0).problem().unwrap();
        assert!(radiosity(&dark).is_none_or(|b| b == 0.0));
    }
}
