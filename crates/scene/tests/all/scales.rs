//! The cases of `data/reference/scales.jsonl`: occluders far smaller and larger than the emitter's distance, and walls on the receiver's
//! floor.

use radgrad_core::{DVec3, evaluate, evaluate_digits};
use radgrad_scene::case::Case;
use serde_json::Value;

fn number(text: &Value) -> f64 {
    text.as_str().unwrap().parse().unwrap()
}

#[test]
fn occluders_of_any_scale_hide_what_they_do() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/scales.jsonl");
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let case = Case::from_json(line.as_bytes()).unwrap();
        let truth: Value = serde_json::from_str::<Value>(line).unwrap()["truth"].clone();
        let problem = case.problem().unwrap();
        let answer = evaluate(&problem.receiver, &problem.emitter, &problem.occluders).unwrap();
        let digits = evaluate_digits(&problem.receiver, &problem.emitter, &problem.occluders, 50).unwrap();
        let radiosity = number(&truth["radiosity"]);
        let rounding = f64::EPSILON * radiosity;
        assert!((answer.radiosity - radiosity).abs() <= answer.radiosity_error + rounding, "{}: {answer:?}", case.id);
        assert!((digits.radiosity.parse::<f64>().unwrap() - radiosity).abs() <= rounding, "{}: {digits:?}", case.id);
        if truth["gradient"].is_array() {
            let gradient = DVec3::from([0, 1, 2].map(|axis| number(&truth["gradient"][axis])));
            let largest = gradient.abs().max_element();
            // Squares of 1e297 are beyond the range of doubles.
            let difference = ((answer.gradient - gradient) / largest).length();
            assert!(difference <= answer.gradient_error / largest + 4.0 * f64::EPSILON, "{}: {answer:?}", case.id);
        }
    }
}
