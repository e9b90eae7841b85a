//! Decades of an error: the part of a measured number that is the same on every machine.
//!
//! Two machines, or two releases of a mathematical library, may round the last bit of a logarithm differently; an error of 1.3
//! ulp is then 1.4 ulp. Its decade hardly ever changes, so recorded tables are made of decades alone.

use std::fmt;
use std::str::FromStr;

use crate::measures::leading::Leading;

/// The decade of a number that is not negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Decade {
    /// Exactly 0.
    Zero,
    /// `10^k <= x < 10^(k+1)`.
    From(i32),
    /// Infinite: an error where the truth is 0 and the answer is not.
    Infinite,
}

impl Decade {
    /// The decade of `x`.
    ///
    /// # Panics
    /// If `x` is negative or not a number, as [`Leading::containing`].
    #[must_use]
    pub fn containing(x: f64) -> Self {
        Leading::containing(x).decade()
    }
}

/// As in the tables: `0`, `<1e-15` for all from 1e-16 up, `inf`.
impl fmt::Display for Decade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.pad("0"),
            Self::From(k) => f.pad(&format!("<1e{}", k + 1)),
            Self::Infinite => f.pad("inf"),
        }
    }
}

/// A text that is not a decade.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a decade: 0, <1e-15 or inf")]
pub struct BadDecade(String);

impl FromStr for Decade {
    type Err = BadDecade;

    fn from_str(text: &str) -> Result<Self, BadDecade> {
        match text {
            "0" => Ok(Self::Zero),
            "inf" => Ok(Self::Infinite),
            _ => text
                .strip_prefix("<1e")
                .and_then(|k| k.parse::<i32>().ok())
                .and_then(|k| k.checked_sub(1))
                .map(Self::From)
                .ok_or_else(|| BadDecade(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_open_their_decade() {
        assert_eq!(Decade::containing(1e-16), Decade::From(-16));
        assert_eq!(Decade::containing(1e-16f64.next_down()), Decade::From(-17));
        assert_eq!(Decade::containing(3.0), Decade::From(0));
        assert_eq!(Decade::containing(5e-324), Decade::From(-324));
        assert_eq!(Decade::containing(f64::INFINITY), Decade::Infinite);
        assert_eq!(Decade::containing(0.0), Decade::Zero);
    }

    #[test]
    fn order_is_that_of_the_numbers() {
        let rising = [0.0, 5e-324, 1e-17, 0.5, 20.0, f64::INFINITY].map(Decade::containing);
        assert!(rising.is_sorted_by(|a, b| a < b));
    }

    #[test]
    #[should_panic(expected = "NaN is not the size of an error")]
    fn not_a_number_has_no_decade() {
        let _ = Decade::containing(f64::NAN);
    }

    #[test]
    fn decades_read_back() {
        for decade in [Decade::Zero, Decade::From(-16), Decade::From(0), Decade::From(3), Decade::Infinite] {
            assert_eq!(decade.to_string().parse(), Ok(decade));
        }
        assert!("1e-3".parse::<Decade>().is_err());
    }
}
