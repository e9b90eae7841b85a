//! Clausen's function `Cl2(t) = -int_0^t ln|2 sin(s/2)| ds = Im Li2(e^{it})`, the one special function that a linear emitter
//! needs.
//!
//! [`crate::linear`] brings the dilogarithms of `X1 = int dA/r^2` down to three values of `Cl2` per vertex (its module
//! documentation has the derivation). Series with Bernoulli numbers (Lewin, "Polylogarithms and Associated Functions", 1981,
//! section 4.3), near 0 and near pi:
//! - `Cl2(t) = t [1 - ln t + sum |B_2k| t^2k / (2k (2k+1)!)]`,
//! - `Cl2(pi - s) = s [ln 2 - sum |B_2k| (4^k - 1) s^2k / (2k (2k+1)!)]`.
//!
//! They meet at 2 pi/3, where both lose a factor of nine a term: thirty-four terms leave a relative remainder below 2e-35, and as
//! many as it takes are found at run time for more digits (`crate::big`). Doubles take polynomials of least error instead, with
//! ten and nine terms, below 1e-17. Relative accuracy is kept at the zeros 0 and pi.

mod coefficients;

use std::f64::consts::PI;

use crate::number::Number;
use crate::radius::Radius;
use coefficients::{NEAR_PI, NEAR_ZERO};

/// Relative error of [`clausen`] on doubles, in units of roundoff: at 2 pi/3 the bracket is a third of its largest term, so
/// three roundings of size one and one of the logarithm (2 ulp allowed) cost 3 (3 + 4) units at worst; measured 3.1 on the
/// table of the tests.
pub(crate) const DOUBLE_UNITS: f64 = 24.0;

/// The same on double-doubles, whose logarithm is allowed 64 units.
pub(crate) const DOUBLE_DOUBLE_UNITS: f64 = 3.0 * (4.0 + 64.0);

/// `Cl2(t)` for `|t| <= 2 pi`; relative error at most [`Number::CLAUSEN_UNITS`].
#[inline]
pub(crate) fn clausen<N: Number>(t: N) -> N {
    let negative = t.high() < 0.0;
    let size = if negative { -t } else { t };
    let magnitude = if size.high() <= 2.0 * PI / 3.0 {
        near_zero(size)
    } else if size.high() <= 4.0 * PI / 3.0 {
        near_pi(size.pi_minus())
    } else {
        let rest = size.scaled(0.5).pi_minus().scaled(2.0);
        -near_zero(if rest.high() < 0.0 { -rest } else { rest })
    };
    if negative { -magnitude } else { magnitude }
}

#[inline]
fn near_zero<N: Number>(t: N) -> N {
    if t.high() == 0.0 {
        return t;
    }
    let square = t * t;
    t * ((N::from_double(1.0) - t.ln()) + square * N::clausen_sum(Around::Zero, square))
}

#[inline]
fn near_pi<N: Number>(s: N) -> N {
    let square = s * s;
    s * (N::ln_2() - square * N::clausen_sum(Around::Pi, square))
}

/// On doubles: P and Q of least largest error relative to the brackets `1 - ln t + t^2 P(t^2)` and `ln 2 - s^2 Q(s^2)` up to
/// 2 pi/3 and pi/3, by Remez's algorithm, 2^-57.0 and 2^-56.5.
pub(crate) const DOUBLE_NEAR_ZERO: [f64; 10] = [
    0.013_888_888_888_888_88,
    6.944_444_444_453_365e-5,
    7.873_519_775_358_003e-7,
    1.148_221_683_257_537_8e-8,
    1.897_882_202_908_854_3e-10,
    3.387_595_672_317_545e-12,
    6.361_022_009_989_467e-14,
    1.275_541_680_547_571_7e-15,
    2.057_042_680_558_643e-17,
    8.962_984_535_314_219e-19,
];

pub(crate) const DOUBLE_NEAR_PI: [f64; 9] = [
    0.041_666_666_666_667_22,
    0.001_041_666_666_646_695_6,
    4.960_317_485_094_369_4e-5,
    2.927_963_662_022_772_3e-6,
    1.941_590_029_595_676_5e-7,
    1.386_035_246_776_713_5e-8,
    1.057_442_960_042_55e-9,
    7.165_906_658_631_949e-11,
    1.053_208_725_425_637_4e-11,
];

/// The polynomials by Estrin's scheme.
#[inline]
pub(crate) fn double_sum(around: Around, z: f64) -> f64 {
    let (c, rest) = match around {
        Around::Zero => (&DOUBLE_NEAR_ZERO[..8], DOUBLE_NEAR_ZERO[8] + DOUBLE_NEAR_ZERO[9] * z),
        Around::Pi => (&DOUBLE_NEAR_PI[..8], DOUBLE_NEAR_PI[8]),
    };
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2;
    low + ((c[4] + c[5] * z) + (c[6] + c[7] * z) * z2) * z4 + rest * (z4 * z4)
}

/// Where a series of Clausen's function is developed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Around {
    /// The coefficients are `|B_2k| / (2k (2k+1)!)`.
    Zero,
    /// The coefficients are `|B_2k| (4^k - 1) / (2k (2k+1)!)`.
    Pi,
}

/// The first terms by Horner's rule.
#[inline]
pub(crate) fn sum<N: Number, const TERMS: usize>(around: Around, square: N) -> N {
    let coefficients = match around {
        Around::Zero => &NEAR_ZERO[..TERMS],
        Around::Pi => &NEAR_PI[..TERMS],
    };
    coefficients.iter().rev().fold(N::from_double(0.0), |sum, c| sum * square + N::from_double_double(*c))
}

/// Bound on `|Cl2(s) - Cl2(t)|` over `|s - t| <= radius`.
///
/// `|Cl2'| = |ln|2 sin(s/2)||`: at most ln 2 where the sine is large; near a zero at distance `d`, `2 sin(d/2) >= 2d/pi`, so it
/// is at most `ln(pi/(2 d))` or ln 2. Where the ball may reach the zero, the integral from it is `Cl2` itself, at most `w (2 +
/// |ln w|)` for a width w.
pub(crate) fn clausen_change<N: Number>(t: N, radius: N::Radius) -> N::Radius {
    let to_zero = if t.high().abs() <= PI {
        t.size()
    } else {
        let size = if t.high() < 0.0 { -t } else { t };
        size.scaled(0.5).pi_minus().scaled(2.0).size()
    };
    /// `ln(pi/2)`.
    const LN_HALF_PI: f64 = 0.451_582_705_289_454_9;
    let nearest = to_zero - radius;
    let zero = N::Radius::from(0.0);
    if nearest > radius {
        let slope = (LN_HALF_PI - nearest.ln()).max(std::f64::consts::LN_2);
        radius * (slope * (1.0 + 1e-12))
    } else if radius == zero {
        zero
    } else {
        let width = (to_zero + radius) * (1.0 + 1e-12);
        width * (2.0 * (2.0 + width.ln().abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::number::ROUNDOFF;

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
    #[allow(clippy::excessive_precision, clippy::approx_constant, reason = "a table as computed at higher precision")]
    fn double_doubles_agree_with_high_precision_values() {
        let table: [(f64, (f64, f64)); 14] = [
            (1e-12, (2.863102111592855e-11, -1.2288072856499375e-27)),
            (0.001, (0.007907755292871027, -5.740791873918357e-19)),
            (0.5, (0.8483118777036792, 5.302785658363106e-17)),
            (1.5, (0.9392185927540921, -3.081857467472142e-17)),
            (2.0, (0.7271460508632792, 3.330280535344794e-17)),
            (2.0943, (0.676679976629855, -2.842769358786911e-17)),
            (2.0945, (0.6765701151183366, -5.558095444334652e-18)),
            (3.0, (0.09802620939130142, -3.694417055399229e-18)),
            (3.1415926, (3.7145614042615806e-08, 4.380377736585402e-25)),
            (3.141592653589793, (8.488604760107495e-17, -5.639425589331052e-33)),
            (4.0, (-0.5681439444298698, 3.745705301422366e-17)),
            (5.5, (-0.9812774747744737, 1.1534833745171103e-17)),
            (6.283185, (-4.913593461167145e-06, -2.588156614338855e-22)),
            (6.283185307179586, (-9.049052808088387e-15, -1.0878541923373083e-31)),
        ];
        for (t, (hi, lo)) in table {
            let error = (clausen(DoubleDouble::from(t)) - DoubleDouble { hi, lo }).to_f64().abs() / hi.abs();
            assert!(error <= 12.0 * DoubleDouble::roundoff(), "Cl2({t}) errs by {error:e}");
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
            let difference = clausen(2.0 * t) - 2.0 * (clausen(t) - clausen(PI - t));
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
