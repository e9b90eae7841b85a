//! Marks, which the audit counts over the cases of a family, and figures, which it collects into distributions.

use std::fmt;
use std::str::FromStr;

use radgrad_core::Method;
use serde::{Deserialize, Serialize};

/// The rung that answered: [`Method`], in the order of the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rung {
    /// Nothing to compute.
    Zero,
    /// The Gauss rule.
    Quadrature,
    /// The closed form in double precision.
    ClosedForm,
    /// The closed form in double-double.
    DoubleDouble,
    /// The closed form with more bits, and whatever is dearer.
    ArbitraryPrecision,
}

impl Rung {
    /// All, from the cheap to the dear.
    pub const ALL: [Self; 5] = [Self::Zero, Self::Quadrature, Self::ClosedForm, Self::DoubleDouble, Self::ArbitraryPrecision];

    /// Those that work in double precision: together the first rung.
    pub(crate) const FIRST: [Self; 2] = [Self::Quadrature, Self::ClosedForm];

    /// The rung of a method.
    #[must_use]
    pub const fn from_method(method: Method) -> Self {
        match method {
            Method::Zero => Self::Zero,
            Method::Quadrature => Self::Quadrature,
            Method::ClosedForm => Self::ClosedForm,
            Method::DoubleDouble => Self::DoubleDouble,
            _ => Self::ArbitraryPrecision,
        }
    }

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Quadrature => "quadrature",
            Self::ClosedForm => "closed-form",
            Self::DoubleDouble => "double-double",
            Self::ArbitraryPrecision => "arbitrary-precision",
        }
    }
}

/// A mark of a case, which the tables count. Most cases have several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Mark {
    /// Any case.
    Case,
    /// The input was refused.
    Refused,
    /// A valid input without an answer at some tolerance.
    Unanswered,
    /// A NaN or an infinity in a value, or a NaN for a bound.
    NonFinite,
    /// Answered with exactly 0 and a bound of 0.
    Zero,
    /// Answered otherwise.
    Nonzero,
    /// A bound is below the error.
    Broken,
    /// A bound asked to be within 1e-12, or a looser tolerance, of an answer that is not 0 is not.
    MissesDefault,
    /// The same for 1e-15.
    MissesTight,
    /// Which rung answered to 1e-12.
    By(Rung),
    /// An answer, at any of the tolerances.
    Answer,
    /// An answer that no truth was sharp for.
    Blunt,
    /// Checked against core's answer to a tolerance of 0.
    AgainstCore,
    /// Checked against core's answer to 22 digits.
    AgainstDigits,
    /// Checked against the oracle.
    AgainstOracle,
    /// To be checked against the oracle, which had no enclosure.
    WithoutOracle,
    /// Many digits checked against more.
    ManyDigits,
    /// Many digits checked against the oracle.
    ManyDigitsAgainstOracle,
    /// Two enclosures to many digits have nothing in common.
    ManyDigitsBroken,
    /// As many digits as asked for were out of reach.
    ManyDigitsUnanswered,
}

impl Mark {
    /// All, in the order of the tables.
    pub const ALL: [Self; 24] = [
        Self::Case,
        Self::Refused,
        Self::Unanswered,
        Self::NonFinite,
        Self::Zero,
        Self::Nonzero,
        Self::Broken,
        Self::MissesDefault,
        Self::MissesTight,
        Self::By(Rung::Zero),
        Self::By(Rung::Quadrature),
        Self::By(Rung::ClosedForm),
        Self::By(Rung::DoubleDouble),
        Self::By(Rung::ArbitraryPrecision),
        Self::Answer,
        Self::Blunt,
        Self::AgainstCore,
        Self::AgainstDigits,
        Self::AgainstOracle,
        Self::WithoutOracle,
        Self::ManyDigits,
        Self::ManyDigitsAgainstOracle,
        Self::ManyDigitsBroken,
        Self::ManyDigitsUnanswered,
    ];

    /// Marks that no case may have, beside [`Mark::Refused`], which is a family's affair.
    pub const FAULTS: [Self; 7] = [
        Self::Unanswered,
        Self::NonFinite,
        Self::Broken,
        Self::MissesDefault,
        Self::MissesTight,
        Self::ManyDigitsBroken,
        Self::ManyDigitsUnanswered,
    ];
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Case => "cases",
            Self::Refused => "refused",
            Self::Unanswered => "unanswered",
            Self::NonFinite => "non-finite",
            Self::Zero => "zero",
            Self::Nonzero => "nonzero",
            Self::Broken => "broken",
            Self::MissesDefault => "misses-1e-12",
            Self::MissesTight => "misses-1e-15",
            Self::By(Rung::Zero) => "by-zero",
            Self::By(Rung::Quadrature) => "by-quadrature",
            Self::By(Rung::ClosedForm) => "by-closed-form",
            Self::By(Rung::DoubleDouble) => "by-double-double",
            Self::By(Rung::ArbitraryPrecision) => "by-arbitrary-precision",
            Self::Answer => "answers",
            Self::Blunt => "blunt",
            Self::AgainstCore => "against-core",
            Self::AgainstDigits => "against-digits",
            Self::AgainstOracle => "against-oracle",
            Self::WithoutOracle => "without-oracle",
            Self::ManyDigits => "many-digits",
            Self::ManyDigitsAgainstOracle => "many-digits-against-oracle",
            Self::ManyDigitsBroken => "many-digits-broken",
            Self::ManyDigitsUnanswered => "many-digits-unanswered",
        })
    }
}

/// A figure of a case, with a distribution over each family. Value and gradient (Euclidean norm) have figures of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Figure {
    /// The least that the error can be over the bound, of every answer against every truth; above 1 the bound is broken.
    ValueOverBound,
    /// The same of the gradient.
    GradientOverBound,
    /// Error over bound of the answer to 1e-12, where a sharp truth is at hand: how tight the bound is.
    ValueTightness,
    /// The same of the gradient.
    GradientTightness,
    /// The most that the relative error of the answer to 1e-12 can be, in every case that is not 0.
    ValueError,
    /// The same of the gradient.
    GradientError,
    /// The same where a sharp truth is at hand.
    SharpValueError,
    /// The same of the gradient.
    SharpGradientError,
    /// Time of an answer by the rung that gave it, whatever the tolerance and with the rungs tried before, in nanoseconds. Not
    /// the same on every machine, so in no recorded table.
    Time(Rung),
}

impl Figure {
    /// All, in the order of the tables.
    pub const ALL: [Self; 13] = [
        Self::ValueOverBound,
        Self::GradientOverBound,
        Self::ValueTightness,
        Self::GradientTightness,
        Self::ValueError,
        Self::GradientError,
        Self::SharpValueError,
        Self::SharpGradientError,
        Self::Time(Rung::Zero),
        Self::Time(Rung::Quadrature),
        Self::Time(Rung::ClosedForm),
        Self::Time(Rung::DoubleDouble),
        Self::Time(Rung::ArbitraryPrecision),
    ];
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::ValueOverBound => "value-over-bound",
            Self::GradientOverBound => "gradient-over-bound",
            Self::ValueTightness => "value-tightness",
            Self::GradientTightness => "gradient-tightness",
            Self::ValueError => "value-error",
            Self::GradientError => "gradient-error",
            Self::SharpValueError => "sharp-value-error",
            Self::SharpGradientError => "sharp-gradient-error",
            Self::Time(Rung::Zero) => "time-zero",
            Self::Time(Rung::Quadrature) => "time-quadrature",
            Self::Time(Rung::ClosedForm) => "time-closed-form",
            Self::Time(Rung::DoubleDouble) => "time-double-double",
            Self::Time(Rung::ArbitraryPrecision) => "time-arbitrary-precision",
        })
    }
}

/// A text that names no mark or figure.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no mark or figure of the bounds table")]
pub struct Unknown(String);

fn named<T: fmt::Display + Copy>(all: &[T], text: String) -> Result<T, Unknown> {
    all.iter().copied().find(|one| one.to_string() == text).ok_or(Unknown(text))
}

impl FromStr for Mark {
    type Err = Unknown;

    fn from_str(text: &str) -> Result<Self, Unknown> {
        named(&Self::ALL, text.to_owned())
    }
}

impl From<Mark> for String {
    fn from(mark: Mark) -> Self {
        mark.to_string()
    }
}

impl TryFrom<String> for Mark {
    type Error = Unknown;

    fn try_from(text: String) -> Result<Self, Unknown> {
        named(&Self::ALL, text)
    }
}

impl From<Figure> for String {
    fn from(figure: Figure) -> Self {
        figure.to_string()
    }
}

impl TryFrom<String> for Figure {
    type Error = Unknown;

    fn try_from(text: String) -> Result<Self, Unknown> {
        named(&Self::ALL, text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_and_figures_read_back_from_their_names() {
        assert!(Mark::ALL.iter().all(|&mark| Mark::try_from(String::from(mark)) == Ok(mark)));
        assert!(Figure::ALL.iter().all(|&figure| Figure::try_from(String::from(figure)) == Ok(figure)));
        assert!("by-magic".parse::<Mark>().is_err());
    }
}
