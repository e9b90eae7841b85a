//! Recorded values and bounds of cases and scenes (regression baseline), kept in `data/record/*.jsonl`: many bounds are so far
//! above every error that no truth tells when one of them becomes a tenth of its former size, or loses a term. The record does.
//!
//! Asked again, a value that has no point in common with the recorded one, or an answer that truth contradicts, is wrong. A bound
//! that changed by more than [`ROUNDINGS`], or a value that moved beyond rounding ([`Statement::has_moved`]), takes a reason and
//! a new record (`cargo run -p radgrad-audit --example bite -- record FILE`): a bound that grew is no longer the derived one
//! either.

mod digest;
mod part;
mod statement;

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::DVec3;
use radgrad_core::batch::{Answers, EmitterTree, Engine, Receivers};
use radgrad_core::{Emission, Emitter, Polygon, evaluate_digits, evaluate_to, hessian_to, irradiance_vector_to};
use radgrad_oracle::cubature::{self, Form};
use radgrad_oracle::monte_carlo::{self, Sampling, Sequence};
use radgrad_oracle::{Arithmetic, Error as OracleError, Request, Source, SourceFunction, enclose_source_occluded};
use radgrad_scene::case::{Case, Problem};
use serde::{Deserialize, Serialize};

pub use self::digest::Block;
pub use self::part::Part;
pub use self::statement::{Asked, MOVED, ROUNDINGS, Recorded, Statement};
use crate::bounds::digits;
use crate::bounds::witness::{self, Error, Query, Wrong};
use crate::cases::sampler::Sampler;
use crate::measures::measure::worse;
use crate::measures::seen::reduced;
use crate::measures::truth::Truth;
use crate::scenes;
use crate::scenes::statement::Subject;

/// Evaluations that the oracle may spend on a case.
const BUDGET: u64 = 1_000_000;

/// Digits that the oracle's enclosures are held against.
const DIGITS: u32 = 60;

/// The subject of a record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum RecordedSubject {
    /// Of a case, an answer of core.
    Answer(Query),
    /// Of a case, its second derivatives to a tolerance.
    Hessian(f64),
    /// Of a case, the irradiance vector to a tolerance.
    Irradiance(f64),
    /// Of a case, the oracle's enclosure in an arithmetic, to so many digits.
    Oracle(Arithmetic, u32),
    /// Of a case without occluders, cubature of each form to a tolerance.
    Cubature(f64),
    /// Of a case, so many samples.
    Samples(u32),
    /// Of a scene, walks of so many rays: the reference of the solver.
    Walks(u32, scenes::family::Name),
    /// A bent sheet of lamps by a tree, from the receiver of this number.
    Tree(u64),
    /// A scene.
    Scene(Subject, scenes::family::Name),
    /// All numbers of the solution of a scene, in one way or another.
    Whole(scenes::family::Name),
    /// A drawn case of a part of factors.
    Part(Part, u64),
    /// All bits of a block of answers.
    Digest(Block, u64),
}

/// A subject with its recorded statements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The subject.
    pub of: RecordedSubject,
    /// The case, where it was one of a case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub case: Option<Case>,
    /// The recorded statements.
    pub said: Vec<Statement>,
}

impl Record {
    /// A record of today.
    ///
    /// # Errors
    /// If truth contradicts a statement, or it cannot be recorded: no answer, or a number that is not finite.
    pub fn new(of: RecordedSubject, case: Option<Case>) -> Result<Self, String> {
        let Recorded { statements, wrong } = of.asked(case.as_ref())?;
        if let Some(wrong) = wrong.first() {
            return Err(wrong.clone());
        }
        let numbers = |s: &Statement| s.bound.is_finite() && s.value.iter().all(|v| v.is_finite());
        if statements.is_empty() || !statements.iter().all(numbers) {
            return Err("there is nothing to record, or what is no number".to_owned());
        }
        Ok(Self { of, case, said: statements })
    }

    /// The deviations from it today.
    #[must_use]
    pub fn wrong(&self) -> Vec<Wrong> {
        let truth = |what: String| Wrong { by_record: false, what: format!("{}: {what}", self.of) };
        let Recorded { statements, wrong } = match self.of.asked(self.case.as_ref()) {
            Ok(said) => said,
            Err(why) => return vec![truth(why)],
        };
        let mut faults: Vec<Wrong> = wrong.into_iter().map(truth).collect();
        if statements.len() != self.said.len() {
            faults.push(Wrong {
                by_record: true,
                what: format!("{}: {} statements, there were {}", self.of, statements.len(), self.said.len()),
            });
        }
        for (now, then) in statements.iter().zip(&self.said) {
            // A NaN compares as apart.
            let apart = now.apart(then);
            if now.bound.is_nan() || now.bound < 0.0 {
                faults.push(truth(format!("the bound is {:e}", now.bound)));
            } else if apart > 1.0 || apart.is_nan() {
                let what =
                    format!("{}: {:?} +- {:e}, it was {:?} +- {:e}", self.of, now.value, now.bound, then.value, then.bound);
                faults.push(Wrong { by_record: self.of.only_estimates(), what });
            } else if (now.bound - then.bound).abs() > ROUNDINGS * then.bound {
                let what = format!("{}: the bound is {:e}, it was {:e}", self.of, now.bound, then.bound);
                faults.push(Wrong { by_record: true, what });
            } else if now.has_moved(then) {
                let what = format!("{}: {:?} moved from {:?}, by {apart:e} of the bounds", self.of, now.value, then.value);
                faults.push(Wrong { by_record: true, what });
            }
        }
        faults
    }
}

impl RecordedSubject {
    /// Who is asked.
    #[must_use]
    pub const fn asks(self) -> Asked {
        match self {
            Self::Oracle(..) | Self::Cubature(_) | Self::Samples(_) | Self::Walks(..) => Asked::Oracle,
            Self::Scene(Subject::Solve | Subject::Certificate, _) | Self::Whole(_) => Asked::Solver,
            Self::Scene(..) | Self::Part(..) => Asked::Scenes,
            Self::Digest(block, _) => block.asks(),
            _ => Asked::Core,
        }
    }

    /// Whether its statements of an error are no bound, and nothing is wrong with two values that are far apart.
    const fn only_estimates(self) -> bool {
        matches!(self, Self::Cubature(_) | Self::Scene(Subject::Solve, _) | Self::Whole(_))
    }

    /// Asks.
    ///
    /// # Errors
    /// If there is no answer: why.
    pub fn asked(self, case: Option<&Case>) -> Result<Recorded, String> {
        match (self, case) {
            (Self::Tree(index), None) => of_tree(index),
            (Self::Scene(subject, name), None) => of_scene(subject, name),
            (Self::Part(part, index), None) => part.asked(index),
            (Self::Digest(block, index), None) => block.asked(index),
            (Self::Walks(rays, name), None) => of_walks(rays, name),
            (Self::Whole(name), None) => Ok(Recorded::of_pairs(&scenes::alike::recorded(name)?)),
            (Self::Tree(_) | Self::Scene(..) | Self::Walks(..) | Self::Whole(_) | Self::Part(..) | Self::Digest(..), Some(_)) => {
                Err(format!("{self} has no case"))
            }
            (_, None) => Err(format!("{self} of no case")),
            (_, Some(case)) => {
                let problem = case.problem().map_err(|error| error.to_string())?;
                match self {
                    Self::Answer(ask) => of_answer(ask, problem),
                    Self::Hessian(tolerance) => of_hessian(tolerance, &problem),
                    Self::Irradiance(tolerance) => of_irradiance(tolerance, &problem),
                    Self::Oracle(arithmetic, digits) => of_oracle(arithmetic, digits, &problem),
                    Self::Cubature(tolerance) => of_cubature(tolerance, &problem),
                    Self::Samples(count) => of_samples(count, &problem),
                    _ => Err(format!("{self} of a case")),
                }
            }
        }
    }
}

fn of_answer(ask: Query, mut problem: Problem) -> Result<Recorded, String> {
    if matches!(ask, Query::SingleLanes(_)) && !witness::round_to_single(&mut problem) {
        return Ok(Recorded::default());
    }
    if let Query::Digits(digits) = ask {
        let Problem { receiver, emitter, occluders, .. } = &problem;
        let answer = evaluate_digits(receiver, emitter, occluders, digits).map_err(|error| error.to_string())?;
        let number = |text: &str| text.parse::<f64>().map_err(|error| format!("{text}: {error}"));
        let bounds = [number(&answer.radiosity_error)?, number(&answer.gradient_error)?];
        return Ok(Recorded { statements: bounds.map(|bound| Statement::new(&[], bound)).to_vec(), wrong: Vec::new() });
    }
    let Some((_, answer)) = ask.answer(&problem).map_err(|error| error.to_string())? else { return Ok(Recorded::default()) };
    let mut statements = vec![Statement::new(&[answer.radiosity], answer.radiosity_error)];
    if !matches!(ask, Query::Value(_)) {
        statements.push(Statement::new(&answer.gradient.to_array(), answer.gradient_error));
    }
    if let Query::Answer(tolerance) = ask {
        // A tolerance that was met is to be met.
        statements.push(Statement::new(&[], f64::from(u8::from(answer.meets(tolerance)))));
    }
    Ok(Recorded { statements, wrong: Vec::new() })
}

/// The answer to a tolerance of 0 is the truth of a larger one.
fn against(rough: Statement, fine: &Statement) -> Recorded {
    let apart = rough.apart(fine);
    let wrong = if apart > 1.0 || apart.is_nan() {
        vec![format!("off by {apart} times the bounds, which are {:e} and {:e}", rough.bound, fine.bound)]
    } else {
        Vec::new()
    };
    Recorded { statements: vec![rough], wrong }
}

fn of_hessian(tolerance: f64, problem: &Problem) -> Result<Recorded, String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let hessian_at = |tolerance: f64| {
        let hessian = hessian_to(receiver, emitter, occluders, tolerance).map_err(|error| error.to_string())?;
        Ok::<_, String>(Statement::new(&hessian.matrix.to_cols_array(), hessian.error))
    };
    Ok(against(hessian_at(tolerance)?, &hessian_at(0.0)?))
}

fn of_irradiance(tolerance: f64, problem: &Problem) -> Result<Recorded, String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let vector_at = |tolerance: f64| {
        let vector = irradiance_vector_to(receiver, emitter, occluders, tolerance).map_err(|error| error.to_string())?;
        Ok::<_, String>(Statement::new(&vector.vector.to_array(), vector.error))
    };
    Ok(against(vector_at(tolerance)?, &vector_at(0.0)?))
}

fn of_oracle(arithmetic: Arithmetic, digits: u32, problem: &Problem) -> Result<Recorded, String> {
    let (emitter, occluders) = reduced(problem);
    let request = Request { digits, arithmetic: Some(arithmetic), budget: BUDGET };
    let figures = |figures: &[f64]| figures.iter().map(|&bound| Statement::new(&[], bound)).collect();
    let enclosure = match enclose_source_occluded(&problem.receiver, &Source::Emitter(&emitter), occluders, &request) {
        Ok(enclosure) => enclosure,
        // Rounding is then all of the radii.
        Err(OracleError::Rounding { reached, .. }) => {
            let statements = figures(&[reached.radiosity_radius, reached.gradient_radius]);
            return Ok(Recorded { statements, wrong: Vec::new() });
        }
        Err(error) => return Err(error.to_string()),
    };
    let slope = enclosure.gradient.iter().map(radgrad_oracle::Interval::radius).fold(0.0, worse);
    let [value, gradient] = enclosure.rounding;
    #[allow(clippy::cast_precision_loss, reason = "at most the budget")]
    let evaluations = enclosure.evaluations as f64;
    let statements = figures(&[enclosure.radiosity.radius(), slope, value, gradient, evaluations]);
    let truth = Truth { radiosity: enclosure.radiosity, gradient: enclosure.gradient };
    let precise = digits::enclosure(problem, DIGITS)?;
    let wrong =
        if truth.overlaps(&precise) { Vec::new() } else { vec![format!("it and core's {DIGITS} digits have nothing in common")] };
    Ok(Recorded { statements, wrong })
}

/// Evaluations of a form of cubature.
const CUBATURE: usize = 200_000;

fn of_cubature(tolerance: f64, problem: &Problem) -> Result<Recorded, String> {
    let emitter = &problem.emitter;
    let mut statements = Vec::new();
    for form in [Form::Surface, Form::Contour, Form::Boundary] {
        let source = SourceFunction::Emitter(emitter);
        let integral = cubature::integrate_form(&problem.receiver, emitter.polygon(), source, form, tolerance, CUBATURE);
        let integral = integral.map_err(|error| error.to_string())?;
        statements.push(Statement::new(&[integral.radiosity], integral.radiosity_error));
        statements.push(Statement::new(&integral.gradient.to_array(), integral.gradient_error));
        statements.push(Statement::new(&[], integral.evaluations as f64));
    }
    Ok(Recorded { statements, wrong: Vec::new() })
}

/// That limits of samples hold.
const CONFIDENCE: f64 = 1.0 - 1e-7;

/// By each way to draw points, of which more digits lie within the limits.
fn of_samples(count: u32, problem: &Problem) -> Result<Recorded, String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let truth = digits::enclosure(problem, DIGITS)?.radiosity;
    let sequences = [
        Sequence::Independent { samples: count as usize, seed: 1 },
        Sequence::Sobol { samples: count / 16, scramblings: 16, seed: 1 },
    ];
    let mut said = Recorded::default();
    for (sampling, sequence) in [Sampling::SolidAngle, Sampling::Area].into_iter().zip(sequences) {
        let sampled = monte_carlo::integrate(receiver, emitter, occluders, sampling, sequence, CONFIDENCE);
        let sampled = sampled.map_err(|error| error.to_string())?;
        for limits in std::iter::once(sampled.radiosity).chain(sampled.gradient) {
            let widths = [limits.student, limits.distribution_free].map(|interval| 0.5 * interval.width());
            said.statements.extend(widths.map(|width| Statement::new(&[limits.mean], width)));
        }
        let free = sampled.radiosity.distribution_free;
        let (low, high) = truth.bounds();
        if low > free.high || high < free.low {
            said.wrong.push(format!("sampled {:e} to {:e}, it is {low:e} to {high:e}", free.low, free.high));
        }
    }
    Ok(said)
}

/// Of a mean and of points with their limits.
fn of_walks(rays: u32, name: scenes::family::Name) -> Result<Recorded, String> {
    Ok(Recorded::of_pairs(&scenes::truth::recorded(&name.model(), rays)?))
}

/// Cells along a side of the sheet of lamps.
const SIDE: usize = 16;

/// A bent sheet of lamps.
///
/// # Errors
/// If one is refused.
pub(crate) fn sheet() -> Result<Vec<Emitter>, String> {
    let place = |i: usize, j: usize| {
        let (u, v) = (i as f64 / SIDE as f64 - 0.5, j as f64 / SIDE as f64 - 0.5);
        DVec3::new(u, v * 0.7, 0.3 * u - 0.3 * (u * u + v * v) + 4.0)
    };
    let cells = (0..SIDE * SIDE).map(|cell| (cell / SIDE, cell % SIDE));
    let lamps = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)];
        [[a, b, c], [a, c, d]].map(|corners| Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0 + i as f64)))
    });
    lamps.collect::<Result<_, _>>().map_err(|error| error.to_string())
}

/// From farther and farther below, to any tolerance.
fn of_tree(index: u64) -> Result<Recorded, String> {
    let lamps = sheet()?;
    let sampler = &mut Sampler::new(3, "trees", index);
    let x = sampler.cube() * DVec3::new(1.0, 1.0, 0.5) + DVec3::new(0.0, 0.0, 3.2 - 0.35 * index as f64);
    let n1 = DVec3::Z + sampler.cube() * 0.3;
    let tolerance = sampler.spread(-40, -3);
    let (x1, n) = (x.to_array().map(|c| [c]), n1.to_array().map(|c| [c]));
    let said = |error: radgrad_core::Error| error.to_string();
    let receivers = Receivers::new([&x1[0], &x1[1], &x1[2]], [&n[0], &n[1], &n[2]], &[1.0]).map_err(said)?;
    let mut answers = Answers::new();
    Engine::new().total(&receivers, &EmitterTree::new(&lamps), tolerance, &mut answers).map_err(said)?;
    let receiver = radgrad_core::Receiver::new(x, n1, 1.0).map_err(said)?;
    let (mut sum, mut error) = (0.0, 0.0);
    for lamp in &lamps {
        let answer = evaluate_to(&receiver, lamp, &[], 1e-14).map_err(said)?;
        (sum, error) = (sum + answer.radiosity, error + answer.radiosity_error);
    }
    let total = Statement::new(&[answers.radiosity[0]], answers.radiosity_error[0]);
    Ok(against(total, &Statement::new(&[sum], error + 1e-13 * sum)))
}

fn of_scene(subject: Subject, name: scenes::family::Name) -> Result<Recorded, String> {
    Ok(Recorded::of_pairs(&scenes::statement::recorded(&name.model(), subject)?))
}

/// All records of the files `*.jsonl` in a folder, by file name.
///
/// # Errors
/// If the folder or a file cannot be read, or a line is no record.
pub fn read_all(folder: &Path) -> Result<Vec<Record>, Error> {
    witness::lines(folder)
}

impl fmt::Display for RecordedSubject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Answer(ask) => write!(f, "{ask}"),
            Self::Hessian(tolerance) => write!(f, "hessian {tolerance:e}"),
            Self::Irradiance(tolerance) => write!(f, "irradiance {tolerance:e}"),
            Self::Oracle(arithmetic, digits) => {
                let name = ARITHMETICS.iter().find(|(_, known)| known == arithmetic).map_or("other", |(name, _)| name);
                write!(f, "oracle {name} {digits}")
            }
            Self::Cubature(tolerance) => write!(f, "cubature {tolerance:e}"),
            Self::Samples(count) => write!(f, "samples {count}"),
            Self::Walks(rays, name) => write!(f, "walks {rays} {name}"),
            Self::Tree(index) => write!(f, "tree {index}"),
            Self::Scene(subject, name) => write!(f, "{} {name}", subject.name()),
            Self::Whole(name) => write!(f, "whole {name}"),
            Self::Part(part, index) => write!(f, "{} {index}", part.name()),
            Self::Digest(block, index) => write!(f, "digest {} {index}", block.name()),
        }
    }
}

/// Arithmetics that enclosures are recorded in.
const ARITHMETICS: [(&str, Arithmetic); 3] =
    [("double-double", Arithmetic::DoubleDouble), ("limbs", Arithmetic::Limbs), ("astro", Arithmetic::Astro)];

/// A text that names nothing to ask.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is nothing to ask: answer 1e-12, hessian 1e-10, irradiance 1e0, oracle limbs 20, tree 3, factors facing:1:0, ...")]
pub struct BadOf(String);

impl FromStr for RecordedSubject {
    type Err = BadOf;

    fn from_str(text: &str) -> Result<Self, BadOf> {
        let bad = || BadOf(text.to_owned());
        if let Ok(ask) = text.parse() {
            return Ok(Self::Answer(ask));
        }
        let (what, rest) = text.split_once(' ').ok_or_else(bad)?;
        let tolerance = || rest.parse::<f64>().ok().filter(|t| (0.0..=1.0).contains(t)).ok_or_else(bad);
        match what {
            "hessian" => Ok(Self::Hessian(tolerance()?)),
            "irradiance" => Ok(Self::Irradiance(tolerance()?)),
            "cubature" => Ok(Self::Cubature(tolerance()?)),
            "samples" => Ok(Self::Samples(rest.parse().map_err(|_| bad())?)),
            "walks" => {
                let (rays, name) = rest.split_once(' ').ok_or_else(bad)?;
                Ok(Self::Walks(rays.parse().map_err(|_| bad())?, name.parse().map_err(|_| bad())?))
            }
            "whole" => Ok(Self::Whole(rest.parse().map_err(|_| bad())?)),
            "tree" => Ok(Self::Tree(rest.parse().map_err(|_| bad())?)),
            _ if let Some((_, part)) = Part::ALL.iter().find(|(name, _)| *name == what) => {
                Ok(Self::Part(*part, rest.parse().map_err(|_| bad())?))
            }
            "digest" => {
                let (name, index) = rest.split_once(' ').ok_or_else(bad)?;
                let (_, block) = Block::ALL.iter().find(|(known, _)| *known == name).ok_or_else(bad)?;
                Ok(Self::Digest(*block, index.parse().map_err(|_| bad())?))
            }
            "oracle" => {
                let (name, digits) = rest.split_once(' ').ok_or_else(bad)?;
                let (_, arithmetic) = ARITHMETICS.iter().find(|(known, _)| *known == name).ok_or_else(bad)?;
                Ok(Self::Oracle(*arithmetic, digits.parse().map_err(|_| bad())?))
            }
            _ => {
                let subject = Subject::ALL.into_iter().find(|subject| subject.name() == what);
                Ok(Self::Scene(subject.ok_or_else(bad)?, rest.parse().map_err(|_| bad())?))
            }
        }
    }
}

impl From<RecordedSubject> for String {
    fn from(of: RecordedSubject) -> Self {
        of.to_string()
    }
}

impl TryFrom<String> for RecordedSubject {
    type Error = BadOf;

    fn try_from(text: String) -> Result<Self, BadOf> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;

    #[test]
    fn what_is_asked_reads_back_from_its_name() {
        let scene = RecordedSubject::Scene(Subject::Factors, "facing:1:0".parse().unwrap());
        let walks = RecordedSubject::Walks(1000, "facing:1:0".parse().unwrap());
        let asked = [
            RecordedSubject::Hessian(1e-10),
            RecordedSubject::Irradiance(1.0),
            RecordedSubject::Oracle(Arithmetic::Limbs, 36),
            RecordedSubject::Tree(3),
            scene,
            walks,
            RecordedSubject::Whole("slit:1:1".parse().unwrap()),
        ];
        for of in asked.into_iter().chain([
            RecordedSubject::Answer(Query::Value(1.0)),
            RecordedSubject::Cubature(1e-6),
            RecordedSubject::Samples(64),
            RecordedSubject::Part(Part::Share, 3),
            RecordedSubject::Digest(Block::Batches, 3),
        ]) {
            assert_eq!(of.to_string().parse(), Ok(of));
        }
        assert!("oracle mpfr 20".parse::<RecordedSubject>().is_err() && "hessian 2".parse::<RecordedSubject>().is_err());
    }

    #[test]
    fn a_bound_that_shrank_a_value_that_moved_and_one_that_is_another_are_told_apart() {
        let record = Record::new(RecordedSubject::Answer(Query::Answer(1.0)), Some(Family::Generic.case(1, 3))).unwrap();
        assert_eq!(record.wrong(), []);
        let wrong = |change: fn(&mut Statement)| {
            let mut changed = record.clone();
            change(&mut changed.said[0]);
            changed.wrong().iter().map(|wrong| wrong.by_record).collect::<Vec<_>>()
        };
        assert_eq!(wrong(|said| said.bound *= 1.0 + 1e-5), [true]);
        assert_eq!(wrong(|said| said.bound *= 1.0 - 1e-5), [true]);
        assert_eq!(wrong(|said| said.value[0] += 0.5 * said.bound), [true]);
        assert_eq!(wrong(|said| said.value[0] += 3.0 * said.bound), [false]);
        assert_eq!(wrong(|said| said.value[0] = f64::NAN), [false]);
    }

    #[test]
    fn second_derivatives_the_irradiance_vector_and_enclosures_agree_with_more_digits() {
        let case = Family::Generic.case(2, 0);
        for of in [
            RecordedSubject::Hessian(1.0),
            RecordedSubject::Irradiance(1.0),
            RecordedSubject::Oracle(Arithmetic::DoubleDouble, 20),
        ] {
            let said = of.asked(Some(&case)).unwrap();
            assert!(said.wrong.is_empty() && !said.statements.is_empty(), "{of}: {said:?}");
        }
        assert!(RecordedSubject::Tree(0).asked(Some(&case)).is_err() && RecordedSubject::Hessian(1.0).asked(None).is_err());
    }
}
