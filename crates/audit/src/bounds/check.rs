//! One case: its answers, each against every truth that is asked for.

use std::time::Instant;

use radgrad_core::{Answer, DEFAULT_TOLERANCE, Error, evaluate_to};
use radgrad_scene::case::{Case, Problem};

use crate::bounds::digits;
use crate::bounds::mark::{Figure, Mark, Rung};
use crate::bounds::reference::{Distance, Reference};
use crate::measures::measure::ratio;
use crate::measures::truth::{Truth, norm};

/// The tolerance that is tighter than the default.
pub(crate) const TIGHT: f64 = 1e-15;

/// Digits of the reference from [`radgrad_core::evaluate_digits`]: six more than half an ulp has.
const REFERENCE_DIGITS: u32 = 22;

/// Bound on a 0, over the largest emission, that is as good as 0: the emitter is hidden up to the last bit of any precision.
const LEAST: f64 = 1e-300;

/// Checks of a case beyond the usual one, which holds answers to 1e-12 and 1e-15 against core's own to a tolerance of 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// More tolerances to answer to.
    pub loose: Vec<f64>,
    /// Whether to ask for 22 digits.
    pub digits: bool,
    /// Whether to ask the oracle.
    pub oracle: bool,
    /// Digits to check against more of them, and whether against the oracle's.
    pub many: Vec<(u32, bool)>,
}

impl Effort {
    /// Nothing more.
    pub const LEAST: Self = Self { loose: Vec::new(), digits: false, oracle: false, many: Vec::new() };
}

/// The outcome of a case.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Check {
    /// Its marks, which the tables count.
    pub marks: Vec<Mark>,
    /// Its figures.
    pub figures: Vec<(Figure, f64)>,
    /// Remarks for people.
    pub remarks: Vec<String>,
}

/// An answer, and to which tolerance it was asked.
struct Given {
    tolerance: f64,
    answer: Answer,
}

/// Checks a case.
#[must_use]
pub fn check(case: &Case, effort: &Effort) -> Check {
    let evaluate = |problem: &Problem, tolerance: f64| {
        let Problem { receiver, emitter, occluders, .. } = problem;
        evaluate_to(receiver, emitter, occluders, tolerance)
    };
    check_by(case, effort, evaluate)
}

/// The same for whatever answers: a test plants wrong answers and wrong bounds here.
pub(crate) fn check_by(case: &Case, effort: &Effort, evaluate: impl Fn(&Problem, f64) -> Result<Answer, Error>) -> Check {
    let mut check = Check { marks: vec![Mark::Case], ..Check::default() };
    match case.problem() {
        Err(error) => check.mark(Mark::Refused, error.to_string()),
        Ok(problem) => {
            if let Some((answers, closest)) = check.answers(&problem, effort, evaluate) {
                check.hold(&problem, effort, &answers, closest);
            }
            for &(digits, by_oracle) in &effort.many {
                for (mark, remark) in digits::check(&problem, digits, by_oracle) {
                    check.mark(mark, remark);
                }
            }
        }
    }
    check
}

impl Check {
    /// Whether it has this mark.
    #[must_use]
    pub fn has(&self, mark: Mark) -> bool {
        self.marks.contains(&mark)
    }

    /// Marks the case, once whatever the number of reasons.
    fn mark(&mut self, mark: Mark, remark: String) {
        if !self.has(mark) {
            self.marks.push(mark);
        }
        if !remark.is_empty() {
            self.remarks.push(format!("{mark}: {remark}"));
        }
    }

    /// The answers to the tolerances, the default first, and the one to a tolerance of 0; `None` unless all are finite.
    fn answers(
        &mut self,
        problem: &Problem,
        effort: &Effort,
        evaluate: impl Fn(&Problem, f64) -> Result<Answer, Error>,
    ) -> Option<(Vec<Given>, Given)> {
        let mut ask = |tolerance: f64| {
            let start = Instant::now();
            let result = evaluate(problem, tolerance);
            let time = start.elapsed();
            match result {
                Err(error) => self.mark(Mark::Unanswered, format!("to {tolerance:e}: {error}")),
                Ok(answer) if !is_finite(&answer) => self.mark(Mark::NonFinite, format!("to {tolerance:e}: {answer:?}")),
                Ok(answer) => {
                    if tolerance > 0.0 {
                        self.figures.push((Figure::Time(Rung::from_method(answer.method)), time.as_secs_f64() * 1e9));
                    }
                    return Some(Given { tolerance, answer });
                }
            }
            None
        };
        let answers: Option<Vec<Given>> =
            [DEFAULT_TOLERANCE, TIGHT].iter().chain(&effort.loose).map(|&tolerance| ask(tolerance)).collect();
        Some((answers?, ask(0.0)?))
    }

    /// Holds the answers against the truths.
    fn hold(&mut self, problem: &Problem, effort: &Effort, answers: &[Given], closest: Given) {
        let default = &answers[0].answer;
        let dark = is_zero(default);
        self.marks.push(if dark { Mark::Zero } else { Mark::Nonzero });
        self.marks.push(Mark::By(Rung::from_method(default.method)));
        // No tolerance relative to 0 is met but by a bound of 0, which takes a proof that all is hidden.
        let least = LEAST * problem.emitter.largest_emission();
        for Given { tolerance, answer } in answers.iter().filter(|given| !is_about_zero(&given.answer, least)) {
            if !answer.meets(*tolerance) {
                let missed = if *tolerance < DEFAULT_TOLERANCE { Mark::MissesTight } else { Mark::MissesDefault };
                self.mark(missed, format!("to {tolerance:e}: {answer:?}"));
            }
        }
        let references = self.references(problem, effort, closest.answer);
        self.marks.extend(references.iter().map(Reference::mark));
        for given in answers {
            self.marks.push(Mark::Answer);
            let distances: Vec<[Distance; 2]> = references.iter().map(|truth| truth.distances(&given.answer)).collect();
            self.compare(given, &references, &distances);
            if !distances.iter().any(|distances| is_sharp(&given.answer, distances)) {
                self.marks.push(Mark::Blunt);
            }
        }
        // Core's closest answer is the truth of the others, and an answer to the sharper truths.
        let sharper: Vec<Reference> = references.into_iter().filter(Reference::has_many_digits).collect();
        let distances: Vec<[Distance; 2]> = sharper.iter().map(|truth| truth.distances(&closest.answer)).collect();
        self.compare(&closest, &sharper, &distances);
        if !dark {
            self.errors(default, &Reference::Core(closest.answer), sharper.last());
        }
    }

    /// The truths, the sharpest last.
    fn references(&mut self, problem: &Problem, effort: &Effort, closest: Answer) -> Vec<Reference> {
        let mut references = vec![Reference::Core(closest)];
        if effort.digits {
            match digits::enclosure(problem, REFERENCE_DIGITS) {
                Ok(truth) => references.push(Reference::Digits(truth)),
                Err(why) => self.mark(Mark::ManyDigitsUnanswered, why),
            }
        }
        if effort.oracle {
            match Truth::of_problem(problem) {
                Ok(truth) => references.push(Reference::Oracle(truth)),
                Err(error) => self.mark(Mark::WithoutOracle, error.to_string()),
            }
        }
        references
    }

    /// The least that error over bound can be, and whether that is above 1.
    fn compare(&mut self, given: &Given, references: &[Reference], distances: &[[Distance; 2]]) {
        let Given { tolerance, answer } = given;
        let figures = [Figure::ValueOverBound, Figure::GradientOverBound];
        let bounds = [answer.radiosity_error, answer.gradient_error];
        for (quantity, (figure, bound)) in figures.into_iter().zip(bounds).enumerate() {
            for (reference, distances) in references.iter().zip(distances) {
                let least = distances[quantity].least;
                if !is_zero(answer) || least > 0.0 {
                    self.figures.push((figure, ratio(least, bound)));
                }
                if least > bound {
                    let remark = format!(
                        "{} at {tolerance:e} ({}) is off by {least:.3e} at least, the bound is {bound:.3e}; {}",
                        ["the radiosity", "the gradient"][quantity],
                        answer.method.name(),
                        reference.mark()
                    );
                    self.mark(Mark::Broken, remark);
                }
            }
        }
    }

    /// Relative errors of the default answer, and the tightness of its bounds.
    fn errors(&mut self, answer: &Answer, closest: &Reference, sharpest: Option<&Reference>) {
        let sizes = [answer.radiosity.abs(), norm(answer.gradient)];
        let bounds = [answer.radiosity_error, answer.gradient_error];
        let best = sharpest.unwrap_or(closest).distances(answer);
        let errors = [Figure::ValueError, Figure::GradientError];
        let sharp = [Figure::SharpValueError, Figure::SharpGradientError];
        let tightness = [Figure::ValueTightness, Figure::GradientTightness];
        // A quantity that is not to be told from 0 has no relative error.
        for quantity in [0, 1].into_iter().filter(|&quantity| sizes[quantity] > 0.0) {
            let Distance { most, .. } = best[quantity];
            self.figures.push((errors[quantity], ratio(most, sizes[quantity])));
            if sharpest.is_some() && best[quantity].is_sharp(bounds[quantity]) {
                self.figures.push((sharp[quantity], ratio(most, sizes[quantity])));
                self.figures.push((tightness[quantity], ratio(most, bounds[quantity])));
            }
        }
    }
}

fn is_finite(answer: &Answer) -> bool {
    let bounded = !answer.radiosity_error.is_nan() && !answer.gradient_error.is_nan();
    answer.radiosity.is_finite() && answer.gradient.is_finite() && bounded
}

/// Whether an answer is 0 with bounds of at most that.
fn is_about_zero(answer: &Answer, least: f64) -> bool {
    let is_dark = answer.radiosity == 0.0 && answer.gradient == glam::DVec3::ZERO;
    is_dark && answer.radiosity_error <= least && answer.gradient_error <= least
}

fn is_zero(answer: &Answer) -> bool {
    is_about_zero(answer, 0.0)
}

fn is_sharp(answer: &Answer, [value, gradient]: &[Distance; 2]) -> bool {
    value.is_sharp(answer.radiosity_error) && gradient.is_sharp(answer.gradient_error)
}
