//! The two leading digits of a number: fine enough for a median, coarse enough to be counted.
//!
//! `1.3e-16` stands for all from 1.3e-16 up to 1.4e-16: 90 steps a decade, each at most a tenth wide.

use std::fmt;
use std::str::FromStr;

use crate::measures::decade::Decade;

/// Where a number that is not negative lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Leading {
    /// Exactly 0.
    Zero,
    /// `tenths 10^(exponent - 1) <= x < (tenths + 1) 10^(exponent - 1)`.
    Digits {
        /// Decimal exponent.
        exponent: i32,
        /// The two digits, 10 to 99.
        tenths: u8,
    },
    /// Infinite: an error where the truth is 0 and the answer is not.
    Infinite,
}

impl Leading {
    /// The leading digits of `x`. They are read off its decimal digits, which are exact, where a logarithm would not be.
    ///
    /// # Panics
    /// If `x` is negative or not a number: neither is an error's size, and to file it somewhere would hide a defect.
    #[must_use]
    pub fn containing(x: f64) -> Self {
        assert!(x >= 0.0, "{x} is not the size of an error");
        if x == 0.0 {
            return Self::Zero;
        }
        read(&format!("{x:e}")).unwrap_or(Self::Infinite)
    }

    /// Its decade.
    #[must_use]
    pub const fn decade(self) -> Decade {
        match self {
            Self::Zero => Decade::Zero,
            Self::Digits { exponent, .. } => Decade::From(exponent),
            Self::Infinite => Decade::Infinite,
        }
    }

    /// The least number in the step, to the nearest double.
    #[must_use]
    pub fn least(self) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::Digits { exponent, tenths } => number(u16::from(tenths), exponent),
            Self::Infinite => f64::INFINITY,
        }
    }

    /// The neighbours of 1, 2, 5, 10, ... between which it lies, to the nearest doubles.
    #[must_use]
    pub fn third(self) -> (f64, f64) {
        match self {
            Self::Digits { exponent, tenths } => {
                let (from, to) = match tenths {
                    ..20 => (10, 20),
                    20..50 => (20, 50),
                    50.. => (50, 100),
                };
                (number(from, exponent), number(to, exponent))
            }
            Self::Zero | Self::Infinite => (self.least(), self.least()),
        }
    }

    /// The end of the step, to the nearest double: no number in it is larger.
    #[must_use]
    pub fn end(self) -> f64 {
        match self {
            Self::Digits { exponent, tenths } => number(u16::from(tenths) + 1, exponent),
            Self::Zero | Self::Infinite => self.least(),
        }
    }
}

fn number(tenths: u16, exponent: i32) -> f64 {
    format!("{tenths}e{}", exponent - 1).parse().unwrap_or(f64::INFINITY)
}

/// From `d.ddde-dd`, the digits after the second cut off.
fn read(text: &str) -> Option<Leading> {
    let (mantissa, exponent) = text.split_once('e')?;
    let digit = |place: usize| mantissa.as_bytes().get(place).map_or(Some(0), |b| b.is_ascii_digit().then(|| b - b'0'));
    let well_formed = mantissa.len() == 1 || (mantissa.as_bytes()[1] == b'.' && mantissa.len() > 2);
    let (first, second) = (digit(0)?, digit(2)?);
    let exponent = exponent.parse().ok()?;
    (well_formed && first > 0).then_some(Leading::Digits { exponent, tenths: 10 * first + second })
}

/// `0`, `1.3e-16` or `inf`.
impl fmt::Display for Leading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.pad("0"),
            Self::Digits { exponent, tenths } => f.pad(&format!("{}.{}e{exponent}", tenths / 10, tenths % 10)),
            Self::Infinite => f.pad("inf"),
        }
    }
}

/// A text that is not two leading digits.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not two leading digits: 0, 1.3e-16 or inf")]
pub struct BadLeading(String);

impl FromStr for Leading {
    type Err = BadLeading;

    fn from_str(text: &str) -> Result<Self, BadLeading> {
        match text {
            "0" => Ok(Self::Zero),
            "inf" => Ok(Self::Infinite),
            _ => read(text).ok_or_else(|| BadLeading(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_step_opens_at_its_digits() {
        let digits = |exponent, tenths| Leading::Digits { exponent, tenths };
        assert_eq!(Leading::containing(1.3e-16), digits(-16, 13));
        assert_eq!(Leading::containing(1.3e-16f64.next_down()), digits(-16, 12));
        assert_eq!(Leading::containing(1e-16f64.next_down()), digits(-17, 99));
        assert_eq!(Leading::containing(3.0), digits(0, 30));
        assert_eq!(Leading::containing(5e-324), digits(-324, 50));
        assert_eq!([0.0, f64::INFINITY].map(Leading::containing), [Leading::Zero, Leading::Infinite]);
        assert_eq!((digits(-16, 99).least(), digits(-16, 99).end()), (9.9e-16, 1e-15));
    }

    #[test]
    #[should_panic(expected = "NaN is not the size of an error")]
    fn not_a_number_has_no_leading_digits() {
        let _ = Leading::containing(f64::NAN);
    }

    proptest! {
        #[test]
        fn a_number_is_within_its_step_and_the_step_reads_back(mantissa in 1.0..10.0f64, exponent in -320..300i32) {
            let x: f64 = format!("{mantissa}e{exponent}").parse().unwrap();
            let step = Leading::containing(x);
            prop_assert!(step.least() <= x && x <= step.end());
            prop_assert_eq!(step.to_string().parse(), Ok(step));
            prop_assert_eq!(Decade::containing(x), step.decade());
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["1.3", "13e-4", "0.1e3", "1.e3", "", "1.xe3"] {
            assert!(text.parse::<Leading>().is_err(), "{text}");
        }
    }
}
