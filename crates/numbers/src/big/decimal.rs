//! Decimal digits of a number, rounded at a given place.

use astro_float::BigFloat;

use crate::big::float::{NEAREST, mantissa_bits};
use crate::big::magnitude::Magnitude;

/// Ten to the 19th is the largest power of ten in a word.
const CHUNK: u64 = 10_000_000_000_000_000_000;

/// The number in scientific notation, off by at most one unit of `10^place`: `-1.25e-3`; `0` where it rounds to nothing.
pub fn to_decimal(number: &BigFloat, place: i64) -> String {
    let integer = rounded_multiple(number, place);
    let digits = integer_digits(&integer);
    let Some(last) = digits.rfind(|c| c != '0') else { return "0".to_owned() };
    let exponent = place + digits.len() as i64 - 1;
    let sign = if number.is_negative() { "-" } else { "" };
    let point = if last > 0 { "." } else { "" };
    format!("{sign}{}{point}{}e{exponent}", &digits[..1], &digits[1..=last])
}

/// A bound in scientific notation with three digits, rounded up.
pub fn upper_decimal(bound: Magnitude) -> String {
    if bound == Magnitude::from(0.0) {
        return "0".to_owned();
    }
    let logarithm = bound.log2() * std::f64::consts::LOG10_2;
    let mut exponent = logarithm.floor();
    let mut hundredths = (libm::exp10(logarithm - exponent) * 100.0 * (1.0 + 1e-7)).ceil();
    if hundredths >= 1000.0 {
        (exponent, hundredths) = (exponent + 1.0, 100.0);
    }
    format!("{:.2}e{exponent}", hundredths / 100.0)
}

/// The integer nearest to `|number| 10^-place`, or next to it: the product is off by at most 2^-60 of a unit.
fn rounded_multiple(number: &BigFloat, place: i64) -> BigFloat {
    let power = usize::try_from(place.unsigned_abs()).unwrap_or(usize::MAX);
    let number_bits = number.exponent().map_or(0, |exponent| usize::try_from(exponent).unwrap_or(0));
    // log2 10 < 3.33
    let bits = number_bits + power * 10 / 3 + 192;
    let ten = BigFloat::from_word(10, 64).powi(power, bits, NEAREST);
    let size = number.abs();
    let scaled = if place < 0 { size.mul(&ten, bits, NEAREST) } else { size.div(&ten, bits, NEAREST) };
    scaled.add(&BigFloat::from_f64(0.5, 64), bits, NEAREST).int()
}

/// Decimal digits of an integer that is not negative; none for 0.
fn integer_digits(integer: &BigFloat) -> String {
    let mut words = words_of(integer);
    let mut chunks = Vec::new();
    while words.last().is_some() {
        let mut remainder = 0u128;
        for word in words.iter_mut().rev() {
            let dividend = (remainder << 64) | u128::from(*word);
            *word = low_word(dividend / u128::from(CHUNK));
            remainder = dividend % u128::from(CHUNK);
        }
        chunks.push(low_word(remainder));
        while words.last() == Some(&0) {
            words.pop();
        }
    }
    let digits: String = chunks.iter().rev().map(|chunk| format!("{chunk:019}")).collect();
    digits.trim_start_matches('0').to_owned()
}

#[allow(clippy::cast_possible_truncation, reason = "a quotient or remainder that fits a word")]
const fn low_word(value: u128) -> u64 {
    value as u64
}

/// The integer in base 2^64, lowest word first, without leading zeros.
fn words_of(integer: &BigFloat) -> Vec<u64> {
    let Some((mantissa, _, _, exponent, _)) = integer.as_raw_parts() else { return Vec::new() };
    let bits = usize::try_from(exponent).unwrap_or(0);
    let count = bits.div_ceil(64);
    // The mantissa is a fraction: its highest bits are the integer's.
    let shift = count * 64 - bits;
    let word = |place: usize| {
        let from_top = count - 1 - place;
        let above = if from_top == 0 || shift == 0 { 0 } else { mantissa_bits(mantissa, from_top - 1) << (64 - shift) };
        above | (mantissa_bits(mantissa, from_top) >> shift)
    };
    let mut words: Vec<u64> = (0..count).map(word).collect();
    while words.last() == Some(&0) {
        words.pop();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use astro_float::{Consts, Radix, RoundingMode};

    #[test]
    fn numbers_are_written_as_they_are_read() {
        let mut constants = Consts::new().unwrap();
        let texts = [
            "1.25e-3",
            "-9.99999999999999999999999999999999999999999e0",
            "3.14159265358979323846264338327950288419716939937510582097e40",
            "1e-300",
            "-7e5",
            "1.8446744073709551616e19",
            "1.8446744073709551615e19",
            "1e19",
        ];
        for text in texts {
            let number = BigFloat::parse(text, Radix::Dec, 512, RoundingMode::ToEven, &mut constants);
            let mantissa = text.split('e').next().unwrap().trim_start_matches('-');
            let exponent: i64 = text.split('e').nth(1).unwrap().parse().unwrap();
            let place = exponent - mantissa.len().saturating_sub(2) as i64;
            assert_eq!(to_decimal(&number, place), text);
            assert_eq!(to_decimal(&number, place - 9), text);
        }
        assert_eq!(to_decimal(&BigFloat::from_f64(0.0, 64), -10), "0");
        assert_eq!(to_decimal(&BigFloat::from_f64(0.04, 64), -1), "0");
        assert_eq!(to_decimal(&BigFloat::from_f64(-0.96, 64), -1), "-1e0");
        assert_eq!(to_decimal(&BigFloat::from_f64(0.96, 64), -1), "1e0");
        assert_eq!(to_decimal(&BigFloat::from_f64(12345.0, 64), 2), "1.23e4");
    }

    #[test]
    fn a_bound_is_rounded_up() {
        for (bound, expected) in [(1.0, "1.01e0"), (0.999_999, "1.00e0"), (1.5e-300, "1.51e-300"), (2.345e7, "2.35e7")] {
            assert_eq!(upper_decimal(Magnitude::from(bound)), expected);
        }
        assert_eq!(upper_decimal(Magnitude::from(0.0)), "0");
        assert!(upper_decimal(Magnitude::power_of_two(-4000)).ends_with("e-1205"));
    }
}
