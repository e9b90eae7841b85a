//! Very many emitters as one.

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radgrad_core::Error;
use radgrad_core::batch::{Answers, EmitterTree, Engine, Receivers};

use crate::arrays::{Points, Shape};
use crate::detached::{Ended, detached};
use crate::emitter::Emitter;
use crate::pool::computed;

/// Emitters in a tree.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct Tree(EmitterTree<'static>);

/// Points that are answered before signals are looked for.
const CHUNK: usize = 8192;

/// Radiosity, bounds on its error, and what became of the emitters.
type Totals<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyDict>);

#[pymethods]
impl Tree {
    #[new]
    fn new(py: Python<'_>, emitters: Vec<PyRef<'_, Emitter>>) -> PyResult<Self> {
        let emitters: Vec<radgrad_core::Emitter> = emitters.iter().map(|emitter| emitter.0.clone()).collect();
        computed(py, || EmitterTree::owning(emitters)).map(Self)
    }

    /// How many emitters there are.
    fn __len__(&self) -> usize {
        self.0.count()
    }

    /// The light of all of them at receivers, to an absolute error.
    fn total<'py>(
        &self,
        py: Python<'py>,
        positions: PyReadonlyArrayDyn<'py, f64>,
        normals: PyReadonlyArrayDyn<'py, f64>,
        reflectances: PyReadonlyArrayDyn<'py, f64>,
        tolerance: f64,
        shape: Vec<usize>,
    ) -> PyResult<Totals<'py>> {
        let (points, shape) = (Points::new(&positions, &normals, &reflectances)?, Shape(shape));
        let count = points.positions.len();
        let column = |rows: &[[f64; 3]], axis: usize| -> Vec<f64> {
            if rows.len() == 1 { vec![rows[0][axis]; count] } else { rows.iter().map(|row| row[axis]).collect() }
        };
        let found = detached(py, count * self.0.count() <= CHUNK, |stop| {
            let [position, normal] = [points.positions, points.normals].map(|rows| [0, 1, 2].map(|axis| column(rows, axis)));
            let (mut radiosity, mut error, mut answers) = (Vec::with_capacity(count), Vec::with_capacity(count), Answers::new());
            let mut tally = radgrad_core::batch::Tally::default();
            stop.expect(count);
            for start in (0..count).step_by(CHUNK) {
                stop.step(start.min(CHUNK));
                if stop.is_set() {
                    return Err(Ended::Stopped);
                }
                let end = count.min(start + CHUNK);
                let reflectances =
                    if points.reflectances.len() == 1 { points.reflectances } else { &points.reflectances[start..end] };
                let refused = |error: Error| match error {
                    Error::InBatch { index, error } => Ended::Refused(format!("{}{error}", shape.place(start + index))),
                    error => Ended::Refused(error.to_string()),
                };
                let [position, normal] =
                    [&position, &normal].map(|of| of.each_ref().map(|column: &Vec<f64>| &column[start..end]));
                let receivers = Receivers::new(position, normal, reflectances);
                let receivers = receivers.map_err(refused)?;
                tally += Engine::new().threads().total(&receivers, &self.0, tolerance, &mut answers).map_err(refused)?;
                radiosity.extend_from_slice(&answers.radiosity);
                error.extend_from_slice(&answers.radiosity_error);
            }
            Ok((radiosity, error, tally))
        })?;
        let (radiosity, error, tally) = found;
        let counts = PyDict::new(py);
        for (name, count) in [
            ("below", tally.below),
            ("behind", tally.behind),
            ("weak", tally.weak),
            ("together", tally.together),
            ("alone", tally.alone),
        ] {
            counts.set_item(name, count)?;
        }
        Ok((PyArray1::from_vec(py, radiosity), PyArray1::from_vec(py, error), counts))
    }
}
