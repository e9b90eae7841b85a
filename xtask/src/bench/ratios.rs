//! `cargo xtask bench --ratios`: the claims on speed, as ratios of times in one run. Samples of the two sides alternate, and a
//! ratio is the median over pairs of neighbours, so that a busy machine gives the same figures as an idle one.
//!
//! Scalar work is the public interface on 64 triangles of different shape, seen whole from different places.

mod gates;
mod lanes;
mod pair;
mod varied;

use std::error::Error;
use std::fs;
use std::hint::black_box;

use radgrad_core::batch::{Answers, Engine};
use radgrad_core::{DVec3, derivatives, evaluate_to, radiosity, radiosity_and_gradient};
use radgrad_oracle::cubature::{Status, integrate};

use super::lambert;
use super::lanes::Columns;
use super::output::Output;
use super::regime::{Case, Kind, Regime};
use super::truth::Truths;
use crate::files::in_workspace;
use gates::Gates;
use lanes::BATCH;
use pair::{Ratio, pair, pair_of_long};

/// Prints the ratios and, last, one JSON object of their medians. Whether all are within their gates.
pub(crate) fn run() -> Result<bool, Box<dyn Error>> {
    let gates = Gates::from_toml(&fs::read_to_string(in_workspace("data/speed.toml"))?)?;
    let ratios = measured()?;
    println!("{}", gates.table(&ratios));
    let violations = gates.violations(&ratios);
    for violation in &violations {
        println!("VIOLATED {violation}");
    }
    let medians = ratios.iter().map(|ratio| (ratio.name.to_owned(), rounded(ratio.spread.median).into()));
    println!("{}", serde_json::Value::Object(medians.collect()));
    Ok(violations.is_empty())
}

fn measured() -> Result<Vec<Ratio>, Box<dyn Error>> {
    let [constant, linear] = [varied::cases(Kind::Constant)?, varied::cases(Kind::Linear)?];
    let easy = Regime::Easy.cases(Kind::Constant)?;
    let near: Vec<Case> = Regime::Near2.cases(Kind::Constant)?.into_iter().filter(is_under_the_emitter).collect();
    let value = |case: &Case| black_box(radiosity(&case.receiver, &case.emitter).unwrap_or(f64::NAN));
    let bare = |case: &Case| black_box(lambert::radiosity(case));
    let mut ratios = vec![
        ratio("value_over_lambert", &constant, value, &constant, bare),
        ratio("value_gradient_over_value", &constant, both, &constant, value),
        ratio("linear_over_constant", &linear, both, &constant, both),
        ratio("derivatives_over_value_gradient", &constant, differentiated, &constant, bounded),
    ];
    for (names, cases, tolerance) in [
        (["faster_than_cubature_easy_1e6", "one_faster_than_cubature_easy_1e6"], &easy, 1e-6),
        (["faster_than_cubature_easy_1e10", "one_faster_than_cubature_easy_1e10"], &easy, 1e-10),
        (["faster_than_cubature_near_1e6", "one_faster_than_cubature_near_1e6"], &near, 1e-6),
    ] {
        ratios.extend(over_cubature(names, cases, tolerance)?);
    }
    ratios.extend(lanes::speedups()?);
    ratios.extend(lanes::linear_speedups()?);
    ratios.push(lanes::many_emitters()?);
    Ok(ratios)
}

/// Value and gradient as a user asks for them.
fn both(case: &Case) -> f64 {
    black_box(radiosity_and_gradient(&case.receiver, &case.emitter)).map_or(f64::NAN, |(value, _)| value)
}

/// The tolerance to which derivatives are set beside value and gradient.
const TOLERANCE: f64 = 1e-10;

/// Value and gradient with their bounds.
fn bounded(case: &Case) -> f64 {
    black_box(evaluate_to(&case.receiver, &case.emitter, [], TOLERANCE)).map_or(f64::NAN, |answer| answer.radiosity)
}

/// The same with the derivatives by vertices, emission, normal and reflectance.
fn differentiated(case: &Case) -> f64 {
    black_box(derivatives(&case.receiver, &case.emitter, [], TOLERANCE)).map_or(f64::NAN, |found| found.radiosity.value)
}

/// The time of `a` for a case over that of `b`.
fn ratio(name: &'static str, cases_a: &[Case], a: impl Fn(&Case) -> f64, cases_b: &[Case], b: impl Fn(&Case) -> f64) -> Ratio {
    let sum =
        |cases: &[Case], work: &dyn Fn(&Case) -> f64| black_box(cases.iter().map(|case| work(black_box(case))).sum::<f64>());
    pair(name, || _ = sum(cases_a, &a), || _ = sum(cases_b, &b))
}

/// Whether the foot of the receiver is in the emitter, a triangle across the z axis.
fn is_under_the_emitter(case: &Case) -> bool {
    let (x, corners) = (case.receiver.position(), case.emitter.polygon().vertices());
    let inward = |i: usize| {
        let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
        (to - from).cross(x - from).z * case.emitter.polygon().normal().z > 0.0
    };
    (0..corners.len()).all(inward)
}

/// Evaluations that the cubature is allowed.
const BUDGET: usize = 1_000_000;

/// How much longer the oracle's adaptive cubature takes for value and gradient at many receivers of one emitter, asked for the
/// tolerance on both, than the closed form: an answer over an answer, one thread each, of a batch and of one receiver after the other.
/// The cubature must say that it converged and all must be within the tolerance of the enclosures, or there is no ratio. The cubature
/// is at its best: graded to the receiver's distance from the start, with rules of the degree that the tolerance asks for. Its points
/// are not shared by receivers, which see different integrands, so that a batch of it is one after the other.
fn over_cubature(names: [&'static str; 2], cases: &[Case], tolerance: f64) -> Result<[Ratio; 2], Box<dyn Error>> {
    let [of_batch, of_one] = names;
    let truths = Truths::enclose(cases)?;
    let emitter = &cases.first().ok_or("no cases")?.emitter;
    let cubature = |case: &Case| integrate(&case.receiver, &case.emitter, tolerance, BUDGET);
    let mut integrated = Vec::new();
    for case in cases {
        let estimate = cubature(case)?;
        if estimate.status != Status::Converged {
            return Err(format!("{of_batch}: the cubature ends {:?}", estimate.status).into());
        }
        integrated.push(Output::new((estimate.radiosity, estimate.gradient), estimate.evaluations));
    }
    let columns = Columns::repeat(cases, BATCH, |number| number);
    let (receivers, engine, mut answers) = (columns.receivers()?, Engine::new(), Answers::new());
    engine.radiosity_and_gradient(&receivers, emitter, &mut answers)?;
    let gradient = |i: usize| DVec3::from(answers.gradient.each_ref().map(|array| array[i]));
    let batch: Vec<Output> = (0..cases.len()).map(|i| Output::new((answers.radiosity[i], gradient(i)), 1)).collect();
    let one = |case: &Case| radiosity_and_gradient(&case.receiver, &case.emitter).map(|answer| Output::new(answer, 1));
    let singly = cases.iter().map(one).collect::<Result<Vec<Output>, _>>()?;
    for (outputs, method) in [(batch, "the batch"), (singly, "one by one"), (integrated, "the cubature")] {
        let worst = truths.errors(&outputs).worst();
        if worst > tolerance {
            return Err(format!("{of_batch}: {method} is off by {worst:e}").into());
        }
    }
    let each =
        || _ = black_box(cases.iter().map(|case| cubature(black_box(case)).map_or(f64::NAN, |e| e.radiosity)).sum::<f64>());
    let batch = || _ = black_box(engine.radiosity_and_gradient(black_box(&receivers), emitter, &mut answers).is_ok());
    let Ratio { name, spread } = pair_of_long(of_batch, each, batch);
    let batch = Ratio { name, spread: spread.scaled(BATCH as f64 / cases.len() as f64) };
    let one = pair_of_long(of_one, each, || _ = black_box(cases.iter().map(both).sum::<f64>()));
    Ok([batch, one])
}

/// Four digits: more are noise.
fn rounded(ratio: f64) -> f64 {
    format!("{ratio:.3e}").parse().unwrap_or(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_printed_with_four_digits() {
        assert_eq!([1.234_56, 0.001_234_56, 1234.56, 2.0].map(rounded), [1.235, 0.001_235, 1235.0, 2.0]);
    }

    #[test]
    fn receivers_under_the_emitter_are_told_from_those_beside_it() {
        let under: Vec<Case> = Regime::Near2.cases(Kind::Constant).unwrap().into_iter().filter(is_under_the_emitter).collect();
        assert_eq!(under.len(), 10);
        for case in under {
            let x = case.receiver.position();
            assert!(x.y > 0.0 && x.y < 1.5 * x.x.min(1.0 - x.x) && (1.0 - x.z - 1e-2).abs() < 1e-6);
        }
        assert!(Regime::Grazing.cases(Kind::Constant).unwrap().iter().all(|case| !is_under_the_emitter(case)));
    }

    #[test]
    fn the_bare_sum_is_right_where_it_is_timed() {
        for case in varied::cases(Kind::Constant).unwrap() {
            let value = radiosity(&case.receiver, &case.emitter).unwrap();
            assert!((lambert::radiosity(&case) / value - 1.0).abs() < 1e-13);
        }
    }
}
