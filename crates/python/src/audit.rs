//! The audit's cases, its shards, and a function of the user's held to truth.

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use radgrad_audit::cases::family::{Family, Name};
use radgrad_audit::measures::measure::{Kind, Quantity};
use radgrad_audit::measures::run::{Part, Run};
use radgrad_audit::measures::shard::Shard;
use radgrad_audit::measures::table::Table;
use radgrad_audit::measures::truth::Truth;
use radgrad_core::{DVec3, Polygon};

use crate::detached::{Ended, detached};
use crate::emitter::Emitter;
use crate::pool::computed;
use crate::refused;

type Measured = Shard<Kind, Quantity>;

/// Names of the families.
#[pyfunction]
pub(crate) fn audit_families() -> Vec<&'static str> {
    Family::ALL.iter().map(|family| family.name()).collect()
}

/// So many cases in all, shared among families as `cargo xtask verify --cases` does.
fn whole(cases: u64, seed: u64, families: &[String]) -> PyResult<Run> {
    let named = families.iter().map(|name| name.parse::<Family>().map_err(refused)).collect::<PyResult<Vec<_>>>()?;
    let families = if named.is_empty() { Family::ALL.to_vec() } else { named };
    Ok(Run::of_each(cases.div_ceil(families.len() as u64), &families, seed))
}

/// Part `index` of `of` of a run, as JSON.
#[pyfunction]
pub(crate) fn audit_shard(py: Python<'_>, cases: u64, seed: u64, families: Vec<String>, index: u64, of: u64) -> PyResult<String> {
    if index >= of {
        return Err(refused(format!("part {index} of {of}: parts are numbered from 0")));
    }
    let run = Run { part: Part { index, of }, ..whole(cases, seed, &families)? };
    detached(py, false, |stop| {
        let table = run.tally(|table: &mut Table, name| {
            if !stop.is_set() {
                table.record(name, &radgrad_audit::measures::measure::measure(&name.case()));
                stop.step(1);
            }
        });
        if stop.is_set() {
            return Err(Ended::Stopped);
        }
        Ok(Shard { run: run.clone(), table }.to_json()?)
    })
}

/// The table of all parts of a run.
#[pyfunction]
pub(crate) fn merge_shards(py: Python<'_>, shards: Vec<String>) -> PyResult<AuditTable> {
    computed(py, || {
        let shards = shards.iter().map(|text| Measured::from_json(text)).collect::<Result<Vec<_>, _>>()?;
        Measured::merge(&shards).map(|shard| AuditTable { table: shard.table })
    })?
    .map_err(refused)
}

/// Cases counted and figures distributed, family by family.
#[pyclass(module = "radgrad._radgrad")]
#[derive(Debug, Default)]
pub(crate) struct AuditTable {
    table: Table,
}

#[pymethods]
impl AuditTable {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// The table as JSON.
    fn to_json(&self) -> PyResult<String> {
        Shard { run: Run::of_each(0, &[], 0), table: self.table.clone() }.to_json().map_err(refused)
    }

    /// A table from that.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Ok(Self { table: Measured::from_json(text).map_err(refused)?.table })
    }

    /// Adds an answer to a case: its radiosity, and its gradient if there is one. Returns the relative errors, or what else became of it.
    fn record(
        &mut self,
        py: Python<'_>,
        name: &str,
        radiosity: f64,
        gradient: Option<[f64; 3]>,
    ) -> PyResult<(&'static str, Option<f64>, Option<f64>)> {
        let name: Name = name.parse().map_err(refused)?;
        let is_finite = radiosity.is_finite() && gradient.is_none_or(|gradient| gradient.iter().all(|c| c.is_finite()));
        let problem = name.case().problem();
        let kind = match (&problem, is_finite) {
            (Err(_), _) => Kind::Refused,
            (_, false) => Kind::NonFinite,
            (Ok(_), true) => Kind::Measured,
        };
        let (Ok(problem), Kind::Measured) = (problem, kind) else {
            self.table.count(name, kind);
            return Ok((kind.name(), None, None));
        };
        let Ok(truth) = computed(py, || Truth::of_problem(&problem))? else {
            self.table.count(name, Kind::Undetermined);
            return Ok((Kind::Undetermined.name(), None, None));
        };
        let ratio = |error: f64, size: f64| if error == 0.0 { 0.0 } else { error / size };
        let value = ratio(truth.radiosity_error(radiosity), truth.radiosity_magnitude());
        let slope = gradient.map(|gradient| ratio(truth.gradient_error(DVec3::from(gradient)), truth.gradient_magnitude()));
        self.table.count(name, Kind::Measured);
        self.table.add(name, Quantity::Value, value);
        if let Some(slope) = slope {
            self.table.add(name, Quantity::Gradient, slope);
        }
        Ok((Kind::Measured.name(), Some(value), slope))
    }

    /// Counts a case that was not answered.
    fn unanswered(&mut self, name: &str) -> PyResult<()> {
        self.table.count(name.parse().map_err(refused)?, Kind::Unanswered);
        Ok(())
    }

    /// Number of cases.
    fn __len__(&self) -> PyResult<usize> {
        usize::try_from(self.table.cases()).map_err(refused)
    }

    /// Rows of one of the files of `cargo xtask verify`: `errors`, `figures`, `histogram` or `outcomes`, as CSV.
    fn csv(&self, file: &str) -> PyResult<String> {
        let mut text = Vec::new();
        match file {
            "errors" => self.table.write_errors(&mut text),
            "figures" => self.table.write_figures(&mut text),
            "histogram" => self.table.write_histogram(&mut text),
            "outcomes" => self.table.write_outcomes(&mut text),
            other => {
                return Err(refused(format!("there is no table {other:?}: there are errors, figures, histogram and outcomes")));
            }
        }
        .map_err(refused)?;
        String::from_utf8(text).map_err(refused)
    }
}

/// A case by its name: position, normal, reflectance, emitter, occluders; `None` of a family that is to be refused.
#[pyfunction]
pub(crate) fn audit_case<'py>(py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyTuple>>> {
    let name: Name = name.parse().map_err(refused)?;
    let case = name.case();
    let Ok(problem) = case.problem() else { return Ok(None) };
    let vertices = |polygon: &Polygon| {
        let rows: Vec<Vec<f64>> = polygon.vertices().iter().map(|vertex| vertex.to_array().to_vec()).collect();
        PyArray2::from_vec2(py, &rows)
    };
    let occluders = problem.occluders.iter().map(vertices).collect::<Result<Vec<_>, _>>()?;
    let emitter = Bound::new(py, Emitter(problem.emitter))?;
    let (position, normal) = (case.receiver.position, case.receiver.normal);
    (position, normal, case.receiver.reflectance, emitter, occluders).into_pyobject(py).map(Some)
}
