//! Matrices of form factors, whole or as blocks of pairs.

use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use radgrad_scene::{FactorSettings, Scene};

use crate::detached::detached;
use crate::refused;

/// The factors between all faces.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct FactorMatrix {
    pub(crate) scene: Arc<Scene>,
    pub(crate) matrix: radgrad_scene::FactorMatrix,
    pub(crate) settings: FactorSettings,
}

/// Compressed rows of a matrix: offsets, columns and the values.
type Rows<'py> = Bound<'py, PyTuple>;

#[pymethods]
impl FactorMatrix {
    /// Offsets of the rows (one for each face of the scene and one more), columns, factors, their lower and upper bounds, and the
    /// number of polygons in between.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py>> {
        let (mut offsets, mut columns, mut occluders) = (vec![0_i64], Vec::new(), Vec::new());
        let (mut factor, mut lower, mut upper) = (Vec::new(), Vec::new(), Vec::new());
        for face in 0..self.scene.faces().len() {
            for entry in self.matrix.row(face) {
                columns.push(i64::try_from(entry.face).map_err(refused)?);
                factor.push(entry.factor);
                lower.push(entry.lower);
                upper.push(entry.upper);
                occluders.push(i64::try_from(entry.occluders).map_err(refused)?);
            }
            offsets.push(i64::try_from(columns.len()).map_err(refused)?);
        }
        let whole = |numbers| PyArray1::from_vec(py, numbers);
        let real = |numbers| PyArray1::from_vec(py, numbers);
        (whole(offsets), whole(columns), real(factor), real(lower), real(upper), whole(occluders)).into_pyobject(py)
    }

    /// Largest `|1 - sum|` of a row.
    #[getter]
    fn closure(&self) -> f64 {
        self.matrix.worst_closure()
    }

    /// Largest `|A_i F_ij - A_j F_ji|` over the smaller area.
    #[getter]
    fn reciprocity(&self) -> f64 {
        self.matrix.worst_reciprocity()
    }

    /// Largest bound of a factor.
    #[getter]
    fn bound(&self) -> f64 {
        self.matrix.worst_bound()
    }

    /// How many factors have a bound above what was asked for.
    #[getter]
    fn unmet(&self) -> usize {
        self.matrix.unmet(&self.settings).count()
    }

    /// Faces whose rows cannot sum to 1.
    #[getter]
    fn unclosed(&self) -> Vec<usize> {
        self.matrix.unclosed().collect()
    }

    /// The same with rows that sum to 1, and how far factors were moved: most, and in the mean.
    fn repaired(&self, py: Python<'_>) -> PyResult<(Self, f64, f64)> {
        let work = |_: &crate::detached::Stop| {
            let mut matrix = self.matrix.clone();
            let repaired = matrix.repair(&self.settings)?;
            Ok((matrix, repaired))
        };
        let (matrix, repaired) = detached(py, false, work)?;
        Ok((Self { scene: Arc::clone(&self.scene), matrix, settings: self.settings }, repaired.largest, repaired.mean))
    }
}

/// The pairs whose lower face has its row in a block.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct FactorBlock(pub(crate) radgrad_scene::FactorBlock);

#[pymethods]
impl FactorBlock {
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = PyBytes::new(slf.py(), &slf.get().0.to_bytes());
        Ok((slf.getattr("__class__")?.getattr("from_bytes")?, (bytes,)))
    }

    /// A block from the bytes of its pickle.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        radgrad_scene::FactorBlock::from_bytes(bytes).map(Self).map_err(refused)
    }
}
