//! Errors against a truth given as a decimal number of more digits than a double has.
//!
//! A decimal `t` is split into the double nearest to it and the rest, `t = high + low`; the rest is found in integers of 37
//! decimal digits, so `low` is right to `|t| 1e-36`. The error of a double `v` is then `|(v - high) - low|`, where the first
//! difference is exact when `v` is any good (Sterbenz 1974): an error of a hundredth of an ulp is seen as such.

use std::str::FromStr;

/// A decimal number, as the nearest double and the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal {
    /// The double nearest to the number.
    pub high: f64,
    /// The number less `high`.
    pub low: f64,
}

/// Significant digits that an `i128` holds, whatever they are.
const DIGITS: usize = 37;

impl Decimal {
    /// Absolute error of `value`, taken for this number.
    #[must_use]
    pub fn error_of(self, value: f64) -> f64 {
        ((value - self.high) - self.low).abs()
    }
}

impl FromStr for Decimal {
    type Err = String;

    /// Reads a number of at most 37 significant digits, with or without point and exponent.
    fn from_str(text: &str) -> Result<Self, String> {
        let high: f64 = text.parse().map_err(|error| format!("{text}: {error}"))?;
        let (number, nearest) =
            (integer_and_power(text)?, integer_and_power(&format!("{high:.precision$e}", precision = DIGITS - 1))?);
        let power = number.1.min(nearest.1);
        let scaled = |(integer, own): (i128, i32)| {
            let factor = u32::try_from(own - power).ok().and_then(|shift| 10_i128.checked_pow(shift));
            factor.and_then(|factor| integer.checked_mul(factor)).ok_or_else(|| format!("{text} has more than {DIGITS} digits"))
        };
        let remainder = if high == 0.0 { 0 } else { scaled(number)? - scaled(nearest)? };
        let low = format!("{remainder}e{power}").parse().map_err(|error| format!("{text}: {error}"))?;
        Ok(Self { high, low })
    }
}

/// A decimal number as an integer times a power of ten.
fn integer_and_power(text: &str) -> Result<(i128, i32), String> {
    let wrong = |error: std::num::ParseIntError| format!("{text}: {error}");
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let places = i32::try_from(fraction.len()).map_err(|_| format!("{text} is too long"))?;
    let integer = format!("{whole}{fraction}").parse().map_err(wrong)?;
    Ok((integer, exponent.parse::<i32>().map_err(wrong)? - places))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &str) -> Decimal {
        text.parse().unwrap()
    }

    #[test]
    fn the_parts_are_the_double_and_its_rest() {
        // 0.1 as a double is 0.1000000000000000055511151231257827021181583404541015625.
        assert_eq!(split("0.1"), Decimal { high: 0.1, low: -5.551_115_123_125_783e-18 });
        assert_eq!(split("-0.1"), Decimal { high: -0.1, low: 5.551_115_123_125_783e-18 });
        // 0.1 times 2^-200 to 30 digits: scaling by a power of two keeps the rest's share.
        let tiny = split("6.22301527786114170714406405378e-62");
        assert!((tiny.low / tiny.high + 5.551_115e-17).abs() < 1e-22, "{tiny:?}");
        assert_eq!(split("9007199254740993"), Decimal { high: 9_007_199_254_740_992.0, low: 1.0 });
        for exact in ["0", "0.0", "-0.5", "2e3", "1.25E-1", "1e22"] {
            assert_eq!(split(exact).low, 0.0, "{exact}");
        }
    }

    #[test]
    fn an_error_far_below_an_ulp_is_seen() {
        let third = split("0.333333333333333333333333333333");
        let error = third.error_of(1.0 / 3.0);
        assert!((error - 1.850_371_707_708_594e-17).abs() < 1e-29, "{error:e}");
        assert_eq!(split("0").error_of(-1e-300), 1e-300);
    }

    #[test]
    fn what_is_no_such_number_is_refused() {
        for text in ["", "x", "1e", "1.2.3", "nan", "inf", "1234567890123456789012345678901234567890123"] {
            assert!(text.parse::<Decimal>().is_err(), "{text}");
        }
    }
}
