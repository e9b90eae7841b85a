//! The 84 cases of `data/reference/public.jsonl`, whose truth is known to 30 digits, through the path of `radgrad eval`.
//!
//! `cargo test -p radgrad-tests --test all reference_cases -- --nocapture` prints the table of all families.

use std::collections::BTreeMap;

use radgrad_core::DEFAULT_TOLERANCE;
use radgrad_scene::case::{AnswerRecord, Line, Reply};
use radgrad_tests::decimal::Decimal;
use radgrad_tests::reference::{PublicTruth, public_cases};

/// Largest relative error allowed, of the value and of the gradient (relative to its norm), where every digit of double
/// precision is to be had. In the other families it is [`DEFAULT_TOLERANCE`], which all the cases ask for.
const LIMITS: [(&str, f64); 3] = [("generic", 1e-13), ("parallel", 1e-13), ("offset", 1e-13)];

/// The absolute errors of one answer, and the size of the truth.
struct Measured {
    answer: AnswerRecord,
    radiosity: f64,
    radiosity_error: f64,
    gradient_norm: f64,
    gradient_error: f64,
}

impl Measured {
    /// `generic-linear` of `generic-linear-2`.
    fn family(&self) -> String {
        let id = self.answer.id.to_string();
        id.rsplit_once('-').unwrap().0.to_owned()
    }

    fn relative_errors(&self) -> [f64; 2] {
        [ratio(self.radiosity_error, self.radiosity), ratio(self.gradient_error, self.gradient_norm)]
    }

    /// Error over bound: above 1 the bound is wrong.
    fn used(&self) -> [f64; 2] {
        [ratio(self.radiosity_error, self.answer.radiosity_error), ratio(self.gradient_error, self.answer.gradient_error)]
    }
}

/// An error of 0 is 0 of everything, of a truth that is 0 too.
fn ratio(error: f64, size: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / size }
}

/// Answers every line; a refusal is a failure of the test.
fn measured() -> Vec<Measured> {
    let lines = public_cases().into_iter().enumerate();
    lines.map(|(index, (line, truth))| measure(index + 1, &line, truth)).collect()
}

fn measure(number: usize, text: &str, truth: PublicTruth) -> Measured {
    let line = Line::read(number, text.as_bytes()).expect("no line is blank");
    let reply = line.and_then(Line::answer).unwrap_or_else(|refusal| panic!("line {number}: {}", refusal.error));
    let Reply::Doubles(answer) = reply else { panic!("line {number}: {reply:?}") };
    let radiosity: Decimal = truth.radiosity.parse().unwrap();
    let gradient: [Decimal; 3] = truth.gradient.map(|component| component.parse().unwrap());
    Measured {
        radiosity: radiosity.high.abs(),
        radiosity_error: radiosity.error_of(answer.radiosity),
        gradient_norm: norm(gradient.map(|component| component.high)),
        gradient_error: norm([0, 1, 2].map(|i| gradient[i].error_of(answer.gradient[i]))),
        answer,
    }
}

/// Euclidean norm, scaled so that no square leaves the range of a double.
fn norm(vector: [f64; 3]) -> f64 {
    let largest = vector.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if largest == 0.0 { 0.0 } else { largest * vector.iter().map(|c| (c / largest) * (c / largest)).sum::<f64>().sqrt() }
}

/// The larger of two numbers, NaN if one is: `f64::max` would pass over it.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Prints, for each family, its worst relative errors and how much of the bounds they use.
fn print_table(cases: &[Measured]) {
    let mut families: BTreeMap<String, Vec<&Measured>> = BTreeMap::new();
    for case in cases {
        families.entry(case.family()).or_default().push(case);
    }
    println!("{:18}  cases    relative error of         error / bound of", "family");
    println!("{:18}         {:>10}  {:>10}    {:>10}  {:>10}", "", "value", "gradient", "value", "gradient");
    for (family, members) in families {
        let worst = |errors: fn(&Measured) -> [f64; 2], i: usize| members.iter().map(|m| errors(m)[i]).fold(0.0, larger);
        let [value, gradient] = [0, 1].map(|i| worst(Measured::relative_errors, i));
        let [value_used, gradient_used] = [0, 1].map(|i| worst(Measured::used, i));
        println!(
            "{family:18}  {:5}  {value:10.1e}  {gradient:10.1e}    {value_used:10.1e}  {gradient_used:10.1e}",
            members.len()
        );
    }
}

#[test]
fn families_meet_their_limits() {
    let cases = measured();
    assert_eq!(cases.len(), 84);
    print_table(&cases);
    for case in &cases {
        let family = case.family();
        let (name, _) = family.split_once('-').unwrap();
        let limit = LIMITS.iter().find(|(limited, _)| *limited == name).map_or(DEFAULT_TOLERANCE, |(_, limit)| *limit);
        let [value, gradient] = case.relative_errors();
        assert!(
            value <= limit && gradient <= limit,
            "{}: value off by {value:e}, gradient by {gradient:e} of itself, allowed {limit:e}",
            case.answer.id
        );
    }
    for (limited, _) in LIMITS {
        assert!(cases.iter().any(|case| case.family().starts_with(&format!("{limited}-"))), "no case of family {limited}");
    }
}

#[test]
fn no_bound_is_smaller_than_its_error() {
    for case in measured() {
        let AnswerRecord { id, radiosity_error, gradient_error, .. } = &case.answer;
        assert!(
            case.radiosity_error <= *radiosity_error,
            "{id}: value off by {:e}, bound {radiosity_error:e}",
            case.radiosity_error
        );
        assert!(
            case.gradient_error <= *gradient_error,
            "{id}: gradient off by {:e}, bound {gradient_error:e}",
            case.gradient_error
        );
        assert!(radiosity_error.is_finite() && gradient_error.is_finite(), "{id}: a bound is infinite");
    }
}
