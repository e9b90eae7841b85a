//! Coefficients of the series of [`crate::series::sine`] and [`crate::dilogarithm`] to any number of bits, found when
//! they are first needed.
//!
//! Bernoulli numbers come from tangent numbers, `|B_2k| = 2k T_k / (4^k (4^k - 1))`, and those from sums of positive numbers only
//! (Brent and Harvey, "Fast computation of Bernoulli, tangent and secant numbers", 2011, algorithm TangentNumbers): each step
//! loses three roundings at most, and the 64 bits that coefficients have beyond the precision asked pay for all of them, as for
//! those of Horner's rule.

use astro_float::BigFloat;

use crate::big::float::{NEAREST, shifted};
use crate::big::functions::Steps;
use crate::big::magnitude::Magnitude;

/// Bits beyond the precision asked.
pub(super) const GUARD: usize = 64;

/// The coefficients for one precision.
pub(super) struct Coefficients {
    bits: usize,
    pub(super) steps: Steps,
    sine: Vec<BigFloat>,
    clausen: Vec<BigFloat>,
}

impl Coefficients {
    pub(super) fn new(bits: usize) -> Self {
        Self { bits, steps: Steps::default(), sine: Vec::new(), clausen: Vec::new() }
    }

    pub(super) const fn bits(&self) -> usize {
        self.bits
    }

    pub(super) fn sine_terms(&mut self) -> usize {
        if self.sine.is_empty() {
            self.sine = sine_coefficients(self.bits);
        }
        self.sine.len()
    }

    /// Coefficient `k` below [`Self::sine_terms`].
    pub(super) fn sine(&self, k: usize) -> &BigFloat {
        &self.sine[k]
    }

    /// The sum over `square = x^2` with a relative error of at most two roundoffs, x up to 3 pi/4.
    ///
    /// Term k over the first one is at most `r^k`, `r = (x/pi)^2` at most 9/16: `bits/log2(1/r)` and three terms leave less than
    /// half a roundoff.
    pub(super) fn clausen_sum(&mut self, square: &BigFloat) -> BigFloat {
        /// `2 log2 pi`.
        const LOG_SQUARE: f64 = 3.302_992_259_161_862;
        /// `2 log2 (4/3)`.
        const LEAST: f64 = 0.830_074_998_557_687;
        let ratio = (LOG_SQUARE - Magnitude::of_number(square).log2()).max(LEAST);
        let terms = first_integer_above(self.bits as f64 / ratio) + 3;
        if self.clausen.len() < terms {
            self.clausen = clausen_coefficients(self.bits, terms.max(first_integer_above(0.5 * self.bits as f64) + 4));
        }
        let working = self.bits + GUARD;
        let sum = self.clausen[..terms]
            .iter()
            .rev()
            .fold(BigFloat::new(working), |sum, c| sum.mul(square, working, NEAREST).add(c, working, NEAREST));
        rounded(sum, self.bits)
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive number of terms, far below 2^32")]
pub(super) fn first_integer_above(value: f64) -> usize {
    value as usize + 1
}

pub(super) fn rounded(number: BigFloat, bits: usize) -> BigFloat {
    number.add(&BigFloat::new(64), bits, NEAREST)
}

pub(super) fn integer(n: usize) -> BigFloat {
    BigFloat::from_u64(n as u64, 64)
}

/// `(-1)^k 6 / (2k + 3)!` while above an eighth of a roundoff.
fn sine_coefficients(bits: usize) -> Vec<BigFloat> {
    let working = bits + GUARD;
    let least = Magnitude::power_of_two(-(bits as i64) - 3);
    let mut exact = vec![BigFloat::from_word(1, working)];
    loop {
        let k = exact.len();
        let next = exact[k - 1].div(&integer((2 * k + 2) * (2 * k + 3)), working, NEAREST).neg();
        if Magnitude::of_number(&next) < least {
            return exact.into_iter().map(|c| rounded(c, bits)).collect();
        }
        exact.push(next);
    }
}

/// `T_1`, `T_2`, ... in the order of the array.
fn tangent_numbers(count: usize, bits: usize) -> Vec<BigFloat> {
    let mut tangent = vec![BigFloat::from_word(1, bits)];
    for k in 1..count {
        tangent.push(tangent[k - 1].mul(&integer(k), bits, NEAREST));
    }
    for k in 1..count {
        for j in k..count {
            let earlier = tangent[j - 1].mul(&integer(j - k), bits, NEAREST);
            tangent[j] = tangent[j].mul(&integer(j - k + 2), bits, NEAREST).add(&earlier, bits, NEAREST);
        }
    }
    tangent
}

/// The first coefficients `|B_2k| 2^(2k-1) / (2k+1)! = k T_k / ((4^k - 1) (2k+1)!)`.
fn clausen_coefficients(bits: usize, count: usize) -> Vec<BigFloat> {
    let working = bits + GUARD;
    let one = BigFloat::from_word(1, working);
    let mut factorial = one.clone();
    let mut power: i32 = 0;
    let coefficient = |(index, tangent): (usize, &BigFloat)| {
        let k = index + 1;
        power += 2;
        factorial = factorial.mul(&integer(2 * k * (2 * k + 1)), working, NEAREST);
        let divisor = shifted(&one, power).sub(&one, working, NEAREST).mul(&factorial, working, NEAREST);
        tangent.mul(&integer(k), working, NEAREST).div(&divisor, working, NEAREST)
    };
    tangent_numbers(count, working).iter().enumerate().map(coefficient).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::big::{Big, with_bits};
    use crate::dilogarithm::clausen_rest;
    use crate::double_double::DoubleDouble;
    use crate::number::Number;
    use crate::radius::Radius;
    use crate::series::sine::SINE_SERIES;

    #[test]
    fn tangent_numbers_are_those_of_the_series_of_the_tangent() {
        let expected = [1.0, 2.0, 16.0, 272.0, 7936.0, 353_792.0, 22_368_256.0];
        for (tangent, expected) in tangent_numbers(7, 128).iter().zip(expected) {
            assert_eq!(crate::big::float::nearest_double(tangent), expected);
        }
    }

    #[test]
    fn coefficients_are_those_kept_in_double_double() {
        with_bits(128, || {
            assert!(Big::sine_coefficients().count() > SINE_SERIES.len());
            for (coefficient, coded) in Big::sine_coefficients().zip(SINE_SERIES) {
                let difference = coefficient - Big::from_double_double(coded);
                assert!(difference.high().abs() <= 2f64.powi(-105) * coded.hi.abs(), "{coded:?}");
            }
            for x in [1e-9, 0.15, 0.85, 1.05, 1.5, 1.56] {
                let wide = clausen_rest(Big::from_double(x));
                let narrow = clausen_rest(DoubleDouble::from(x));
                let difference = (wide - Big::from_double_double(narrow)).high().abs();
                assert!(difference <= 8.0 * DoubleDouble::roundoff() * narrow.hi.abs(), "{x}: {difference:e}");
            }
        });
    }

    #[test]
    fn clausens_function_keeps_its_error_bound_at_any_precision() {
        for bits in [64, 192, 448, 1024] {
            for x in [1e-200, 1e-5, 0.35, 1.047, 1.56, 1.6, 2.3] {
                let value = |bits| with_bits(bits, || clausen_rest(Big::from_double(x)).to_float());
                let [rough, fine] = [bits, bits + 128].map(value);
                let error = Magnitude::of_number(&fine.sub_full_prec(&rough)) / Magnitude::of_number(&fine);
                let units = (error * Magnitude::power_of_two(bits as i64)).to_double();
                assert!(units <= Big::CLAUSEN_UNITS, "{bits} bits, x = {x}: {units} units");
            }
        }
    }

    #[test]
    fn clausens_function_has_known_values_at_fifty_digits() {
        // Catalan's constant, the value at pi/2, where twice the sine is the root of 2.
        let catalan = with_bits(192, || {
            let right = Big::pi().scaled(0.5);
            (right - clausen_rest(right.scaled(0.5)).scaled(4.0) - right * Big::from_double(2.0).ln().scaled(0.5)).to_float()
        });
        assert!(
            crate::big::decimal::to_decimal(&catalan, -50).starts_with("9.1596559417721901505460351493238411077414937428167e-1")
        );
        // Gieseking's constant, the largest value, at pi/3, where twice the sine is 1.
        let gieseking = with_bits(192, || {
            let third = Big::pi() / Big::from_double(3.0);
            (third - clausen_rest(third.scaled(0.5)).scaled(4.0)).to_float()
        });
        assert!(
            crate::big::decimal::to_decimal(&gieseking, -50).starts_with("1.014941606409653625021202554274520285941689307530")
        );
    }
}
