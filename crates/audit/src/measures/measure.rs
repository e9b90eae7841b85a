//! One case measured: core's answer against truth. Whatever happens is an outcome with a name; nothing is skipped.

use glam::DVec3;
use radgrad_core::{Answer, evaluate_to};
use radgrad_scene::case::{Case, Problem};
use serde::{Deserialize, Serialize};

use crate::measures::condition::Condition;
use crate::measures::truth::Truth;

/// A figure of an answer, at least 0; 0 is perfect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Error of the radiosity over the radiosity.
    Value,
    /// Norm of the error of the gradient over its norm.
    Gradient,
    /// Error of the radiosity over the effect on it of half-ulp changes of the input.
    ValueOverCondition,
    /// Error of the gradient over the effect on it of half-ulp changes of the input.
    GradientOverCondition,
    /// Error of the radiosity over the bound stated for it; above 1 the bound is violated.
    ValueOverBound,
    /// Error of the gradient over the bound stated for it; above 1 the bound is violated.
    GradientOverBound,
}

impl Quantity {
    /// All, in the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::Value,
        Self::Gradient,
        Self::ValueOverCondition,
        Self::GradientOverCondition,
        Self::ValueOverBound,
        Self::GradientOverBound,
    ];

    /// Name in tables and gates.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "value",
            Self::Gradient => "gradient",
            Self::ValueOverCondition => "value-over-condition",
            Self::GradientOverCondition => "gradient-over-condition",
            Self::ValueOverBound => "value-over-bound",
            Self::GradientOverBound => "gradient-over-bound",
        }
    }

    /// The figure of the same error over the condition.
    #[must_use]
    pub(crate) const fn over_condition(self) -> Self {
        match self {
            Self::Value | Self::ValueOverCondition | Self::ValueOverBound => Self::ValueOverCondition,
            Self::Gradient | Self::GradientOverCondition | Self::GradientOverBound => Self::GradientOverCondition,
        }
    }
}

/// The outcome of a case.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// An answer with its figures, in the order of [`Quantity::ALL`].
    Measured([f64; 6]),
    /// The input was refused; why.
    Refused(String),
    /// Core gave no answer to a valid input; why.
    Unanswered(String),
    /// The answer has a NaN or an infinity in it; its description.
    NonFinite(String),
    /// The oracle has no truth, or the condition cannot be had; why.
    Undetermined(String),
}

/// The kinds of [`Outcome`], to be counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Answered and measured.
    Measured,
    /// Refused as invalid.
    Refused,
    /// Valid, but without an answer.
    Unanswered,
    /// NaN or infinite.
    NonFinite,
    /// Without truth to measure by.
    Undetermined,
}

impl Kind {
    /// All, in the order of the tables.
    pub const ALL: [Self; 5] = [Self::Measured, Self::Refused, Self::Unanswered, Self::NonFinite, Self::Undetermined];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Refused => "refused",
            Self::Unanswered => "unanswered",
            Self::NonFinite => "non-finite",
            Self::Undetermined => "undetermined",
        }
    }
}

impl Outcome {
    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Measured(_) => Kind::Measured,
            Self::Refused(_) => Kind::Refused,
            Self::Unanswered(_) => Kind::Unanswered,
            Self::NonFinite(_) => Kind::NonFinite,
            Self::Undetermined(_) => Kind::Undetermined,
        }
    }

    /// One figure, if the case was measured.
    #[must_use]
    pub const fn figure(&self, quantity: Quantity) -> Option<f64> {
        match self {
            Self::Measured(figures) => Some(figures[quantity as usize]),
            _ => None,
        }
    }
}

/// Evaluates a case by core and measures the answer.
///
/// ```
/// use radgrad_audit::cases::family::Family;
/// use radgrad_audit::measures::measure::{Quantity, measure};
/// let outcome = measure(&Family::Contact.case(1, 17));
/// assert!(outcome.figure(Quantity::Gradient).is_some_and(|error| error < 1e-12));
/// assert!(outcome.figure(Quantity::GradientOverBound).is_some_and(|ratio| ratio <= 1.0));
/// ```
#[must_use]
pub fn measure(case: &Case) -> Outcome {
    match case.problem() {
        Err(error) => Outcome::Refused(error.to_string()),
        Ok(problem) => match evaluate_to(&problem.receiver, &problem.emitter, &problem.occluders, problem.tolerance) {
            Err(error) => Outcome::Unanswered(error.to_string()),
            Ok(answer) => measure_answer(&problem, &answer),
        },
    }
}

/// Measures an answer, whoever gave it.
#[must_use]
pub(crate) fn measure_answer(problem: &Problem, answer: &Answer) -> Outcome {
    if !answer.radiosity.is_finite() || !answer.gradient.is_finite() {
        return Outcome::NonFinite(format!("radiosity {}, gradient {}", answer.radiosity, answer.gradient));
    }
    if answer.radiosity_error.is_nan() || answer.gradient_error.is_nan() {
        return Outcome::NonFinite(format!("bounds {} and {}", answer.radiosity_error, answer.gradient_error));
    }
    let truth = match Truth::of_problem(problem) {
        Ok(truth) => truth,
        Err(error) => return Outcome::Undetermined(error.to_string()),
    };
    let errors = Errors::new(&truth, answer.radiosity, answer.gradient);
    let condition = if errors == Errors::default() {
        // An exact answer is exact whatever the condition, which a 0 in the dark need not have.
        Condition { radiosity: 0.0, gradient: 0.0 }
    } else {
        match Condition::of_problem(problem) {
            Ok(condition) => condition,
            Err(error) => return Outcome::Undetermined(format!("condition: {error}")),
        }
    };
    Outcome::Measured(errors.figures(&truth, &condition, answer))
}

/// Upper bounds on the absolute errors of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Errors {
    radiosity: f64,
    gradient: f64,
}

impl Errors {
    fn new(truth: &Truth, radiosity: f64, gradient: DVec3) -> Self {
        Self { radiosity: truth.radiosity_error(radiosity), gradient: truth.gradient_error(gradient) }
    }

    fn figures(self, truth: &Truth, condition: &Condition, answer: &Answer) -> [f64; 6] {
        let (value_at_least, gradient_at_least) = truth.errors_at_least(answer.radiosity, answer.gradient);
        [
            ratio(self.radiosity, truth.radiosity_magnitude()),
            ratio(self.gradient, truth.gradient_magnitude()),
            ratio(self.radiosity, condition.radiosity),
            ratio(self.gradient, condition.gradient),
            ratio(value_at_least, answer.radiosity_error),
            ratio(gradient_at_least, answer.gradient_error),
        ]
    }
}

/// `error / scale`; no error is 0 of anything, and any error is infinite against nothing.
pub(crate) fn ratio(error: f64, scale: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / scale }
}

/// Whether the first is worse than the second; a NaN is worst.
pub(crate) fn is_worse(first: f64, second: f64) -> bool {
    first > second || (first.is_nan() && !second.is_nan())
}

/// The worse of two, where `f64::max` would drop a NaN.
#[must_use]
pub fn worse(a: f64, b: f64) -> f64 {
    if is_worse(b, a) { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use radgrad_core::{Method, evaluate};

    fn problem() -> Problem {
        Family::Generic.case(1, 0).problem().expect("valid")
    }

    fn measured(change: impl Fn(&mut Answer)) -> Outcome {
        let problem = problem();
        let mut answer = evaluate(&problem.receiver, &problem.emitter, &[]).expect("an answer");
        change(&mut answer);
        measure_answer(&problem, &answer)
    }

    fn figure(quantity: Quantity, change: impl Fn(&mut Answer)) -> f64 {
        measured(change).figure(quantity).expect("measured")
    }

    #[test]
    fn a_generic_answer_is_good_and_within_its_bounds() {
        assert!(figure(Quantity::Value, |_| ()) < 1e-13);
        assert!(figure(Quantity::Gradient, |_| ()) < 1e-13);
        assert!(figure(Quantity::ValueOverBound, |_| ()) <= 1.0);
        assert!(figure(Quantity::GradientOverBound, |_| ()) <= 1.0);
    }

    #[test]
    fn a_wrong_value_or_gradient_is_seen_in_proportion() {
        let value = figure(Quantity::Value, |a| a.radiosity *= 1.0 + 1e-6);
        assert!((value - 1e-6).abs() < 1e-12, "{value:e}");
        let gradient = figure(Quantity::Gradient, |a| a.gradient *= -1.0);
        assert!((gradient - 2.0).abs() < 1e-9, "{gradient}");
        assert!(figure(Quantity::ValueOverCondition, |a| a.radiosity *= 1.0 + 1e-6) > 1e6);
    }

    #[test]
    fn a_bound_below_the_error_is_seen() {
        assert!(figure(Quantity::ValueOverBound, |a| a.radiosity_error = 1e-30) > 1.0);
        assert_eq!(figure(Quantity::GradientOverBound, |a| a.gradient_error = 0.0), f64::INFINITY);
    }

    #[test]
    fn what_is_not_finite_is_named() {
        assert!(matches!(measured(|a| a.radiosity = f64::NAN), Outcome::NonFinite(text) if text.contains("NaN")));
        assert!(matches!(measured(|a| a.gradient.y = f64::INFINITY), Outcome::NonFinite(text) if text.contains("inf")));
        assert!(matches!(measured(|a| a.gradient_error = f64::NAN), Outcome::NonFinite(text) if text.contains("bounds")));
    }

    #[test]
    fn light_where_there_is_none_is_infinitely_wrong() {
        let problem = Family::BackFacing.case(1, 0).problem().expect("valid");
        let mut answer = evaluate(&problem.receiver, &problem.emitter, &[]).expect("an answer");
        assert_eq!(answer.method, Method::Zero);
        assert_eq!(measure_answer(&problem, &answer), Outcome::Measured([0.0; 6]));
        answer.radiosity = 1e-300;
        let outcome = measure_answer(&problem, &answer);
        assert_eq!(outcome.figure(Quantity::Value), Some(f64::INFINITY));
    }

    #[test]
    fn a_refused_case_says_why() {
        let outcome = measure(&Family::EqualVertices.case(1, 0));
        assert!(matches!(outcome, Outcome::Refused(text) if text.contains("emitter")));
    }
}
