//! The truth for outputs: the oracle's enclosures, which share no formula with core; and the errors of outputs.

use std::error::Error;

use radgrad_audit::measures::truth::Truth;
use radgrad_core::evaluate_digits;
use radgrad_oracle::Interval;

use super::output::Output;
use super::regime::Case;

/// Digits of core's own answer that the enclosures must contain.
const DIGITS: u32 = 40;

/// The truth of some cases.
pub(crate) struct Truths(Vec<Truth>);

impl Truths {
    /// Encloses each case.
    ///
    /// # Errors
    /// If the oracle has no enclosure, or core's digits are not within it.
    pub(crate) fn enclose(cases: &[Case]) -> Result<Self, Box<dyn Error>> {
        cases.iter().map(enclosed).collect::<Result<_, _>>().map(Self)
    }

    /// Errors of outputs, one for each case.
    pub(crate) fn errors(&self, outputs: &[Output]) -> Errors {
        let errors = self.0.iter().zip(outputs).map(|(truth, output)| relative_errors(truth, output));
        let (value, gradient): (Vec<f64>, Vec<f64>) = errors.map(|[value, gradient]| (value, gradient)).unzip();
        Errors { value: Quantity::from_errors(value), gradient: Quantity::from_errors(gradient) }
    }
}

/// Relative errors over the cases of a regime.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// Of the radiosity.
    pub(crate) value: Quantity,
    /// Of the gradient, by its norm.
    pub(crate) gradient: Quantity,
}

impl Errors {
    /// The largest of all.
    pub(crate) fn worst(&self) -> f64 {
        self.value.worst.max(self.gradient.worst)
    }
}

/// Median and worst of relative errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quantity {
    pub(crate) median: f64,
    pub(crate) worst: f64,
}

impl Quantity {
    /// NaN is infinitely wrong.
    fn from_errors(mut errors: Vec<f64>) -> Self {
        errors.iter_mut().filter(|error| error.is_nan()).for_each(|error| *error = f64::INFINITY);
        errors.sort_by(f64::total_cmp);
        Self { median: errors[errors.len() / 2], worst: errors[errors.len() - 1] }
    }
}

fn relative_errors(truth: &Truth, output: &Output) -> [f64; 2] {
    output.proven.unwrap_or_else(|| {
        [
            truth.radiosity_error(output.radiosity) / truth.radiosity_magnitude(),
            truth.gradient_error(output.gradient) / truth.gradient_magnitude(),
        ]
    })
}

fn enclosed(case: &Case) -> Result<Truth, Box<dyn Error>> {
    let truth = Truth::unoccluded(&case.receiver, &case.emitter)?;
    let digits = evaluate_digits(&case.receiver, &case.emitter, &[], DIGITS)?;
    let agrees = |enclosure: &Interval, decimal: &str, error: &str| -> Result<bool, Box<dyn Error>> {
        Ok(enclosure.overlaps(&Interval::around_decimal(decimal, error.parse()?)?))
    };
    let mut all_agree = agrees(&truth.radiosity, &digits.radiosity, &digits.radiosity_error)?;
    for (enclosure, decimal) in truth.gradient.iter().zip(&digits.gradient) {
        all_agree &= agrees(enclosure, decimal, &digits.gradient_error)?;
    }
    let place = case.receiver.position();
    if all_agree { Ok(truth) } else { Err(format!("core's {DIGITS} digits are not in the oracle's enclosure at {place}").into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::regime::{Kind, Regime};
    use radgrad_core::radiosity_and_gradient;

    #[test]
    fn an_error_is_seen_in_the_quantity_and_the_size_it_has() {
        let cases = &Regime::Easy.cases(Kind::Linear).unwrap()[..3];
        let truths = Truths::enclose(cases).unwrap();
        let outputs: Vec<Output> =
            cases.iter().map(|case| Output::new(radiosity_and_gradient(&case.receiver, &case.emitter).unwrap(), 1)).collect();
        assert!(truths.errors(&outputs).worst() < 1e-14);
        let mut wrong = outputs.clone();
        wrong[1].radiosity *= 1.0 + 1e-6;
        let errors = truths.errors(&wrong);
        assert!((errors.value.worst - 1e-6).abs() < 1e-12 && errors.value.median < 1e-14);
        assert!(errors.gradient.worst < 1e-14);
        wrong[2].gradient.x = f64::NAN;
        assert_eq!(truths.errors(&wrong).gradient.worst, f64::INFINITY);
    }
}
