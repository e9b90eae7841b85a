//! Batches: many receivers against one emitter on the machine's vectors, in the diagrams.

use std::error::Error;

use radgrad_core::DVec3;
use radgrad_core::batch::{Answers, Engine, Precision, Receivers};

use super::method::{Method, Run};
use super::output::Output;
use super::regime::{Case, single};

/// Receivers in a batch.
const BATCH: usize = 1024;

/// Arrays of x, y, z of position and normal, and of the reflectance.
pub(crate) struct Columns<F>([Vec<F>; 7]);

impl<F: Precision> Columns<F> {
    /// Receivers of cases, over and over, each number by `round`.
    pub(crate) fn repeat(cases: &[Case], count: usize, round: impl Fn(f64) -> F) -> Self {
        let numbers = |case: &Case| {
            let ([x, y, z], [nx, ny, nz]) = (case.receiver.position().to_array(), case.receiver.direction().to_array());
            [x, y, z, nx, ny, nz, case.receiver.reflectance()]
        };
        let rows: Vec<[f64; 7]> = cases.iter().map(numbers).collect();
        Self(std::array::from_fn(|column| rows.iter().cycle().take(count).map(|row| round(row[column])).collect()))
    }

    /// As batches take them.
    pub(crate) fn receivers(&self) -> Result<Receivers<'_, F>, radgrad_core::Error> {
        let [x, y, z, nx, ny, nz, reflectance] = &self.0;
        Receivers::new([x, y, z], [nx, ny, nz], reflectance)
    }
}

/// Batches in double precision, plain.
pub(crate) fn double_runs(cases: &[Case]) -> Vec<Run<'_>> {
    vec![run(Method::BatchDouble, cases, |number| number, None)]
}

/// The same with bounds, to tolerances.
pub(crate) fn certified_runs(cases: &[Case]) -> Vec<Run<'_>> {
    [1e-3, 1e-6, 1e-9, 1e-12].map(|tolerance| run(Method::BatchCertified, cases, |number| number, Some(tolerance))).into()
}

/// Batches in single precision, plain.
pub(crate) fn single_runs(cases: &[Case]) -> Vec<Run<'_>> {
    vec![run(Method::BatchSingle, cases, single, None)]
}

fn run<'a, F: Precision + Into<f64>>(
    method: Method,
    cases: &'a [Case],
    round: impl Fn(f64) -> F,
    tolerance: Option<f64>,
) -> Run<'a> {
    let columns = Columns::repeat(cases, BATCH, round);
    let (engine, mut answers) = (Engine::new(), Answers::<F>::new());
    let part = move |_: usize, outputs: &mut Vec<Output>| -> Result<(), Box<dyn Error>> {
        let (receivers, emitter) = (columns.receivers()?, &cases[0].emitter);
        match tolerance {
            None => engine.radiosity_and_gradient(&receivers, emitter, &mut answers)?,
            Some(tolerance) => engine.evaluate_to(&receivers, emitter, tolerance, &mut answers)?,
        }
        let output = |index: usize| {
            let gradient = DVec3::from_array([0, 1, 2].map(|axis| answers.gradient[axis][index].into()));
            Output::new((answers.radiosity[index].into(), gradient), 1)
        };
        outputs.extend((0..cases.len()).map(output));
        Ok(())
    };
    let setting = tolerance.map_or_else(String::new, |tolerance| format!("{tolerance:e}"));
    Run::together(method, setting, BATCH, part)
}
