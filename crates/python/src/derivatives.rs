//! Derivatives of the radiosity of many receivers by everything that shapes it.

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use radgrad_core::{DVec3, Derivative, Derivatives, Error};
use rayon::prelude::*;

use crate::arrays::{Points, Shape};
use crate::detached::{Ended, detached};
use crate::emitter::{self, Emitter};
use crate::evaluate::{SHORT_ONE_BY_ONE, check, code};

/// Values next to each other, and bounds on their errors, of so many derivatives of each point.
fn columns<'py>(
    py: Python<'py>,
    found: &[Derivatives],
    of: impl Fn(&Derivatives) -> &[Derivative<DVec3>],
) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
    let all = || found.iter().flat_map(&of);
    (
        PyArray1::from_iter(py, all().flat_map(|derivative| derivative.value.to_array())),
        PyArray1::from_iter(py, all().map(|derivative| derivative.error)),
    )
}

/// The same of numbers.
fn numbers<'py>(
    py: Python<'py>,
    found: &[Derivatives],
    of: impl Fn(&Derivatives) -> &[Derivative<f64>],
) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
    let all = || found.iter().flat_map(&of);
    (
        PyArray1::from_iter(py, all().map(|derivative| derivative.value)),
        PyArray1::from_iter(py, all().map(|derivative| derivative.error)),
    )
}

/// Derivatives of each receiver's radiosity due to an emitter: pairs of values and bounds, a receiver's next to each other, of the radiosity,
/// the position, the emitter's vertices, the vertices of each occluder (a list), emission, normal and reflectance; then codes of methods.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "called by one place of the Python layer")]
pub(crate) fn derivatives<'py>(
    py: Python<'py>,
    positions: PyReadonlyArrayDyn<'py, f64>,
    normals: PyReadonlyArrayDyn<'py, f64>,
    reflectances: PyReadonlyArrayDyn<'py, f64>,
    emitter: PyRef<'py, Emitter>,
    occluders: Vec<(PyReadonlyArrayDyn<'py, f64>, f64)>,
    tolerance: f64,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (emitter, occluders) = (&emitter.0, emitter::occluders(&occluders)?);
    check(tolerance)?;
    let (points, shape) = (Points::new(&positions, &normals, &reflectances)?, Shape(shape));
    let one = |index: usize| -> Result<Derivatives, Error> {
        radgrad_core::derivatives(&points.receiver(index)?, emitter, &occluders, tolerance)
    };
    let count = points.positions.len();
    let answers = detached(py, count <= SHORT_ONE_BY_ONE, |stop| {
        let at = |index| match stop.is_set() {
            true => Err(Ended::Stopped),
            false => one(index).map_err(|error| Ended::Refused(format!("{}{error}", shape.place(index)))),
        };
        (0..count).into_par_iter().map(at).collect::<Result<Vec<_>, _>>()
    })?;
    let screens: Vec<_> = (0..occluders.len()).map(|index| columns(py, &answers, |one| &one.occluders[index])).collect();
    (
        numbers(py, &answers, |one| std::slice::from_ref(&one.radiosity)),
        columns(py, &answers, |one| std::slice::from_ref(&one.gradient)),
        columns(py, &answers, |one| &one.vertices),
        PyList::new(py, screens)?,
        numbers(py, &answers, |one| &one.emission),
        columns(py, &answers, |one| std::slice::from_ref(&one.normal)),
        numbers(py, &answers, |one| std::slice::from_ref(&one.reflectance)),
        PyArray1::from_iter(py, answers.iter().map(|one| code(one.method))),
    )
        .into_pyobject(py)
}
