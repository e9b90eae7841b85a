//! The 84 cases of `data/reference/public.jsonl` through `evaluate_digits`: every one of the truth's 30 digits.

use radgrad_core::{Method, evaluate_digits, evaluate_to};
use radgrad_scene::case::{Case, Problem};
use radgrad_tests::decimal::Decimal;
use radgrad_tests::reference::{PublicTruth, public_cases};

fn cases() -> impl Iterator<Item = (String, Problem, PublicTruth)> {
    public_cases().into_iter().map(|(line, truth)| {
        let case: Case = serde_json::from_str(&line).unwrap();
        (case.id.to_string(), case.problem().unwrap(), truth)
    })
}

fn apart(a: &str, b: &str) -> f64 {
    let [a, b]: [Decimal; 2] = [a, b].map(|text| text.parse().unwrap());
    ((a.high - b.high) + (a.low - b.low)).abs()
}

fn size(text: &str) -> f64 {
    text.parse::<f64>().unwrap().abs()
}

/// Half a unit of the thirtieth digit, against a leading digit of 1, and the error of 31 digits.
const LAST_DIGIT: f64 = 5.2e-30;

#[test]
fn thirty_digits_are_those_of_the_truth() {
    for (id, problem, truth) in cases() {
        let answer = evaluate_digits(&problem.receiver, &problem.emitter, &problem.occluders, 31).unwrap();
        assert!(apart(&answer.radiosity, &truth.radiosity) <= LAST_DIGIT * size(&truth.radiosity), "{id}: {answer:?}");
        let largest = truth.gradient.iter().map(|c| size(c)).fold(0.0, f64::max);
        for (component, expected) in answer.gradient.iter().zip(&truth.gradient) {
            assert!(apart(component, expected) <= LAST_DIGIT * largest, "{id}: {component} instead of {expected}");
        }
    }
}

#[test]
fn every_case_meets_a_tolerance_near_the_roundoff() {
    let mut last_rung = 0;
    for (id, problem, _) in cases() {
        for tolerance in [1e-12, 1e-15] {
            let answer = evaluate_to(&problem.receiver, &problem.emitter, &problem.occluders, tolerance).unwrap();
            assert!(answer.meets(tolerance), "{id}: {answer:?}");
            last_rung += usize::from(answer.method == Method::ArbitraryPrecision);
        }
    }
    assert!(last_rung > 0);
}
