//! Clausen's function `Cl2(t) = -int_0^t ln|2 sin(s/2)| ds = Im Li2(e^{it})`, the one special function that a linear emitter needs.
//!
//! [`crate::linear`] brings the dilogarithms of `X1 = int dA/r^2` down to three values of `Cl2` per vertex (its module documentation has
//! the derivation). Series with Bernoulli numbers (Lewin, "Polylogarithms and Associated Functions", 1981, section 4.3):
//! `Cl2(t) = t [1 - ln t + sum |B_2k| t^2k / (2k (2k+1)!)]` near 0 and
//! `Cl2(pi - s) = s [ln 2 - sum |B_2k| (4^k - 1) s^2k / (2k (2k+1)!)]` near pi. They meet at 2 pi/3, where both lose a factor of nine a
//! term: fifteen terms leave a relative remainder below 4e-18. Relative accuracy is kept at the zeros 0 and pi.

use crate::real::ROUNDOFF;

/// Relative error of [`clausen`], in units of [`ROUNDOFF`]: at 2 pi/3 the bracket is a third of its largest term, so three roundings of
/// size one and one of the logarithm (2 ulp allowed) cost 3 (3 + 4) units at worst; measured 3.1 on the table of the tests.
pub(crate) const CLAUSEN_ERROR: f64 = 24.0 * ROUNDOFF;

/// `|B_2k| / (2k (2k+1)!)`, k = 1..15.
const NEAR_ZERO: [f64; 15] = [
    0.013888888888888888,
    6.944444444444444e-05,
    7.873519778281683e-07,
    1.1482216343327455e-08,
    1.8978869988971e-10,
    3.387301370953521e-12,
    6.372636443183181e-14,
    1.2462059912950672e-15,
    2.5105444608999545e-17,
    5.178258806090623e-19,
    1.0887357368300849e-20,
    2.325744114302087e-22,
    5.03519521314739e-24,
    1.1026499294381215e-25,
    2.4386585509007344e-27,
];

/// `|B_2k| (4^k - 1) / (2k (2k+1)!)`, k = 1..15.
const NEAR_PI: [f64; 15] = [
    0.041666666666666664,
    0.0010416666666666667,
    4.96031746031746e-05,
    2.927965167548501e-06,
    1.941538399871733e-07,
    1.3870999114054669e-08,
    1.0440290284867003e-09,
    8.167010963952224e-11,
    6.5812165661369675e-12,
    5.429792727596475e-13,
    4.5664875671936356e-14,
    3.901950904063069e-15,
    3.3790622573736396e-16,
    2.9599033551444004e-17,
    2.618489678118693e-18,
];

/// pi minus the double nearest to it.
const PI_LOW: f64 = 1.2246467991473532e-16;

/// `Cl2(t)` for `|t| <= 2 pi`; relative error at most [`CLAUSEN_ERROR`].
#[inline]
pub(crate) fn clausen(t: f64) -> f64 {
    use std::f64::consts::PI;
    let size = t.abs();
    let magnitude = if size <= 2.0 * PI / 3.0 {
        near_zero(size)
    } else if size <= 4.0 * PI / 3.0 {
        near_pi((PI - size) + PI_LOW)
    } else {
        -near_zero(((2.0 * PI - size) + 2.0 * PI_LOW).abs())
    };
    if t < 0.0 { -magnitude } else { magnitude }
}

#[inline]
fn near_zero(t: f64) -> f64 {
    if t == 0.0 {
        return 0.0;
    }
    let square = t * t;
    t * ((1.0 - libm::log(t)) + square * polynomial(&NEAR_ZERO, square))
}

#[inline]
fn near_pi(s: f64) -> f64 {
    let square = s * s;
    s * (std::f64::consts::LN_2 - square * polynomial(&NEAR_PI, square))
}

/// Horner's rule, coefficients from the lowest degree up.
#[inline]
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Bound on `|Cl2(s) - Cl2(t)|` over `|s - t| <= radius`.
///
/// `|Cl2'| = |ln|2 sin(s/2)||`: at most ln 2 where the sine is large; near a zero at distance `d`, `2 sin(d/2) >= 2d/pi`, so it is at most
/// `ln(pi/(2 d))` or ln 2. Where the ball may reach the zero, the integral from it is `Cl2` itself, at most `w (2 + |ln w|)` for a width w.
pub(crate) fn clausen_change(t: f64, radius: f64) -> f64 {
    use std::f64::consts::PI;
    let size = t.abs();
    let to_zero = size.min((2.0 * PI - size).abs());
    let nearest = to_zero - radius;
    if nearest > radius {
        let slope = libm::log(PI / (2.0 * nearest)).max(std::f64::consts::LN_2);
        radius * slope * (1.0 + 1e-12)
    } else if radius == 0.0 {
        0.0
    } else {
        let width = (to_zero + radius) * (1.0 + 1e-12);
        2.0 * width * (2.0 + libm::log(width).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::excessive_precision, clippy::approx_constant, reason = "a table as computed at higher precision")]
    fn agrees_with_high_precision_values() {
        // 17 digits from the defining series at 40 digits, at the doubles given.
        let table: [(f64, f64); 24] = [
            (1e-300, 6.9177552789821372e-298),
            (1e-12, 2.8631021115928548e-11),
            (0.001, 0.0079077552928710262),
            (0.1, 0.33027239888281666),
            (0.5, 0.84831187770367927),
            (1.0, 1.0139591323607685),
            (1.0471975511965979, 1.0149416064096536),
            (1.5, 0.93921859275409211),
            (2.0, 0.72714605086327925),
            (2.0943, 0.67667997662985499),
            (2.0945, 0.67657011511833664),
            (2.5, 0.43359820323553278),
            (3.0, 0.098026209391301421),
            (3.14, 0.0011039431770471692),
            (3.1415926, 3.7145614042615806e-8),
            (3.141592653589793, 8.4886047601074949e-17),
            (3.5, -0.24650453023476942),
            (4.0, -0.56814394442986978),
            (4.5, -0.8318392208232194),
            (5.5, -0.98127747477447368),
            (6.0, -0.64078266570172321),
            (6.28, -0.021498296525588156),
            (6.283185, -4.913593461167145e-6),
            (6.283185307179586, -9.0490528080883867e-15),
        ];
        for (t, expected) in table {
            let error = (clausen(t) - expected).abs();
            assert!(error <= 6.0 * ROUNDOFF * expected.abs(), "Cl2({t}) = {} instead of {expected}", clausen(t));
            assert_eq!(clausen(-t), -clausen(t));
        }
    }

    #[test]
    fn the_series_meet_without_a_step() {
        for seam in [2.0 * std::f64::consts::FRAC_PI_3, 4.0 * std::f64::consts::FRAC_PI_3] {
            let (below, above) = (clausen(seam.next_down()), clausen(seam.next_up()));
            assert!((below - above).abs() < 1e-15);
        }
    }

    #[test]
    fn duplication_formula_holds() {
        // Cl2(2t) = 2 Cl2(t) - 2 Cl2(pi - t)
        for i in 1..300 {
            let t = f64::from(i) * 0.01;
            let difference = clausen(2.0 * t) - 2.0 * (clausen(t) - clausen(std::f64::consts::PI - t));
            assert!(difference.abs() < 3e-15, "t = {t}: {difference:e}");
        }
    }

    #[test]
    fn the_change_is_bounded() {
        for i in 0..630 {
            let t = f64::from(i) * 0.01;
            for radius in [1e-15, 1e-8, 1e-3, 0.3] {
                for side in [-1.0, -0.5, 0.5, 1.0] {
                    let moved = t + side * radius;
                    if moved.abs() <= std::f64::consts::TAU {
                        let change = (clausen(moved) - clausen(t)).abs();
                        assert!(change <= clausen_change(t, radius) + 1e-15, "t = {t}, radius = {radius}");
                    }
                }
            }
        }
    }
}
