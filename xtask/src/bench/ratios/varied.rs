//! Sixty-four triangles of different shape, place and tilt, each over a receiver of its own that sees it whole.
//!
//! Varied by additive recurrences, `i phi mod 1` with irrational `phi`: fixed, and without a pattern that a branch predictor or a
//! compiler could learn.

use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver};

use crate::bench::regime::{Case, Kind};

/// Number of cases.
pub(crate) const COUNT: u32 = 64;

/// The cases, with constant or linear emission.
pub(crate) fn cases(kind: Kind) -> Result<Vec<Case>, Error> {
    (0..COUNT).map(|i| case(i, kind)).collect()
}

/// Entry `index` of a recurrence, one for each dimension; its step is a multiple of the inverse of the real root of x^3 = x + 1.
pub(crate) fn between_0_and_1(index: u32, dimension: u32) -> f64 {
    let step = 0.754_877_666_246_692_8 * f64::from(2 * dimension + 1);
    ((f64::from(index) + 0.5) * step).fract()
}

fn case(index: u32, kind: Kind) -> Result<Case, Error> {
    let varied = |dimension: u32, low: f64, high: f64| low + (high - low) * between_0_and_1(index, dimension);
    let corner = |k: u32| {
        // Clockwise seen from above: lit downward.
        let angle = -std::f64::consts::TAU * (f64::from(k) + varied(k, -0.15, 0.15)) / 3.0;
        let radius = varied(3 + k, 0.3, 0.9);
        DVec3::new(radius * libm::cos(angle), radius * libm::sin(angle), 0.0)
    };
    let tilt = DVec3::new(varied(6, -0.3, 0.3), varied(7, -0.3, 0.3), 0.0);
    let height = varied(8, 1.0, 2.0);
    let corners: Vec<DVec3> = (0..3).map(|k| corner(k) + DVec3::Z * (height + tilt.dot(corner(k)))).collect();
    let emission = match kind {
        Kind::Constant => Emission::Constant(varied(9, 0.5, 4.0)),
        Kind::Linear => Emission::at_vertices((0..3).map(|k| varied(9 + k, 0.5, 4.0)).collect()),
    };
    let position = DVec3::new(varied(12, -0.5, 0.5), varied(13, -0.5, 0.5), 0.0);
    let normal = DVec3::new(varied(14, -0.3, 0.3), varied(15, -0.3, 0.3), 1.0);
    let receiver = Receiver::new(position, normal, varied(16, 0.2, 1.0))?;
    Ok(Case { receiver, emitter: Emitter::new(Polygon::new(corners)?, emission)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_receiver_is_lit_and_sees_its_triangle_whole() {
        for case in cases(Kind::Linear).unwrap() {
            let (x, n1) = (case.receiver.position(), case.receiver.normal());
            assert!(case.emitter.polygon().normal().dot(x - case.emitter.polygon().vertices()[0]) > 0.3);
            assert!(case.emitter.polygon().vertices().iter().all(|v| n1.dot(*v - x) > 0.1));
        }
    }

    #[test]
    fn no_two_cases_are_alike() {
        let cases = cases(Kind::Constant).unwrap();
        for (i, a) in cases.iter().enumerate() {
            assert!(cases[..i].iter().all(|b| a.receiver.position().distance(b.receiver.position()) > 1e-3));
        }
    }
}
