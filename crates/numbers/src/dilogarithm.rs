//! `J(x) = 1/2 int_0^x (1 - s cot s) ds`, the one special function that a linear emitter needs: Clausen's function without its
//! logarithm, `Cl2(2x) = 2x - 4 J(x) - 2x ln(2 sin x)`, where `Cl2(t) = -int_0^t ln|2 sin(s/2)| ds = Im Li2(e^{it})`.
//!
//! The integral `X1 = int dA/r^2` over a triangle takes three values of J per end of a segment (`forms/linear.rs` of
//! `radgrad-core` has the derivation). J is odd and grows; with Bernoulli numbers
//! `J(x) = sum |B_2k| 2^(2k-1) x^(2k+1) / (2k+1)!`, all terms positive, which gains a factor `(pi/x)^2` a term: at pi/2, which
//! arguments exceed by rounding only, fifty-four terms leave a relative remainder below 6e-35, and as many as it takes
//! are found at run time for more digits (`crate::big`). Doubles take a polynomial of least error instead.

use crate::number::Number;

/// `J(x)` for `|x| <= pi/2`, and a little beyond; relative error at most [`Number::CLAUSEN_UNITS`].
#[inline]
pub fn clausen_rest<N: Number>(x: N) -> N {
    let square = x * x;
    x * square * N::clausen_sum(square)
}

/// Bound on `|J(s) - J(t)|` over `|s - t| <= radius`.
///
/// `J' = (1 - t cot t)/2`, at most `2 (t/pi)^2` up to pi/2, as `(1 - t cot t)/t^2` grows, and 1.68 up to 3 pi/4.
pub fn clausen_rest_change<N: Number>(t: N, radius: N::Radius) -> N::Radius {
    let farthest = (t.size() + radius) * (1.0 + 1e-12);
    if farthest <= std::f64::consts::FRAC_PI_2.into() {
        radius * (farthest * farthest * 0.202_65)
    } else if farthest <= (1.5 * std::f64::consts::FRAC_PI_2).into() {
        radius * 1.69
    } else {
        f64::INFINITY.into()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, LN_2, PI};

    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::number::ROUNDOFF;
    use crate::series::clausen::DOUBLE_UNITS;

    #[test]
    #[allow(clippy::excessive_precision, clippy::approx_constant, reason = "a table as computed at higher precision")]
    fn it_gives_the_values_of_clausens_function() {
        // 17 digits from the defining integral of Cl2 at 40 digits, at the doubles given.
        let table: [(f64, f64); 10] = [
            (0.001, 0.0079077552928710262),
            (0.1, 0.33027239888281666),
            (0.5, 0.84831187770367927),
            (1.0, 1.0139591323607685),
            (1.5, 0.93921859275409211),
            (2.0, 0.72714605086327925),
            (2.0943, 0.67667997662985499),
            (2.5, 0.43359820323553278),
            (3.0, 0.098026209391301421),
            (3.14, 0.0011039431770471692),
        ];
        for (t, expected) in table {
            let value = t - 4.0 * clausen_rest(0.5 * t) - t * libm::log(2.0 * libm::sin(0.5 * t));
            assert!((value - expected).abs() <= 12.0 * ROUNDOFF, "Cl2({t}) = {value} instead of {expected}");
            assert_eq!(clausen_rest(-t), -clausen_rest(t));
        }
        assert!((clausen_rest(FRAC_PI_2) - 0.25 * PI * (1.0 - LN_2)).abs() < 2.0 * ROUNDOFF);
    }

    #[test]
    fn doubles_err_by_less_than_their_bound() {
        let mut worst = 0.0f64;
        for k in 1..=4000 {
            let x = f64::from(k) * (FRAC_PI_2 / 4000.0);
            let truth = clausen_rest(DoubleDouble::from(x));
            worst = worst.max(((DoubleDouble::from(clausen_rest(x)) - truth).hi / (truth.hi * ROUNDOFF)).abs());
        }
        println!("{worst:.2}");
        assert!(worst < DOUBLE_UNITS && worst > 1.0, "{worst}");
        assert_eq!(clausen_rest(1e-80), 1e-240 / 18.0);
    }

    #[test]
    fn double_doubles_have_known_values() {
        // Clausen's function at pi is 0, at pi/2 Catalan's constant, at pi/3, where the logarithm vanishes, Gieseking's.
        let pi = DoubleDouble::pi();
        let ln_2 = DoubleDouble::from(2.0).ln();
        let (one, half) = (DoubleDouble::from(1.0), DoubleDouble::from(0.5));
        let catalan = DoubleDouble { hi: 0.915_965_594_177_219, lo: 3.747_558_421_514_984e-18 };
        let gieseking = DoubleDouble { hi: 1.014_941_606_409_653_7, lo: -7.099_808_813_749_097e-17 };
        let quarter = (pi * half - catalan - pi * half * half * ln_2).scaled(0.25);
        let sixth = pi.divided_by(DoubleDouble::from(3.0));
        for (x, expected) in [
            (pi.scaled(0.5), pi.scaled(0.25) * (one - ln_2)),
            (pi.scaled(0.25), quarter),
            (sixth.scaled(0.5), (sixth - gieseking).scaled(0.25)),
        ] {
            let error = ((clausen_rest(x) - expected).hi / DoubleDouble::roundoff()).abs();
            assert!(error <= 8.0, "{x:?} {error}");
        }
    }

    #[test]
    fn the_change_is_bounded() {
        for i in 0..158 {
            let t = f64::from(i) * 0.01;
            for radius in [1e-15, 1e-8, 1e-3, 0.3] {
                for side in [-1.0, -0.5, 0.5, 1.0] {
                    let change = (clausen_rest(DoubleDouble::from(t + side * radius)) - clausen_rest(DoubleDouble::from(t))).hi;
                    assert!(change.abs() <= clausen_rest_change(t, radius) + 1e-15, "t = {t}, radius = {radius}");
                }
            }
        }
    }
}
