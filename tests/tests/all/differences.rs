//! The gradient is the derivative of the value: closed form against differences of values enclosed to 28 digits.
//!
//! Differences of doubles leave 1e-11 (`properties.rs`); here the step is so small that nothing is left but the
//! gradient's own rounding, and its bound is tested with it.

use glam::DVec3;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};
use radgrad_core::evaluate;
use radgrad_oracle::enclose;
use radgrad_tests::decimal::Decimal;
use radgrad_tests::problem::{Problem, problem};

/// A step that leaves `4 (2^-20 / 0.3)^4 = 6e-22` by the difference's order and, over the enclosures' width, 1e-22 by theirs.
/// Positions are multiples of it, so that `x +- step` is exact.
const STEP: f64 = 1.0 / 1_048_576.0;

fn value(problem: &Problem, offset: DVec3) -> Decimal {
    let moved = Problem { position: problem.position + offset, ..problem.clone() };
    let enclosed = enclose(&moved.receiver(), &moved.emitter(), 28).unwrap();
    enclosed.radiosity.to_decimal().unwrap().parse().unwrap()
}

/// `[8 (f(h) - f(-h)) - (f(2h) - f(-2h))] / 12h`. The doubles of two values so near differ exactly (Sterbenz 1974).
fn derivative(problem: &Problem, axis: DVec3) -> f64 {
    let pair = |k: f64| {
        let [after, before] = [k, -k].map(|k| value(problem, k * STEP * axis));
        (after.high - before.high) + (after.low - before.low)
    };
    (8.0 * pair(1.0) - pair(2.0)) / (12.0 * STEP)
}

/// Problems with the receiver on the lattice and no vertex so near the horizon that a step crosses it.
fn problems(count: usize) -> Vec<Problem> {
    let mut runner = TestRunner::new(ProptestConfig { rng_seed: RngSeed::Fixed(9), ..ProptestConfig::default() });
    let strategy = problem(0.5, 1.2);
    let mut problems = Vec::new();
    while problems.len() < count {
        let mut problem = strategy.new_tree(&mut runner).unwrap().current();
        problem.position = (problem.position / STEP).round() * STEP;
        let value = evaluate(&problem.receiver(), &problem.emitter(), &[]).unwrap().radiosity;
        if problem.horizon_distance() > 0.05 && value > 0.0 {
            problems.push(problem);
        }
    }
    problems
}

#[test]
fn the_gradient_is_the_derivative_of_enclosed_values() {
    for problem in problems(12) {
        let answer = evaluate(&problem.receiver(), &problem.emitter(), &[]).unwrap();
        let differences = DVec3::from(DVec3::AXES.map(|axis| derivative(&problem, axis)));
        let error = (answer.gradient - differences).length();
        let size = differences.length();
        println!("error {:.1e}, bound {:.1e} of the gradient", error / size, answer.gradient_error / size);
        // The differences themselves are rounded to doubles, a few roundings a component.
        assert!(error <= answer.gradient_error + 4.0 * f64::EPSILON * size, "{error:e} for {answer:?} at {problem:?}");
        assert!(error <= 1e-13 * size, "{error:e} for {answer:?} at {problem:?}");
    }
}
