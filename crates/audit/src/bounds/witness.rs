//! Cases that come nearest to breaking a bound, kept in `data/worst/*.jsonl`: how each is asked, and how near it came.
//!
//! [`crate::bounds::search`] finds them. Asked again they cost next to nothing, and a bound that became too small, by a slip in its
//! derivation or in its subject, is broken at once, where a million cases drawn at random may pass.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::DVec3;
use radgrad_core::batch::{Answers, Engine, Receivers};
use radgrad_core::{Answer, Emission, Emitter, Method, Polygon, Receiver, Tolerance, evaluate_to, evaluate_value};
use radgrad_scene::case::{Case, Problem};
use serde::{Deserialize, Serialize};

use crate::bounds::digits;
use crate::measures::measure::{ratio, worse};
use crate::measures::truth::{Truth, norm_above};

/// How a case is asked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Query {
    /// `evaluate_to` with this tolerance.
    Answer(f64),
    /// `evaluate_value` with this relative tolerance.
    Value(f64),
    /// A batch of one receiver in double precision.
    Lanes(f64),
    /// The same in single precision: position, normal and reflectance are rounded to it first.
    SingleLanes(f64),
    /// `evaluate_digits` with so many, against more of them.
    Digits(u32),
}

/// The part of the code that answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnswerMethod {
    /// The Gauss rule.
    Quadrature,
    /// The closed form in double precision.
    ClosedForm,
    /// The closed form in double-double.
    DoubleDouble,
    /// The closed form with more bits.
    ArbitraryPrecision,
    /// Both sides of an emitter that is not flat.
    OnSurface,
    /// Lanes of double precision.
    Lanes,
    /// Lanes of single precision.
    SingleLanes,
    /// Many digits.
    Digits,
}

impl AnswerMethod {
    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadrature => "quadrature",
            Self::ClosedForm => "closed-form",
            Self::DoubleDouble => "double-double",
            Self::ArbitraryPrecision => "arbitrary-precision",
            Self::OnSurface => "on-surface",
            Self::Lanes => "lanes",
            Self::SingleLanes => "single-lanes",
            Self::Digits => "digits",
        }
    }

    /// Whether its bounds are above the rounding of the result, so that a search has something to find.
    pub(crate) const fn has_bounds_above_rounding(self) -> bool {
        matches!(self, Self::Quadrature | Self::ClosedForm | Self::Lanes | Self::SingleLanes)
    }

    const fn from_method(method: Method) -> Option<Self> {
        match method {
            Method::Zero => None,
            Method::Quadrature => Some(Self::Quadrature),
            Method::ClosedForm => Some(Self::ClosedForm),
            Method::DoubleDouble => Some(Self::DoubleDouble),
            Method::OnSurface => Some(Self::OnSurface),
            _ => Some(Self::ArbitraryPrecision),
        }
    }
}

/// The kind of an emission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EmissionKind {
    /// Constant.
    Constant,
    /// Affine.
    Linear,
    /// A polynomial.
    Polynomial,
}

/// The visible part of the emitter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sight {
    /// All of it.
    Whole,
    /// Cut by the horizon.
    Cut,
    /// Partly hidden by occluders.
    Screened,
}

/// Value or gradient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The radiosity.
    Value,
    /// The gradient, by its norm.
    Gradient,
}

/// A kind of bound: each has a worst case of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Place {
    /// The part that answered.
    pub by: AnswerMethod,
    /// Of which emission.
    pub emission: EmissionKind,
    /// Of which part of the emitter.
    pub sight: Sight,
    /// Of which quantity.
    pub quantity: Quantity,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = if self.quantity == Quantity::Value { "value" } else { "gradient" };
        write!(f, "{} {} {} {quantity}", self.by.name(), self.emission.name(), self.sight.name())
    }
}

impl EmissionKind {
    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::Polynomial => "polynomial",
        }
    }
}

impl Sight {
    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Cut => "cut",
            Self::Screened => "screened",
        }
    }

    fn classify(problem: &Problem) -> Self {
        let (x, n1) = (problem.receiver.position(), problem.receiver.normal());
        if !problem.occluders.is_empty() {
            Self::Screened
        } else if problem.emitter.polygon().vertices().iter().all(|v| n1.dot(*v - x) > 0.0) {
            Self::Whole
        } else {
            Self::Cut
        }
    }
}

/// A case that came near.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Witness {
    /// Whose bound.
    pub place: Place,
    /// How it is asked.
    pub ask: Query,
    /// Error over bound when it was recorded: the least that it can be.
    pub ratio: f64,
    /// The bound stated then.
    pub bound: f64,
    /// The case.
    pub case: Case,
}

/// A stated bound, held to truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Where the bound belongs, and how large it is.
    pub place: Place,
    /// The bound.
    pub bound: f64,
    /// The least that the error can be over it; above 1 it is broken.
    pub ratio: f64,
}

/// Digits that answers in doubles are held against.
pub(crate) const DIGITS: u32 = 22;

/// The outcome of asking.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Asked {
    /// A statement each on value and gradient; none if the quantity is 0 or cannot be asked for in this way.
    pub held: Vec<Held>,
    /// Faults whatever the bounds: no answer, a NaN, a tolerance that is not met.
    pub faults: Vec<String>,
}

impl Query {
    /// Asks and holds the answer to a truth of many digits.
    #[must_use]
    pub fn check(self, case: &Case) -> Asked {
        let Ok(mut problem) = case.problem() else { return Asked::default() };
        if let Self::SingleLanes(_) = self
            && !round_to_single(&mut problem)
        {
            return Asked::default();
        }
        let mut asked = Asked::default();
        if let Self::Digits(digits) = self {
            asked.hold_digits(&problem, digits);
            return asked;
        }
        match self.answer(&problem) {
            // Single precision has a range of its own.
            Err(_) if matches!(self, Self::SingleLanes(_)) => {}
            Err(error) => asked.faults.push(format!("{self}: {error}")),
            Ok(None) => {}
            Ok(Some((by, answer))) => asked.hold(self, &problem, by, &answer),
        }
        asked
    }

    /// The answer, and the method that gave it; none where another way answers.
    pub(crate) fn answer(self, problem: &Problem) -> Result<Option<(Option<AnswerMethod>, Answer)>, radgrad_core::Error> {
        let Problem { receiver, emitter, occluders, .. } = problem;
        match self {
            Self::Answer(tolerance) => {
                let answer = evaluate_to(receiver, emitter, occluders, tolerance)?;
                Ok(Some((AnswerMethod::from_method(answer.method), answer)))
            }
            Self::Value(relative) => {
                let value = evaluate_value(receiver, emitter, occluders, Tolerance { relative, absolute: 0.0 })?;
                let (radiosity, radiosity_error) = (value.radiosity, value.radiosity_error);
                let (gradient, gradient_error) = (DVec3::ZERO, f64::NAN);
                Ok(Some((
                    AnswerMethod::from_method(value.method),
                    Answer { radiosity, gradient, radiosity_error, gradient_error, method: value.method },
                )))
            }
            Self::Lanes(tolerance) | Self::SingleLanes(tolerance) => {
                if !occluders.is_empty() {
                    return Ok(None);
                }
                let (x, n1, rho) = (receiver.position().to_array(), receiver.direction().to_array(), receiver.reflectance());
                macro_rules! of_lanes {
                    ($number:ty, $by:expr) => {{
                        let ([x, n1], rho) = ([x, n1].map(|v| v.map(|c| [c as $number])), [rho as $number]);
                        let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n1[0], &n1[1], &n1[2]], &rho)?;
                        let mut answers = Answers::<$number>::new();
                        Engine::new().evaluate_to(&receivers, emitter, tolerance, &mut answers)?;
                        let counts = answers.counts;
                        let gradient = DVec3::from(answers.gradient.each_ref().map(|c| f64::from(c[0])));
                        let answer = Answer {
                            radiosity: f64::from(answers.radiosity[0]),
                            gradient,
                            radiosity_error: f64::from(answers.radiosity_error[0]),
                            gradient_error: f64::from(answers.gradient_error[0]),
                            method: Method::ClosedForm,
                        };
                        let by_lanes = counts.whole + counts.clipped == 1 && counts.single + counts.doubled == 0;
                        let by = if counts.zero == 1 { None } else { Some($by) };
                        Ok((by_lanes || counts.zero == 1).then_some((by, answer)))
                    }};
                }
                #[allow(clippy::cast_possible_truncation, reason = "rounded to single precision before")]
                if let Self::Lanes(_) = self {
                    of_lanes!(f64, AnswerMethod::Lanes)
                } else {
                    of_lanes!(f32, AnswerMethod::SingleLanes)
                }
            }
            Self::Digits(_) => Ok(None),
        }
    }

    fn tolerance(self) -> f64 {
        match self {
            Self::Answer(tolerance) | Self::Value(tolerance) | Self::Lanes(tolerance) | Self::SingleLanes(tolerance) => tolerance,
            Self::Digits(_) => 0.0,
        }
    }
}

/// Rounds the receiver to single precision; whether it still is one.
#[allow(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
pub(crate) fn round_to_single(problem: &mut Problem) -> bool {
    let round = |v: DVec3| DVec3::from_array(v.to_array().map(|c| f64::from(c as f32)));
    let receiver = Receiver::new(
        round(problem.receiver.position()),
        round(problem.receiver.direction()),
        f64::from(problem.receiver.reflectance() as f32).min(1.0),
    );
    receiver.map(|receiver| problem.receiver = receiver).is_ok()
}

impl Asked {
    fn hold(&mut self, ask: Query, problem: &Problem, by: Option<AnswerMethod>, answer: &Answer) {
        let is_value = matches!(ask, Query::Value(_));
        let numbers = answer.radiosity.is_finite() && answer.gradient.is_finite() && !answer.radiosity_error.is_nan();
        if !numbers || (!is_value && answer.gradient_error.is_nan()) {
            self.faults.push(format!("{ask}: not a number in {answer:?}"));
            return;
        }
        if let Query::Answer(tolerance) = ask
            && by != Some(AnswerMethod::OnSurface)
            && problem.emitter.polygon().vertices().len() == 3
            && problem.occluders.is_empty()
            && !answer.meets(tolerance)
            && tolerance >= 1e-15
        {
            self.faults.push(format!("{ask}: the bounds are above the tolerance: {answer:?}"));
        }
        let Ok(truth) = digits::enclosure(problem, DIGITS) else {
            self.hold_other_names(ask, problem, answer);
            return;
        };
        let (value, gradient) = truth.errors_at_least(answer.radiosity, answer.gradient);
        let Some(by) = by else {
            if value > 0.0 || (!is_value && gradient > 0.0) {
                self.faults.push(format!("{ask}: exactly 0, where the truth is {:e}", truth.radiosity.to_f64()));
            }
            return;
        };
        self.add(problem, by, Quantity::Value, answer.radiosity_error, value);
        if !is_value {
            self.add(problem, by, Quantity::Gradient, answer.gradient_error, gradient);
        }
    }

    fn add(&mut self, problem: &Problem, by: AnswerMethod, quantity: Quantity, bound: f64, error: f64) {
        let emission = match problem.emitter.emission() {
            Emission::Constant(_) => EmissionKind::Constant,
            Emission::Linear(_) => EmissionKind::Linear,
            Emission::Polynomial(_) => EmissionKind::Polynomial,
        };
        let place = Place { by, emission, sight: Sight::classify(problem), quantity };
        self.held.push(Held { place, bound, ratio: ratio(error, bound) });
    }

    /// On the surface of an emitter that is not flat there is no one truth. But the answers must not contradict each other, by
    /// whichever vertex it is named first.
    fn hold_other_names(&mut self, ask: Query, problem: &Problem, answer: &Answer) {
        let Query::Answer(tolerance) = ask else { return };
        let (polygon, Emission::Constant(_)) = (problem.emitter.polygon(), problem.emitter.emission()) else { return };
        let count = polygon.vertices().len();
        for first in 1..count {
            let mut vertices = polygon.vertices().to_vec();
            vertices.rotate_left(first);
            let other = Polygon::from_rounded(vertices, polygon.precision())
                .and_then(|polygon| Emitter::new(polygon, problem.emitter.emission().clone()));
            let Ok(other) = other.and_then(|emitter| evaluate_to(&problem.receiver, &emitter, &problem.occluders, tolerance))
            else {
                continue;
            };
            let apart = [(answer.radiosity - other.radiosity).abs(), norm_above(answer.gradient - other.gradient)];
            let bounds = [answer.radiosity_error + other.radiosity_error, answer.gradient_error + other.gradient_error];
            let by = AnswerMethod::from_method(answer.method)
                .or(AnswerMethod::from_method(other.method))
                .unwrap_or(AnswerMethod::OnSurface);
            for (quantity, (apart, bound)) in [Quantity::Value, Quantity::Gradient].into_iter().zip(apart.into_iter().zip(bounds))
            {
                let error = if apart > bound * (1.0 + 8.0 * f64::EPSILON) { apart } else { apart * (1.0 - 16.0 * f64::EPSILON) };
                self.add(problem, by, quantity, bound, error);
            }
        }
    }

    fn hold_digits(&mut self, problem: &Problem, count: u32) {
        let [few, more] = match [count, count + 20].map(|digits| digits::enclosure(problem, digits)) {
            [Ok(few), Ok(more)] => [few, more],
            _ => return,
        };
        let pairs = |a: &Truth, b: &Truth| {
            let gradient = a.gradient.iter().zip(&b.gradient).map(|(a, b)| a.share_apart(b)).fold(0.0, worse);
            [a.radiosity.share_apart(&b.radiosity), gradient]
        };
        let [value, gradient] = pairs(&few, &more);
        self.add(problem, AnswerMethod::Digits, Quantity::Value, 1.0, value);
        self.add(problem, AnswerMethod::Digits, Quantity::Gradient, 1.0, gradient);
    }
}

/// How many bounds an answer on the surface is at most from the answer by another vertex named first; 0 of no answer.
pub(crate) fn apart_from_other_names(ask: Query, problem: &Problem) -> f64 {
    let Ok(Some((_, answer))) = ask.answer(problem) else { return 0.0 };
    let mut asked = Asked::default();
    asked.hold_other_names(ask, problem, &answer);
    asked.held.iter().map(|held| held.ratio).fold(0.0, |worst, ratio| if ratio <= worst { worst } else { ratio })
}

/// Why witnesses cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be read.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A line is no witness.
    #[error("{path}:{line}: {source}", path = path.display())]
    Line {
        /// Of which file.
        path: PathBuf,
        /// Its number, from 1.
        line: usize,
        /// Why.
        source: serde_json::Error,
    },
}

/// All witnesses of the files `*.jsonl` in a folder, by file name.
///
/// # Errors
/// If the folder or a file cannot be read, or a line is no witness.
pub fn read_all(folder: &Path) -> Result<Vec<Witness>, Error> {
    lines(folder)
}

/// The values that the lines of the files `*.jsonl` in a folder hold, by file name.
pub(crate) fn lines<T: serde::de::DeserializeOwned>(folder: &Path) -> Result<Vec<T>, Error> {
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        move |source| Error::File { path, source }
    };
    let entries = fs::read_dir(folder).map_err(failed(folder))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>().map_err(failed(folder))?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "jsonl"));
    paths.sort();
    let mut values = Vec::new();
    for path in paths {
        let text = fs::read_to_string(&path).map_err(failed(&path))?;
        for (line, text) in text.lines().enumerate().filter(|(_, text)| !text.is_empty()) {
            let read = serde_json::from_str(text);
            values.push(read.map_err(|source| Error::Line { path: path.clone(), line: line + 1, source })?);
        }
    }
    Ok(values)
}

impl Witness {
    /// Its deviations today: a bound that is broken, a fault whatever the bounds, or a bound that is not
    /// the recorded one, which takes a new derivation and a new record.
    #[must_use]
    pub fn wrong(&self) -> Vec<Wrong> {
        let asked = self.ask.check(&self.case);
        let broken = asked.held.iter().filter(|held| held.ratio > 1.0);
        let mut wrong: Vec<Wrong> = broken
            .map(|held| Wrong {
                by_record: false,
                what: format!(
                    "{}, {}: the bound {:e} is broken, by a factor of {:.3} at least",
                    self.ask, held.place, held.bound, held.ratio
                ),
            })
            .chain(asked.faults.iter().map(|fault| Wrong { by_record: false, what: fault.clone() }))
            .collect();
        let same = asked.held.iter().find(|held| held.place == self.place);
        if let Some(held) = same
            && !(SMALLER * self.bound..=self.bound / SMALLER).contains(&held.bound)
        {
            let what = format!("{}, {}: the bound is {:e}, it was {:e}", self.ask, self.place, held.bound, self.bound);
            wrong.push(Wrong { by_record: true, what });
        }
        wrong
    }
}

/// A bound below this share of the recorded one, or above it by as much, is not the same bound.
const SMALLER: f64 = 0.98;

/// Something wrong with a witness.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Whether the record alone tells: truth does not.
    pub by_record: bool,
    /// Message for people.
    pub what: String,
}

impl fmt::Display for Query {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Answer(_) => "answer",
            Self::Value(_) => "value",
            Self::Lanes(_) => "lanes",
            Self::SingleLanes(_) => "single-lanes",
            Self::Digits(digits) => return write!(f, "digits {digits}"),
        };
        write!(f, "{name} {:e}", self.tolerance())
    }
}

/// A text that is no way to ask.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no way to ask a case: answer, value, lanes or single-lanes and a tolerance, or digits and how many")]
pub struct BadAsk(String);

impl FromStr for Query {
    type Err = BadAsk;

    fn from_str(text: &str) -> Result<Self, BadAsk> {
        let bad = || BadAsk(text.to_owned());
        let (name, number) = text.split_once(' ').ok_or_else(bad)?;
        let tolerance = || number.parse::<f64>().ok().filter(|t| (0.0..=1.0).contains(t)).ok_or_else(bad);
        match name {
            "answer" => Ok(Self::Answer(tolerance()?)),
            "value" => Ok(Self::Value(tolerance()?)),
            "lanes" => Ok(Self::Lanes(tolerance()?)),
            "single-lanes" => Ok(Self::SingleLanes(tolerance()?)),
            "digits" => Ok(Self::Digits(number.parse().map_err(|_| bad())?)),
            _ => Err(bad()),
        }
    }
}

impl From<Query> for String {
    fn from(ask: Query) -> Self {
        ask.to_string()
    }
}

impl TryFrom<String> for Query {
    type Error = BadAsk;

    fn try_from(text: String) -> Result<Self, BadAsk> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;

    #[test]
    fn ways_to_ask_read_back_from_their_names() {
        for ask in [Query::Answer(1e-12), Query::Value(0.0), Query::Lanes(1.0), Query::SingleLanes(1e-3), Query::Digits(50)] {
            assert_eq!(ask.to_string().parse(), Ok(ask));
        }
        assert!("answer 2".parse::<Query>().is_err() && "oracle 1".parse::<Query>().is_err());
    }

    #[test]
    fn every_way_to_ask_holds_value_and_gradient() {
        let constant = (0..)
            .map(|index| Family::Generic.case(1, index))
            .find(|case| matches!(case.emitter.emission, radgrad_scene::case::EmissionRecord::Constant { .. }));
        let case = constant.expect("a third of them");
        for (ask, count) in [(Query::Answer(1.0), 2), (Query::Answer(0.0), 2), (Query::Value(1.0), 1), (Query::Digits(30), 2)] {
            let asked = ask.check(&case);
            assert_eq!((asked.held.len(), &asked.faults[..]), (count, &[][..]), "{ask}");
            assert!(asked.held.iter().all(|held| held.ratio <= 1.0 && held.bound > 0.0), "{ask}: {asked:?}");
        }
        // Another way may answer in the place of lanes.
        for ask in [Query::Lanes(1.0), Query::SingleLanes(1.0)] {
            let asked = ask.check(&case);
            assert!(asked.held.iter().all(|held| held.ratio <= 1.0 && held.bound > 0.0), "{ask}: {asked:?}");
            assert_eq!(asked.faults, Vec::<String>::new(), "{ask}");
        }
    }

    #[test]
    fn a_bound_that_shrank_and_one_that_is_broken_are_told_apart() {
        let case = Family::Generic.case(1, 3);
        let held = Query::Answer(1.0).check(&case).held[0];
        let witness =
            |bound: f64| Witness { place: held.place, ask: Query::Answer(1.0), ratio: held.ratio, bound, case: case.clone() };
        assert_eq!(witness(held.bound).wrong(), []);
        let wrong = witness(1.1 * held.bound).wrong();
        assert!(wrong.len() == 1 && wrong[0].by_record, "{wrong:?}");
    }
}
