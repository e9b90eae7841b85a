//! A hundred digits of the closed form against enclosures by quadrature, which share no line with it.

use radgrad_audit::cases::family::Family;
use radgrad_core::{Emission, Emitter, Polynomial, PreciseAnswer, Receiver, evaluate_digits};
use radgrad_oracle::{Interval, enclose};
use radgrad_tests::many_digits::{ManyDigits, distance};

const DIGITS: u32 = 100;

/// Whether the components are within their bound of the enclosed ones, and the bound within the requested digits.
fn assert_near(digits: &[String], bound: &str, truth: &[Interval], case: &str) {
    let digits: Vec<ManyDigits> = digits.iter().map(|text| ManyDigits::new(text)).collect();
    let truth: Vec<ManyDigits> = truth.iter().map(|interval| ManyDigits::new(&interval.to_decimal().unwrap())).collect();
    let zero = vec![ManyDigits::from(0.0); truth.len()];
    let (error, size, bound) = (distance(&digits, &truth), distance(&truth, &zero), ManyDigits::new(bound).to_f64());
    assert!(size > 0.0 && bound <= 1e-100 * size, "{case}: bound {bound:e} of {size:e}");
    // The truth is known to 110 digits, or as far down as its radius, a double, reaches.
    let unknown = 1e-108 * size + 1e-306;
    assert!(unknown <= 1e-60 * size && error <= bound + unknown, "{case}: off by {error:e}, bound {bound:e}, size {size:e}");
}

fn compare(receiver: &Receiver, emitter: &Emitter, case: &str) -> PreciseAnswer {
    let answer = evaluate_digits(receiver, emitter, &[], DIGITS).unwrap();
    if answer.radiosity != "0" {
        let truth = enclose(receiver, emitter, 110).unwrap();
        assert_near(std::slice::from_ref(&answer.radiosity), &answer.radiosity_error, &[truth.radiosity], case);
        assert_near(&answer.gradient, &answer.gradient_error, &truth.gradient, case);
    }
    answer
}

fn cubic(emitter: &Emitter) -> Emitter {
    let polygon = emitter.polygon().clone();
    let terms = [(2.0, [0, 0, 0]), (0.5, [1, 0, 0]), (-0.25, [0, 2, 0]), (0.125, [1, 0, 2])];
    let polynomial = Polynomial::new(polygon.vertices()[0], terms).unwrap();
    Emitter::new(polygon, Emission::Polynomial(polynomial)).unwrap()
}

#[test]
fn a_hundred_digits_are_those_of_the_enclosure() {
    let mut compared = 0;
    for (turn, family) in Family::ALL.into_iter().enumerate() {
        // A hundred edges take the enclosure a minute, and rounded outlines have no hundred digits; an emission of 1 over subnormal lengths has a
        // gradient beyond a double's range.
        if matches!(family, Family::HundredVertices | Family::Single) {
            continue;
        }
        let index = if family == Family::Subnormal { 0 } else { turn as u64 % 3 };
        let Ok(problem) = family.case(23, index).problem() else { continue };
        let emitter = match index {
            0 => problem.emitter,
            1 => cubic(&problem.emitter),
            _ => Emitter::new(problem.emitter.polygon().clone(), Emission::Constant(1.5)).unwrap(),
        };
        let answer = compare(&problem.receiver, &emitter, &format!("{family}:23:{index}"));
        compared += usize::from(answer.radiosity != "0");
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn a_polynomial_in_a_huge_unit_has_them_too() {
    // 2^220 across, so that the square of its slope is beyond a double.
    let problem = Family::Scale.case(23, 0).problem().unwrap();
    let emitter = cubic(&problem.emitter);
    assert!(emitter.steepest_emission() > 1e100);
    compare(&problem.receiver, &emitter, "cubic");
    let answer = radgrad_core::evaluate(&problem.receiver, &emitter, &[]).unwrap();
    assert!(answer.meets(1e-12), "{answer:?}");
}
