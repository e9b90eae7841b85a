//! Factors by rays, and their products.

use std::sync::Arc;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use radgrad_scene::{
    BlockOperator, Certified, Counted, Error, FactorOperator, FormFactors, RayEntry, RayFactors, RayRow, RaySettings,
};

use crate::detached::{Ended, Stop, detached};
use crate::factors::whole;
use crate::pool::computed;
use crate::refused;
use crate::scene::SceneCore;

/// Blocks of rows, after each of which it is looked whether to stop.
const BLOCKS: usize = 64;

/// A product with the numbers of faces.
fn product<'py>(
    py: Python<'py>,
    q: &PyReadonlyArray1<'_, f64>,
    by: impl Fn(&[f64]) -> Result<Vec<f64>, Error> + Send + Sync,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let q = q.as_array().to_vec();
    Ok(PyArray1::from_vec(py, computed(py, || by(&q))?.map_err(refused)?))
}

/// The same and its error in each face.
fn certified<'py>(
    py: Python<'py>,
    q: &PyReadonlyArray1<'_, f64>,
    by: impl Fn(&[f64]) -> Result<Certified, Error> + Send + Sync,
) -> PyResult<Tuple<'py>> {
    let q = q.as_array().to_vec();
    let Certified { product, error } = computed(py, || by(&q))?.map_err(refused)?;
    (PyArray1::from_vec(py, product), PyArray1::from_vec(py, error)).into_pyobject(py)
}

/// Settings of the rays; `None` takes Rust's default.
#[derive(Debug, Clone, Copy, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Settings {
    tolerance: Option<f64>,
    confidence: Option<f64>,
    rays: Option<u32>,
    seed: Option<u64>,
    drop_below: Option<f64>,
}

impl Settings {
    fn all(self) -> RaySettings {
        let usual = RaySettings::default();
        RaySettings {
            tolerance: self.tolerance.unwrap_or(usual.tolerance),
            confidence: self.confidence.unwrap_or(usual.confidence),
            rays: self.rays,
            seed: self.seed.unwrap_or(usual.seed),
        }
    }
}

/// Factors by rays, as an operator.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct RayCore(Arc<FactorOperator>);

type Tuple<'py> = Bound<'py, PyTuple>;

impl RayCore {
    fn factors(&self) -> &RayFactors {
        self.0.factors()
    }

    fn each_row(&self, mut row: impl FnMut(RayRow)) {
        // A call that cannot fail.
        let _: Result<(), std::convert::Infallible> = self.factors().each_row(|found| {
            row(found);
            Ok(())
        });
    }
}

/// The operator of the counts of all rows.
fn joined(
    factors: &FormFactors<'_>,
    blocks: Vec<Vec<Counted>>,
    (settings, drop_below): (&RaySettings, Option<f64>),
) -> Result<FactorOperator, Ended> {
    let by_rays = factors.by_rays(blocks.into_iter().flatten().collect(), settings)?;
    Ok(FactorOperator::new(if let Some(least) = drop_below { by_rays.without_below(least) } else { by_rays }))
}

#[pymethods]
impl RayCore {
    /// Rays of all faces of a scene.
    #[new]
    fn new(py: Python<'_>, scene: PyRef<'_, SceneCore>, settings: Settings) -> PyResult<Self> {
        let (scene, drop_below, settings) = (Arc::clone(&scene.scene), settings.drop_below, settings.all());
        let work = |stop: &Stop| -> Result<_, Ended> {
            let factors = FormFactors::new(&scene)?;
            stop.expect(factors.faces().len());
            let rows = factors.faces().len();
            let length = rows.div_ceil(BLOCKS).max(1);
            let count = |start: usize| {
                if stop.is_set() {
                    return Err(Ended::Stopped);
                }
                Ok(factors.count_rays(start..rows.min(start + length), &settings, |_| stop.step(1))?)
            };
            let blocks = (0..rows).step_by(length).map(count).collect::<Result<Vec<Vec<Counted>>, Ended>>()?;
            joined(&factors, blocks, (&settings, drop_below))
        };
        detached(py, false, work).map(|operator| Self(Arc::new(operator)))
    }

    /// What the rays of a range of rows met, as bytes: a job of a cluster.
    #[staticmethod]
    fn count<'py>(
        py: Python<'py>,
        scene: PyRef<'_, SceneCore>,
        settings: Settings,
        start: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let (scene, settings) = (Arc::clone(&scene.scene), settings.all());
        let work = |stop: &Stop| -> Result<_, Ended> {
            let factors = FormFactors::new(&scene)?;
            stop.expect(end.saturating_sub(start));
            Ok(Counted::to_bytes(&factors.count_rays(start..end, &settings, |_| stop.step(1))?))
        };
        Ok(PyBytes::new(py, &detached(py, false, work)?))
    }

    /// The factors of those bytes of all rows.
    #[staticmethod]
    fn join(py: Python<'_>, scene: PyRef<'_, SceneCore>, settings: Settings, counted: Vec<Vec<u8>>) -> PyResult<Self> {
        let (scene, drop_below, settings) = (Arc::clone(&scene.scene), settings.drop_below, settings.all());
        let work = |_: &Stop| -> Result<_, Ended> {
            let blocks = counted.iter().map(|bytes| Counted::from_bytes(bytes)).collect::<Result<Vec<_>, _>>()?;
            joined(&FormFactors::new(&scene)?, blocks, (&settings, drop_below))
        };
        detached(py, false, work).map(|operator| Self(Arc::new(operator)))
    }

    /// Offsets of the rows (one for each face of the scene and one more), columns and factors.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<Tuple<'py>> {
        let (offsets, columns, factor) = computed(py, || {
            let stored = self.factors().stored();
            let (mut ends, mut columns, mut factor) =
                (vec![0; self.0.len() + 1], Vec::with_capacity(stored), Vec::with_capacity(stored));
            self.each_row(|RayRow { face, entries, .. }| {
                columns.extend(entries.iter().map(|entry| i32::try_from(entry.face).unwrap_or(i32::MAX)));
                factor.extend(entries.iter().map(|entry| entry.factor));
                ends[face + 1] = columns.len();
            });
            // A face that only hides has an empty row.
            for face in 1..ends.len() {
                ends[face] = ends[face].max(ends[face - 1]);
            }
            (ends, columns, factor)
        })?;
        (whole(py, &offsets)?, PyArray1::from_vec(py, columns), PyArray1::from_vec(py, factor)).into_pyobject(py)
    }

    /// Of the factors in that order the ends of their intervals, and whether they are of no ray.
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Tuple<'py>> {
        let entries: Vec<RayEntry> = computed(py, || {
            let mut entries = Vec::with_capacity(self.factors().stored());
            self.each_row(|row| entries.extend(row.entries));
            entries
        })?;
        let [lower, upper] = [|entry: &RayEntry| entry.lower, |entry: &RayEntry| entry.upper]
            .map(|of| PyArray1::from_iter(py, entries.iter().map(of)));
        (lower, upper, PyArray1::from_iter(py, entries.iter().map(|entry| entry.is_exact))).into_pyobject(py)
    }

    /// Of each face the share of its view that no face has.
    fn opened<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..self.0.len()).map(|face| self.factors().open(face)))
    }

    /// `F Q` of so many columns, face by face.
    fn apply<'py>(&self, py: Python<'py>, q: PyReadonlyArray1<'_, f64>, columns: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        product(py, &q, |q| self.0.apply_many(q, columns))
    }

    /// The same and its error in each face.
    fn certified<'py>(&self, py: Python<'py>, q: PyReadonlyArray1<'_, f64>) -> PyResult<Tuple<'py>> {
        certified(py, &q, |q| self.0.certified(q))
    }

    /// The error of a product, over the largest of the numbers.
    #[getter]
    fn error(&self) -> f64 {
        self.0.error()
    }

    #[getter]
    fn rays(&self) -> u64 {
        self.factors().rays()
    }

    #[getter]
    fn confidence(&self) -> f64 {
        self.factors().confidence()
    }

    #[getter]
    fn absent(&self) -> f64 {
        self.factors().absent()
    }

    #[getter]
    fn stored(&self) -> usize {
        self.factors().stored()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = computed(py, || self.factors().to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let factors = computed(py, || RayFactors::from_bytes(bytes))?.map_err(refused)?;
        Ok(Self(Arc::new(FactorOperator::new(factors))))
    }
}

/// Their products with far blocks in fewer numbers.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct BlockCore(Arc<BlockOperator>);

#[pymethods]
impl BlockCore {
    /// Of the factors of a scene.
    #[new]
    fn new(py: Python<'_>, scene: PyRef<'_, SceneCore>, rays: PyRef<'_, RayCore>, tolerance: f64) -> PyResult<Self> {
        let (scene, operator) = (Arc::clone(&scene.scene), Arc::clone(&rays.0));
        let work = |_: &Stop| -> Result<_, Ended> {
            let middles = FormFactors::new(&scene)?.middles();
            Ok(operator.blocks(&middles, tolerance)?)
        };
        detached(py, false, work).map(|blocks| Self(Arc::new(blocks)))
    }

    /// `F Q` of so many columns, face by face.
    fn apply<'py>(&self, py: Python<'py>, q: PyReadonlyArray1<'_, f64>, columns: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        product(py, &q, |q| self.0.apply_many(q, columns))
    }

    /// `F q` and its error in each face.
    fn certified<'py>(&self, py: Python<'py>, q: PyReadonlyArray1<'_, f64>) -> PyResult<Tuple<'py>> {
        certified(py, &q, |q| self.0.certified(q))
    }

    /// Bytes that the blocks take.
    #[getter]
    fn size(&self) -> usize {
        self.0.bytes()
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = computed(py, || self.0.to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let blocks = computed(py, || BlockOperator::from_bytes(bytes))?.map_err(refused)?;
        Ok(Self(Arc::new(blocks)))
    }
}
