//! One point of a diagram: a method at a setting, with its errors, time and evaluations.

use std::error::Error;
use std::fmt::Write;

use super::clock::{self, Spread};
use super::method::{Method, Run};
use super::regime::{Kind, Regime};
use super::truth::{Errors, Truths};

/// A method at a setting, measured over the cases of a regime.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    /// Emission of the cases.
    pub(crate) kind: Kind,
    /// The method.
    pub(crate) method: Method,
    /// Its setting.
    pub(crate) setting: String,
    /// Relative errors.
    pub(crate) errors: Errors,
    /// Nanoseconds an answer.
    pub(crate) time: Spread,
    /// Evaluations an answer, on average.
    pub(crate) evaluations: f64,
    /// Cases in which the method itself reports that it did not reach the tolerance.
    pub(crate) given_up: usize,
}

impl Point {
    /// Measures a method at a setting.
    pub(crate) fn measured(mut run: Run<'_>, kind: Kind, truths: &Truths) -> Result<Self, Box<dyn Error>> {
        let mut outputs = run.outputs()?;
        let (errors, count) = (truths.errors(&outputs), outputs.len() as f64);
        let evaluations = outputs.iter().map(|output| output.evaluations as f64).sum::<f64>() / count;
        let given_up = outputs.iter().filter(|output| !output.converged).count();
        let (parts, answers, mut failed) = (run.parts, (run.parts * run.answers) as f64, None);
        let mut part = |index| failed = run.part(index, &mut outputs).err().or(failed.take());
        let time = (0..parts).map(|index| clock::time(|| part(index))).sum::<Spread>().scaled(1e9 / answers);
        match failed {
            Some(error) => Err(error),
            None => Ok(Self { kind, method: run.method, setting: run.setting, errors, time, evaluations, given_up }),
        }
    }
}

/// The ways to differentiate numerically that are as exact as the closed form's own gradient in less time, in words: none should be.
pub(crate) fn better_than_the_closed_form(points: &[Point]) -> Vec<String> {
    let is_better = |point: &&Point| {
        let differentiates = matches!(point.method, Method::CentralDifferences | Method::DualNumbers);
        let own = points.iter().filter(|own| own.method == Method::ClosedForm && own.kind == point.kind);
        let better = |own: &Point| point.errors.worst() <= own.errors.worst() && point.time.median < own.time.median;
        differentiates && own.into_iter().any(better)
    };
    let said = |point: &Point| {
        let Point { kind, method, setting, errors, time, .. } = point;
        format!("{} emission: {} {setting}: {:.1e} in {:.0} ns", kind.name(), method.name(), errors.worst(), time.median)
    };
    points.iter().filter(is_better).map(said).collect()
}

/// Points as CSV: errors relative, times in nanoseconds an answer.
pub(crate) fn table(regime: Regime, points: &[Point]) -> String {
    let mut text =
        "regime,emission,method,setting,value error median,value error worst,gradient error median,gradient error worst,\
                    ns median,ns quartile 1,ns quartile 3,evaluations,given up\n"
            .to_owned();
    for point in points {
        let Point { kind, method, setting, errors, time, evaluations, given_up } = point;
        let [first, third] = time.quartiles;
        let errors = [errors.value.median, errors.value.worst, errors.gradient.median, errors.gradient.worst];
        let errors = errors.map(|error| format!("{error:.2e}")).join(",");
        let (regime, kind, method) = (regime.name(), kind.name(), method.name());
        let times = [time.median, first, third].map(|ns| format!("{ns:.1}")).join(",");
        _ = writeln!(text, "{regime},{kind},{method},{setting},{errors},{times},{evaluations:.1},{given_up}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::truth::Quantity;

    #[test]
    fn what_is_faster_and_as_exact_as_the_closed_form_is_named() {
        let point = |method, error, nanoseconds| {
            let quantity = Quantity { median: error, worst: error };
            let (errors, time) = (Errors { value: quantity, gradient: quantity }, Spread::quartiles(vec![nanoseconds]));
            Point { kind: Kind::Constant, method, setting: "s".to_owned(), errors, time, evaluations: 1.0, given_up: 0 }
        };
        let own = point(Method::ClosedForm, 1e-14, 100.0);
        let with = |other| better_than_the_closed_form(&[own.clone(), other]);
        assert!(with(point(Method::DualNumbers, 1e-14, 300.0)).is_empty());
        assert!(with(point(Method::CentralDifferences, 1e-9, 50.0)).is_empty());
        assert!(with(point(Method::ContourRule, 1e-15, 50.0)).is_empty());
        let named = with(point(Method::DualNumbers, 1e-14, 90.0));
        assert_eq!(named, ["constant emission: dual numbers s: 1.0e-14 in 90 ns"]);
    }
}
