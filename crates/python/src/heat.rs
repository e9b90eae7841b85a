//! The heat balance of grey surfaces, of factors as rows of a sparse matrix.

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use radgrad_scene::{Boundary, HeatError, SurfaceHeat, heat_balance, reciprocal_areas};

use crate::arrays::slice;
use crate::pool::computed;
use crate::refused;

/// Factors with offsets of rows and columns, the areas where these are known, and emittances: the first argument of both functions.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Bodies<'py> {
    offsets: PyReadonlyArrayDyn<'py, i64>,
    columns: PyReadonlyArrayDyn<'py, i64>,
    factors: PyReadonlyArrayDyn<'py, f64>,
    areas: Option<PyReadonlyArrayDyn<'py, f64>>,
    emittances: PyReadonlyArrayDyn<'py, f64>,
    /// Of a scene the surface of each of its faces.
    names: Option<Vec<String>>,
}

/// Rows of factors and areas.
type Rows = (Vec<Vec<(usize, f64)>>, Vec<f64>);

impl Bodies<'_> {
    fn rows(&self) -> PyResult<Rows> {
        let (offsets, columns, factors) = (slice(&self.offsets)?, slice(&self.columns)?, slice(&self.factors)?);
        let whole = |number: &i64| usize::try_from(*number).map_err(refused);
        let row = |ends: &[i64]| -> PyResult<Vec<(usize, f64)>> {
            let range = whole(&ends[0])?..whole(&ends[1])?;
            let (Some(columns), Some(factors)) = (columns.get(range.clone()), factors.get(range)) else {
                return Err(refused("rows of factors are not in order"));
            };
            columns.iter().zip(factors).map(|(column, factor)| Ok((whole(column)?, *factor))).collect()
        };
        let rows: Vec<_> = offsets.windows(2).map(row).collect::<PyResult<_>>()?;
        let areas = match &self.areas {
            Some(areas) => slice(areas)?.to_vec(),
            None => reciprocal_areas(&rows),
        };
        Ok((rows, areas))
    }

    fn refused(&self, error: &HeatError) -> PyErr {
        let name = |body: usize| match self.names.as_ref().and_then(|names| names.get(body)) {
            Some(name) => format!("face {body} of '{name}'"),
            None => format!("body {body}"),
        };
        refused(error.named(name))
    }
}

/// Temperatures, net heats, radiosities and irradiances of bodies of which the temperature is known, or else the net heat.
#[pyfunction]
pub(crate) fn heat<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    temperatures: PyReadonlyArrayDyn<'py, f64>,
    heats: PyReadonlyArrayDyn<'py, f64>,
    surroundings: Option<f64>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (rows, areas) = bodies.rows()?;
    let known =
        |(kelvin, flux): (&f64, &f64)| if kelvin.is_nan() { Boundary::Flux(*flux) } else { Boundary::Temperature(*kelvin) };
    let boundary: Vec<Boundary> = slice(&temperatures)?.iter().zip(slice(&heats)?).map(known).collect();
    let emittances = slice(&bodies.emittances)?;
    let states = computed(py, || heat_balance(&rows, &areas, emittances, &boundary, surroundings))?;
    let states = states.map_err(|error| bodies.refused(&error))?;
    let array = |of: fn(&SurfaceHeat) -> f64| PyArray1::from_iter(py, states.iter().map(of));
    (array(|of| of.temperature), array(|of| of.flux), array(|of| of.radiosity), array(|of| of.irradiance)).into_pyobject(py)
}

/// Derivatives of the net heats by the temperatures, row by row.
#[pyfunction]
pub(crate) fn heat_jacobian<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    temperatures: PyReadonlyArrayDyn<'py, f64>,
    surroundings: Option<f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (rows, areas) = bodies.rows()?;
    let (kelvins, emittances) = (slice(&temperatures)?, slice(&bodies.emittances)?);
    let jacobian = computed(py, || radgrad_scene::heat_jacobian(&rows, &areas, emittances, kelvins, surroundings))?;
    Ok(PyArray1::from_vec(py, jacobian.map_err(|error| bodies.refused(&error))?))
}
