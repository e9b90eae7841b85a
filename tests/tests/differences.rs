//! The gradient is the derivative of the value: closed form against differences of values enclosed to 36 digits.
//!
//! Differences of doubles leave 1e-11 (`tests/properties.rs`); here the step is so small that nothing is left but the gradient's own
//! rounding, and its bound is tested with it.

use glam::DVec3;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};
use radgrad_core::evaluate;
use radgrad_oracle::enclose;
use radgrad_tests::problem::{Problem, problem};

/// A step that leaves `4 (2^-20 / 0.3)^4 = 4e-22` by its order and the enclosures' 1e-33 over it, 1e-27, by their width. Positions are
/// multiples of it, so that `x +- step` is exact.
const STEP: f64 = 1.0 / 1_048_576.0;

/// Decimal places of a value in an `i128`.
const PLACES: usize = 33;

/// A number in units of `10^-PLACES`, from its decimal digits; what is cut off is below one unit.
fn fixed_point(decimal: &str) -> i128 {
    let (digits, exponent) = decimal.split_once('e').unwrap_or((decimal, "0"));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let shift = exponent.parse::<i32>().unwrap() + i32::try_from(PLACES).unwrap() - i32::try_from(fraction.len()).unwrap();
    let all: i128 = format!("{whole}{fraction}").parse().unwrap();
    let power = 10_i128.pow(shift.unsigned_abs());
    if shift < 0 { all / power } else { all * power }
}

fn value(problem: &Problem, offset: DVec3) -> i128 {
    let moved = Problem { position: problem.position + offset, ..problem.clone() };
    let enclosed = enclose(&moved.receiver(), &moved.emitter(), 36).unwrap();
    fixed_point(&enclosed.radiosity.to_decimal().unwrap())
}

/// `[8 (f(h) - f(-h)) - (f(2h) - f(-2h))] / 12h`, exact until the division.
fn derivative(problem: &Problem, axis: DVec3) -> f64 {
    let pair = |k: f64| value(problem, k * STEP * axis) - value(problem, -k * STEP * axis);
    let twelve = 8 * pair(1.0) - pair(2.0);
    twelve as f64 / 1e33 / (12.0 * STEP)
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
        // The differences themselves are rounded to doubles, three roundings a component.
        assert!(error <= answer.gradient_error + 4.0 * f64::EPSILON * size, "{error:e} for {answer:?} at {problem:?}");
        assert!(error <= 1e-13 * size, "{error:e} for {answer:?} at {problem:?}");
    }
}

#[test]
fn decimal_numbers_become_fixed_point_numbers() {
    let unit = 10_i128.pow(33);
    assert_eq!(fixed_point("2.5e-1"), unit / 4);
    assert_eq!(fixed_point("-1.25"), -unit - unit / 4);
    assert_eq!(fixed_point("1.00000000000000000000000000000000099e0"), unit);
}
