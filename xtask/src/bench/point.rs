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
    /// Cases in which the method says itself that it did not reach what was asked.
    pub(crate) given_up: usize,
}

impl Point {
    /// Measures a method at a setting.
    pub(crate) fn measured(mut run: Run<'_>, kind: Kind, truths: &Truths) -> Result<Self, Box<dyn Error>> {
        let mut outputs = run.all()?;
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
