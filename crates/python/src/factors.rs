//! Matrices of form factors, whole or as blocks of pairs.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use radgrad_scene::{Entry, FactorSettings, Scene, SurfaceFactor};

use crate::detached::detached;
use crate::pool::computed;
use crate::refused;
use crate::scene::SceneCore;

/// The factors between all faces.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct FactorMatrix {
    pub(crate) scene: Arc<Scene>,
    pub(crate) matrix: Arc<radgrad_scene::FactorMatrix>,
    pub(crate) settings: FactorSettings,
}

/// Arrays of a matrix.
type Arrays<'py> = Bound<'py, PyTuple>;

/// Whole numbers, of 32 bits where all fit.
pub(crate) fn whole<'py>(py: Python<'py>, numbers: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let narrow: Result<Vec<i32>, _> = numbers.iter().map(|number| i32::try_from(*number)).collect();
    if let Ok(narrow) = narrow {
        return Ok(PyArray1::from_vec(py, narrow).into_any());
    }
    let wide = numbers.iter().map(|number| i64::try_from(*number)).collect::<Result<Vec<i64>, _>>().map_err(refused)?;
    Ok(PyArray1::from_vec(py, wide).into_any())
}

#[pymethods]
impl FactorMatrix {
    /// Offsets of the rows (one for each face of the scene and one more), columns and factors.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let (mut offsets, mut columns, mut factor) = (vec![0], Vec::new(), Vec::new());
        for face in 0..self.scene.faces().len() {
            for entry in self.matrix.row(face) {
                columns.push(entry.face);
                factor.push(entry.factor);
            }
            offsets.push(columns.len());
        }
        (whole(py, &offsets)?, whole(py, &columns)?, PyArray1::from_vec(py, factor)).into_pyobject(py)
    }

    /// Of the factors in that order their lower and upper bounds, and the number of polygons in between.
    fn brackets<'py>(&self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let entries = || (0..self.scene.faces().len()).flat_map(|face| self.matrix.row(face));
        let occluders: Vec<usize> = entries().map(|entry| entry.occluders).collect();
        let [lower, upper] = [|entry: Entry| entry.lower, |entry: Entry| entry.upper]
            .map(|of| PyArray1::from_vec(py, entries().map(of).collect()));
        (lower, upper, whole(py, &occluders)?).into_pyobject(py)
    }

    /// Of each face the sum of its row, and what the brackets leave between: 1 is between the two in a closed scene; 0 where it only hides.
    fn sums<'py>(&self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let sums: Vec<SurfaceFactor> = (0..self.scene.faces().len()).map(|face| self.matrix.sum(face)).collect();
        let [factor, lower, upper] =
            [|of: &SurfaceFactor| of.factor, |of: &SurfaceFactor| of.lower, |of: &SurfaceFactor| of.upper]
                .map(|of| PyArray1::from_iter(py, sums.iter().map(of)));
        (factor, lower, upper).into_pyobject(py)
    }

    /// Faces that have a row; others only hide.
    #[getter]
    fn faces(&self) -> Vec<usize> {
        self.matrix.faces().to_vec()
    }

    /// All of its pairs, of which `SceneCore.join` makes it again.
    fn block(&self) -> FactorBlock {
        FactorBlock(self.matrix.to_block())
    }

    /// The same of a scene with other values on the same faces.
    fn of(&self, scene: PyRef<'_, SceneCore>) -> PyResult<Self> {
        let is_same = self.scene.polygons().eq(scene.scene.polygons());
        if !is_same {
            return Err(refused("the scene has other faces than the factors are of"));
        }
        Ok(Self { scene: Arc::clone(&scene.scene), matrix: Arc::clone(&self.matrix), settings: self.settings })
    }

    /// Writes it as `radgrad factors --out` does.
    fn write(&self, py: Python<'_>, file: PathBuf, open: bool) -> PyResult<()> {
        let written = computed(py, || radgrad_cli::file::factors(&self.matrix, &self.scene, &file, open))?;
        written.map_err(pyo3::exceptions::PyOSError::new_err)
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
            let mut matrix = (*self.matrix).clone();
            let repaired = matrix.repair(&self.settings)?;
            Ok((matrix, repaired))
        };
        let (matrix, repaired) = detached(py, false, work)?;
        let repairs = Self { scene: Arc::clone(&self.scene), matrix: Arc::new(matrix), settings: self.settings };
        Ok((repairs, repaired.largest, repaired.mean))
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
