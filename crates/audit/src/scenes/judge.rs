//! A statement against its truth.

use std::time::{Duration, Instant};

use radgrad_oracle::scene::{Effort, Known};
use radgrad_scene::Quantity;

use super::model::{Change, Exact, Expected, Model};
use super::statement::{Quantum, Response, Stated, Statement, Subject, ask};
use super::truth::{Sharpness, Truth};

/// Half-width of a truth, relative to the mean reflected radiosity and a hundredth of the mean emitted one (to 1 for form factors),
/// above which it is too rough to judge a bound or an estimate that is smaller still.
pub const ROUGH: f64 = 0.03;

/// The verdict on a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The truth may be within the bound, or within [`ESTIMATES`] estimates.
    Held,
    /// It is not within the bound, the value or its stated error is no number, or even light is not even to [`EVEN`].
    Broken,
    /// It is farther off than [`ESTIMATES`] estimates.
    Off,
    /// It is not between limits that may fail as often as one certificate in [`RARE`].
    Missed,
    /// The truth is too rough to say.
    Rough,
}

/// Relative error of radiosities where every face has the same one. Each division has that solution, so that nothing but factors errs, of which
/// those in a row sum to 1: the bounds of a thousand faces that are divided no further would say little.
pub const EVEN: f64 = 1e-6;

/// The probability of failure below which limits may not fail in any run.
pub const RARE: f64 = 1e-4;

/// A statement with its truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// The statement.
    pub statement: Statement,
    /// Its truth.
    pub known: Known,
    /// The quantity that the half-width of a truth is compared with.
    pub(crate) scale: f64,
    /// Whether its stated error holds.
    pub verdict: Verdict,
}

/// How the question to a scene ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Ending {
    /// It was answered: every statement.
    Judged(Vec<Judged>),
    /// It was refused, and why.
    Refused(String),
    /// It was answered and must not be.
    NotRefused,
    /// A panic.
    Panicked,
    /// Scaled by a power of two it has other digits: the first statement, and its value without the scale.
    OtherDigits(Statement, f64),
    /// The oracle has no truth of it, and why.
    NoTruth(String),
}

/// A scene that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// How the question ended.
    pub ending: Ending,
    /// Time of the answer.
    pub answer: Duration,
    /// Time of the truth.
    pub truth: Duration,
}

/// How many times its estimate an error may be before it is one that the estimate does not know of.
pub const ESTIMATES: f64 = 3.0;

impl Judged {
    /// Judges a statement; `scale` is the size that a half-width is compared with.
    #[must_use]
    pub fn new(statement: Statement, known: Known, scale: f64) -> Self {
        let half = 0.5 * known.interval.width();
        // Anything that is not a number compares as broken.
        let size = statement.stated.size();
        let sound = statement.value.is_finite() && size >= 0.0;
        let (low, high, most, beyond) = match statement.stated {
            Stated::Bound(bound) => (statement.value, statement.value, bound, Verdict::Broken),
            Stated::Estimate(estimate) => (statement.value, statement.value, ESTIMATES * estimate, Verdict::Off),
            Stated::Limits { low, high, delta } => (low, high, 0.0, if delta < RARE { Verdict::Broken } else { Verdict::Missed }),
        };
        let distance = (known.interval.low - high).max(low - known.interval.high);
        let verdict = if !sound {
            Verdict::Broken
        } else if distance > most {
            beyond
        } else if half > most && half > ROUGH * scale {
            Verdict::Rough
        } else {
            Verdict::Held
        };
        Self { statement, known, scale, verdict }
    }

    /// The stated error over the error, or over the least error that the truth can tell.
    #[must_use]
    pub(crate) fn over_error(&self) -> f64 {
        let half = 0.5 * self.known.interval.width();
        let error = (self.statement.value - self.known.value).abs();
        // `f64::max` would drop a NaN.
        self.statement.stated.size() / if error > half { error } else { half }
    }
}

/// Asks for a scene and judges every statement.
#[must_use]
pub fn judge(model: &Model, subject: Subject, effort: &Effort) -> Outcome {
    judge_as_sharply(model, subject, (effort, Sharpness::Full))
}

/// The same with a truth so sharp.
#[must_use]
pub(crate) fn judge_as_sharply(model: &Model, subject: Subject, effort: (&Effort, Sharpness)) -> Outcome {
    outcome(model, subject, |statements| judged(model, subject, statements, effort))
}

/// The same of certificates, against the truth that the solution of the scene was judged against, if it was.
#[must_use]
pub(crate) fn judge_certificates(model: &Model, solved: &Outcome, effort: (&Effort, Sharpness)) -> Outcome {
    let Ending::Judged(solved) = &solved.ending else {
        return judge_as_sharply(model, Subject::Certificate, effort);
    };
    let one = |statement: &Statement| {
        let of_it = solved.iter().find(|one| one.statement.of == statement.of);
        of_it.map(|Judged { known, scale, .. }| Judged::new(*statement, *known, *scale))
    };
    outcome(model, Subject::Certificate, |statements| {
        let every_verdict: Option<_> = statements.iter().map(one).collect();
        every_verdict.map_or_else(|| judged(model, Subject::Certificate, statements, effort), Ending::Judged)
    })
}

/// Asks for a scene, and ends with the judgement by `judged` of the statements.
fn outcome(model: &Model, subject: Subject, judged: impl Fn(&[Statement]) -> Ending) -> Outcome {
    let start = Instant::now();
    let said = ask(model, subject);
    let answer = start.elapsed();
    let ending = match said {
        Response::Panicked => Ending::Panicked,
        Response::Refused(why) => Ending::Refused(why),
        Response::Statements(_) if model.expected == Expected::Refusal && subject == Subject::Solve => Ending::NotRefused,
        Response::Statements(statements) => other_digits(model, subject, &statements).unwrap_or_else(|| judged(&statements)),
    };
    Outcome { ending, answer, truth: start.elapsed().saturating_sub(answer) }
}

fn judged(model: &Model, subject: Subject, statements: &[Statement], effort: (&Effort, Sharpness)) -> Ending {
    let truth = match Truth::compute(model, subject, statements, effort) {
        Ok(truth) => truth,
        Err(error) => return Ending::NoTruth(error.to_string()),
    };
    let scale = |statement: &Statement| match statement.of {
        Quantum::Mean(channel) | Quantum::Point(_, channel) => truth.scale[channel],
        _ => 1.0,
    };
    let tolerance = match model.exact {
        Exact::Even(value) if subject == Subject::Solve && !model.has_grid(Quantity::Reflectance) => EVEN * value,
        _ => f64::INFINITY,
    };
    let judged = |(statement, known): (&Statement, &Known)| {
        let one = Judged::new(*statement, *known, scale(statement));
        let is_even = (statement.value - known.value).abs() <= tolerance;
        Judged { verdict: if is_even { one.verdict } else { Verdict::Broken }, ..one }
    };
    Ending::Judged(statements.iter().zip(&truth.known).map(judged).collect())
}

/// A power of two in every length changes no digit.
fn other_digits(model: &Model, subject: Subject, statements: &[Statement]) -> Option<Ending> {
    if !matches!(model.change, Change::Scale(_)) {
        return None;
    }
    let unchanged = Model { change: Change::None, ..model.clone() };
    let Response::Statements(before) = ask(&unchanged, subject) else { return None };
    let same = |(now, before): &(&Statement, &Statement)| now.value.to_bits() == before.value.to_bits();
    statements.iter().zip(&before).find(|pair| !same(pair)).map(|(now, before)| Ending::OtherDigits(*now, before.value))
}

impl Outcome {
    /// Whether something is wrong that no gate allows.
    #[must_use]
    pub fn fails(&self, model: &Model) -> bool {
        match &self.ending {
            Ending::Judged(all) => all.iter().any(|one| one.verdict == Verdict::Broken),
            Ending::Refused(_) => model.expected == Expected::Answer,
            Ending::NotRefused | Ending::Panicked | Ending::OtherDigits(..) | Ending::NoTruth(_) => true,
        }
    }

    /// The faults in words; empty if there are none.
    #[must_use]
    pub fn faults(&self, model: &Model) -> Vec<String> {
        match &self.ending {
            Ending::Judged(all) => {
                let broken = all.iter().filter(|one| one.verdict == Verdict::Broken);
                let line = |one: &Judged| {
                    let Judged { statement: Statement { of, value, stated }, known, .. } = one;
                    let (middle, half) = (0.5 * (known.interval.low + known.interval.high), 0.5 * known.interval.width());
                    let size = stated.size();
                    format!("{}: {value:e} +- {size:.2e}, truth {middle:e} +- {half:.2e}", of.name())
                };
                broken.map(line).collect()
            }
            Ending::Refused(why) if model.expected == Expected::Answer => vec![format!("refused: {why}")],
            Ending::Refused(_) => Vec::new(),
            Ending::NotRefused => vec!["answered, and must be refused".to_owned()],
            Ending::Panicked => vec!["panicked".to_owned()],
            Ending::OtherDigits(statement, before) => {
                let Statement { of, value, .. } = statement;
                vec![format!("{}: {value:e} where the scene without the power of two has {before:e}", of.name())]
            }
            Ending::NoTruth(why) => vec![format!("no truth: {why}")],
        }
    }
}
