//! The contenders of the comparison: five ways to the radiosity of a polygon, four of them also to its gradient.

use radgrad_core::{Answer, DVec3, Emission, evaluate, radiosity_and_gradient};
use radgrad_paper::appendix;
use radgrad_scene::case::Problem;

use crate::comparison::single_precision;
use crate::measures::measure::ratio;
use crate::measures::truth::Truth;

/// A way to compute it.
///
/// ```
/// use radgrad_audit::bounds::digits;
/// use radgrad_audit::comparison::contender::{Contender, Score};
/// use radgrad_audit::cases::family::Family;
/// let problem = Family::Far.case(1, 0).problem()?;
/// let truth = digits::enclosure(&problem, 22)?;
/// let [value, gradient] = Contender::Certified.errors(&problem, &truth);
/// assert!([value, gradient].iter().all(|score| matches!(score, Score::Error(error) if *error < 1e-12)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Contender {
    /// Appendix A of the paper with its misprints.
    AsPrinted,
    /// Appendix A with the misprints mended.
    Corrected,
    /// Lambert's sum in single precision with a fitted angle, as shaders have it: no gradient.
    SinglePrecision,
    /// Our closed form in double precision, without bounds.
    ClosedForm,
    /// Our ladder, with bounds.
    Certified,
}

impl Contender {
    /// All, from the first to the last that there was.
    pub const ALL: [Self; 5] = [Self::AsPrinted, Self::Corrected, Self::SinglePrecision, Self::ClosedForm, Self::Certified];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::AsPrinted => "as-printed",
            Self::Corrected => "corrected",
            Self::SinglePrecision => "single-precision",
            Self::ClosedForm => "closed-form",
            Self::Certified => "certified",
        }
    }

    /// Relative errors of its radiosity and of its gradient (norm) against a truth.
    #[must_use]
    pub fn errors(self, problem: &Problem, truth: &Truth) -> [Score; 2] {
        let (receiver, emitter) = (&problem.receiver, &problem.emitter);
        let is_polynomial = matches!(emitter.emission(), Emission::Polynomial(_));
        let scores = |answer: Option<(f64, DVec3)>| Self::scores(answer, truth);
        match self {
            Self::SinglePrecision => {
                let value = single_precision::radiosity(problem);
                [
                    value.map_or(Score::NotMeant, |value| score(truth.radiosity_error(value), truth.radiosity_magnitude())),
                    Score::NotMeant,
                ]
            }
            Self::Certified => scores(evaluate(receiver, emitter, &problem.occluders).ok().map(|a| (a.radiosity, a.gradient))),
            _ if !problem.occluders.is_empty() => [Score::NotMeant; 2],
            Self::ClosedForm => scores(radiosity_and_gradient(receiver, emitter).ok()),
            _ if is_polynomial => [Score::NotMeant; 2],
            Self::AsPrinted => scores(appendix::as_printed(receiver, emitter).ok()),
            Self::Corrected => scores(appendix::radiosity_and_gradient(receiver, emitter, None).ok()),
        }
    }

    fn scores(answer: Option<(f64, DVec3)>, truth: &Truth) -> [Score; 2] {
        match answer {
            None => [Score::NoAnswer; 2],
            Some((value, gradient)) => [
                score(truth.radiosity_error(value), truth.radiosity_magnitude()),
                score(truth.gradient_error(gradient), truth.gradient_magnitude()),
            ],
        }
    }
}

/// The relative bounds that an answer states for its radiosity and its gradient.
#[must_use]
pub fn stated(answer: &Answer) -> [f64; 2] {
    let size = crate::measures::truth::norm_above(answer.gradient);
    [ratio(answer.radiosity_error, answer.radiosity.abs()), ratio(answer.gradient_error, size)]
}

/// How a contender fared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Score {
    /// It is not meant for such a case.
    NotMeant,
    /// It is, and gave an error, a NaN or an infinity.
    NoAnswer,
    /// Its relative error.
    Error(f64),
}

impl Score {
    /// The error, infinite for no answer; `None` if it was not meant for the case.
    #[must_use]
    pub const fn error(self) -> Option<f64> {
        match self {
            Self::NotMeant => None,
            Self::NoAnswer => Some(f64::INFINITY),
            Self::Error(error) => Some(error),
        }
    }
}

fn score(error: f64, scale: f64) -> Score {
    if error.is_finite() { Score::Error(ratio(error, scale)) } else { Score::NoAnswer }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::digits;
    use crate::cases::family::Family;

    fn errors(contender: Contender, family: Family, index: u64) -> [Score; 2] {
        let problem = family.case(1, index).problem().unwrap();
        contender.errors(&problem, &digits::enclosure(&problem, 22).unwrap())
    }

    #[test]
    fn each_contender_has_the_digits_it_is_known_for() {
        let linear = (0..).find(|&i| errors(Contender::SinglePrecision, Family::Generic, i)[0] == Score::NotMeant).unwrap();
        let constant = (0..).find(|&i| errors(Contender::SinglePrecision, Family::Generic, i)[0] != Score::NotMeant).unwrap();
        let below = |score: Score, limit: f64| score.error().is_some_and(|e| e < limit);
        assert!(!below(errors(Contender::AsPrinted, Family::Generic, linear)[0], 1e-6));
        for ours in [Contender::Corrected, Contender::ClosedForm, Contender::Certified] {
            assert!(errors(ours, Family::Generic, linear).iter().all(|s| below(*s, 1e-11)), "{}", ours.name());
        }
        let [value, gradient] = errors(Contender::SinglePrecision, Family::Generic, constant);
        assert!(below(value, 0.05) && !below(value, 1e-9));
        assert_eq!(gradient, Score::NotMeant);
    }

    #[test]
    fn no_answer_is_not_the_same_as_not_meant() {
        assert_eq!(errors(Contender::Corrected, Family::PolynomialFar, 0), [Score::NotMeant; 2]);
        assert_eq!(errors(Contender::ClosedForm, Family::FarScreen, 0), [Score::NotMeant; 2]);
        assert_eq!((Score::NotMeant.error(), Score::NoAnswer.error()), (None, Some(f64::INFINITY)));
    }
}
