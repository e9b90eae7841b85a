//! No cubature that says it converged may be wrong: 116 cases that defeat adaptive integrators, three tolerances.

use std::str::Split;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::SourceFunction;
use radgrad_oracle::cubature::{Form, Status, integrate_form};

struct Case {
    family: String,
    receiver: Receiver,
    emitter: Emitter,
    radiosity: f64,
    gradient: DVec3,
}

fn hard_cases() -> Vec<Case> {
    include_str!("data/hard_cases.txt").lines().filter(|line| !line.starts_with('#')).map(parse).collect()
}

fn parse(line: &str) -> Case {
    let mut words = line.split(' ');
    let family = words.next().unwrap().to_owned();
    let position = vector(&mut words);
    let normal = vector(&mut words);
    let reflectance = number(&mut words);
    let vertices = (0..count(&mut words)).map(|_| vector(&mut words)).collect();
    let values: Vec<f64> = (0..count(&mut words)).map(|_| number(&mut words)).collect();
    let emission = if let [value] = values[..] { Emission::Constant(value) } else { Emission::at_vertices(values) };
    Case {
        family,
        receiver: Receiver::new(position, normal, reflectance).unwrap(),
        emitter: Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap(),
        radiosity: number(&mut words),
        gradient: vector(&mut words),
    }
}

fn count(words: &mut Split<'_, char>) -> usize {
    words.next().unwrap().parse().unwrap()
}

fn number(words: &mut Split<'_, char>) -> f64 {
    words.next().unwrap().parse().unwrap()
}

fn vector(words: &mut Split<'_, char>) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| number(words)))
}

/// Counts of one run over all cases.
#[derive(Debug, Default, PartialEq)]
struct Tally {
    converged: usize,
    exhausted: usize,
    rounded: usize,
    /// Status good, error more than ten tolerances.
    silent: usize,
    /// Error larger than its estimate, whatever the status.
    underestimated: usize,
}

fn tally(form: Form, tolerance: f64, budget: usize) -> Tally {
    let mut tally = Tally::default();
    for case in hard_cases() {
        let source = SourceFunction::Emitter(&case.emitter);
        let estimate = integrate_form(&case.receiver, case.emitter.polygon(), source, form, tolerance, budget).unwrap();
        let value = (estimate.radiosity - case.radiosity).abs();
        let gradient = (estimate.gradient - case.gradient).length();
        let tolerances = (value / case.radiosity).max(gradient / case.gradient.length()) / tolerance;
        match estimate.status {
            Status::Converged => tally.converged += 1,
            Status::BudgetExhausted => tally.exhausted += 1,
            Status::RoundoffLimited => tally.rounded += 1,
            Status::Contradiction => unreachable!("one form alone"),
        }
        tally.silent += usize::from(estimate.status == Status::Converged && tolerances > 10.0);
        let under = value > estimate.radiosity_error || gradient > estimate.gradient_error;
        tally.underestimated += usize::from(under);
        if under || tolerances > 10.0 {
            println!("{} {form:?} {tolerance:e}: {estimate:?}, errors {value:e} {gradient:e}", case.family);
        }
    }
    tally
}

#[test]
fn the_surface_form_reaches_every_loose_tolerance_and_never_fails_silently() {
    let count = hard_cases().len();
    assert!(count >= 100);
    for tolerance in [1e-3, 1e-6] {
        assert_eq!(tally(Form::Surface, tolerance, 1_000_000), Tally { converged: count, ..Tally::default() });
    }
    let tight = tally(Form::Surface, 1e-10, 1_000_000);
    assert_eq!((tight.silent, tight.underestimated), (0, 0), "{tight:?}");
    assert!(tight.converged >= count - 12, "{tight:?}");
}

#[test]
fn the_contour_forms_never_fail_silently() {
    for form in [Form::Contour, Form::Boundary] {
        for tolerance in [1e-3, 1e-6, 1e-10] {
            let tally = tally(form, tolerance, 1_000_000);
            assert_eq!((tally.silent, tally.underestimated), (0, 0), "{form:?} {tolerance:e}: {tally:?}");
            assert!(tally.converged >= 80, "{form:?} {tolerance:e}: {tally:?}");
        }
    }
}

#[test]
fn a_spent_budget_is_said_and_still_bounded() {
    let count = hard_cases().len();
    let short = tally(Form::Surface, 1e-13, 120_000);
    assert_eq!((short.silent, short.underestimated), (0, 0), "{short:?}");
    assert!(short.exhausted > count / 4, "{short:?}");
}
