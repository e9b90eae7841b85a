//! Scenes: from files, from arrays and from bytes.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use radgrad_core::DVec3;
use radgrad_scene::{Degenerate, FactorSettings, FormFactors, GivenFace, Materials, Overlaps, Quantity, Reading, Scene};

use crate::arrays::{rows, slice};
use crate::detached::{Ended, Stop, detached};
use crate::emitter::vertices_of;
use crate::factors::{FactorBlock, FactorMatrix};
use crate::pool::computed;
use crate::refused;

/// A scene, and what its reader noted.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct SceneCore {
    pub(crate) scene: Arc<Scene>,
    notes: Vec<String>,
}

impl SceneCore {
    fn of(scene: Scene) -> Self {
        let notes = scene.notes().iter().map(ToString::to_string).collect();
        Self { scene: Arc::new(scene), notes }
    }
}

const fn degenerate(drop: bool) -> Degenerate {
    if drop { Degenerate::Drop } else { Degenerate::Refuse }
}

/// A precision, a length.
fn length(precision: f64) -> PyResult<f64> {
    if precision >= 0.0 && precision.is_finite() {
        return Ok(precision);
    }
    Err(refused(format!("precision is {precision}: it must be a length, 0 or more")))
}

#[pymethods]
impl SceneCore {
    /// Reads a file.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "called by one place of the Python layer")]
    fn read(
        py: Python<'_>,
        file: PathBuf,
        drop_degenerate: bool,
        allow_outside: bool,
        budget: u64,
        need_materials: bool,
        overlaps: &str,
        precision: Option<f64>,
    ) -> PyResult<Self> {
        let overlaps = match overlaps {
            "nested" => Overlaps::Nested,
            "cut" => Overlaps::Cut,
            "refuse" => Overlaps::Refuse,
            other => return Err(refused(format!("overlaps is `{other}`: it must be `nested`, `cut` or `refuse`"))),
        };
        let precision = precision.map(length).transpose()?;
        let materials = if need_materials { Materials::Required } else { Materials::Optional };
        let degenerate = degenerate(drop_degenerate);
        let reading = Reading { degenerate, budget, allow_outside, materials, overlaps, precision, flip: false };
        computed(py, || Scene::read(file, reading))?.map(Self::of).map_err(refused)
    }

    /// From faces, each so many of `corners`, which are indices of `vertices`; reflectance and emitted radiosity in each channel of each
    /// face, row by row.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "called by one place of the Python layer")]
    fn from_arrays(
        py: Python<'_>,
        vertices: PyReadonlyArrayDyn<'_, f64>,
        counts: PyReadonlyArrayDyn<'_, i64>,
        corners: PyReadonlyArrayDyn<'_, i64>,
        reflectance: PyReadonlyArrayDyn<'_, f64>,
        emission: PyReadonlyArrayDyn<'_, f64>,
        names: Vec<String>,
        channels: Vec<String>,
        drop_degenerate: bool,
        precision: f64,
    ) -> PyResult<Self> {
        let precision = Some(length(precision)?);
        let (vertices, reflectance, emission) = (rows(slice(&vertices)?), slice(&reflectance)?, slice(&emission)?);
        let (mut rest, width) = (slice(&corners)?, channels.len());
        let mut faces = Vec::with_capacity(names.len());
        for (index, (&count, surface)) in slice(&counts)?.iter().zip(names).enumerate() {
            let taken = usize::try_from(count).ok().and_then(|count| rest.split_at_checked(count));
            let Some((outline, after)) = taken else {
                return Err(refused(format!("faces[{index}] has {count} corners: there are fewer")));
            };
            rest = after;
            let vertex = |corner: &i64| {
                let found = usize::try_from(*corner).ok().and_then(|corner| vertices.get(corner));
                let wrong = || {
                    refused(format!(
                        "faces[{index}] has vertex {corner}: they are numbered from 0, and there are {}",
                        vertices.len()
                    ))
                };
                found.map(|vertex| DVec3::from(*vertex)).ok_or_else(wrong)
            };
            let of = |values: &[f64]| values[width * index..width * (index + 1)].to_vec();
            faces.push(GivenFace {
                vertices: outline.iter().map(vertex).collect::<PyResult<_>>()?,
                surface,
                reflectance: of(reflectance),
                radiance: of(emission).into_iter().map(|radiosity| radiosity / std::f64::consts::PI).collect(),
            });
        }
        let reading = Reading { degenerate: degenerate(drop_degenerate), precision, ..Reading::default() };
        computed(py, || Scene::from_faces(channels, faces, reading))?.map(Self::of).map_err(refused)
    }

    /// What [`Self::to_bytes`] gave, with the notes beside it.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8], notes: Vec<String>) -> PyResult<Self> {
        let scene = computed(py, || Scene::from_bytes(bytes))?.map_err(refused)?;
        Ok(Self { scene: Arc::new(scene), notes })
    }

    /// The scene as bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = computed(py, || self.scene.to_bytes())?.map_err(refused)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Notes on changes and omissions of the reader.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// The same with more notes.
    fn noted(&self, notes: Vec<String>) -> Self {
        let notes = self.notes.iter().cloned().chain(notes).collect();
        Self { scene: Arc::clone(&self.scene), notes }
    }

    /// The same with no reflectance above a value.
    fn capped(&self, most: f64) -> PyResult<Self> {
        if !(0.0..1.0).contains(&most) {
            return Err(refused(format!("most is {most}: it must be at least 0 and below 1")));
        }
        let mut scene = (*self.scene).clone();
        let before = scene.notes().len();
        scene.cap_reflectance(most);
        let mut notes = self.notes.clone();
        notes.extend(scene.notes()[before..].iter().map(ToString::to_string));
        Ok(Self { scene: Arc::new(scene), notes })
    }

    /// The same with other values on its faces, row by row: of the reflectance, of the emitted radiosity, or both.
    fn replaced(
        &self,
        py: Python<'_>,
        reflectance: Option<PyReadonlyArrayDyn<'_, f64>>,
        emission: Option<PyReadonlyArrayDyn<'_, f64>>,
    ) -> PyResult<Self> {
        let [shares, emitted] = [&reflectance, &emission].map(|of| of.as_ref().map(|array| slice(array)).transpose());
        let (shares, emitted) = (shares?, emitted?);
        let replace = || {
            let mut scene = match shares {
                Some(shares) => self.scene.replaced(Quantity::Reflectance, shares)?,
                None => (*self.scene).clone(),
            };
            if let Some(emitted) = emitted {
                let radiance: Vec<f64> = emitted.iter().map(|radiosity| radiosity / std::f64::consts::PI).collect();
                scene = scene.replaced(Quantity::Radiance, &radiance)?;
            }
            Ok::<_, radgrad_scene::Error>(scene)
        };
        let scene = computed(py, replace)?.map_err(refused)?;
        Ok(Self { scene: Arc::new(scene), notes: self.notes.clone() })
    }

    /// Warnings about properties that a modeller probably did not mean, such as a scene without lamps.
    fn check(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let scene = &*self.scene;
        detached(py, false, |_| Ok(radgrad_scene::Prepared::new(scene)?.warnings.iter().map(ToString::to_string).collect()))
    }

    /// Number of faces.
    fn __len__(&self) -> usize {
        self.scene.faces().len()
    }

    /// Names of the channels.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.scene.channels().to_vec()
    }

    /// Name of the surface of each face.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.scene.faces().iter().map(|face| self.scene.surfaces()[face.surface()].name().to_owned()).collect()
    }

    /// Areas of the faces.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.scene.polygons().map(radgrad_core::Polygon::area))
    }

    /// The vertices of each face.
    #[getter]
    fn outlines<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.scene.polygons().map(|polygon| vertices_of(py, polygon)).collect()
    }

    /// Mean reflectance (or else emitted radiosity) of each face in each channel, row by row.
    fn means<'py>(&self, py: Python<'py>, emitted: bool) -> Bound<'py, PyArray1<f64>> {
        let (quantity, factor) = if emitted { (Quantity::Radiance, std::f64::consts::PI) } else { (Quantity::Reflectance, 1.0) };
        let channels = self.scene.channels().len();
        let faces = 0..self.scene.faces().len();
        PyArray1::from_iter(
            py,
            faces
                .flat_map(|face| (0..channels).map(move |c| (face, c)))
                .map(|(face, c)| factor * self.scene.mean_over(face, quantity, c)),
        )
    }

    /// All factors, or those of pairs whose lower face has its row in a block.
    fn factors(&self, py: Python<'_>, settings: Settings) -> PyResult<FactorMatrix> {
        let (scene, settings) = (Arc::clone(&self.scene), settings.all());
        let work = |stop: &Stop| -> Result<_, Ended> {
            let factors = FormFactors::new(&scene)?;
            stop.expect(factors.faces().len());
            let matrix = in_blocks(&factors, stop, |rows| Ok(factors.block(rows, &settings, || stop.step(1))?))?;
            Ok(factors.join(matrix)?)
        };
        detached(py, false, work).map(|matrix| FactorMatrix {
            scene: Arc::clone(&self.scene),
            matrix: Arc::new(matrix),
            settings,
        })
    }

    /// The pairs whose lower face has its row in a block.
    fn factor_block(&self, py: Python<'_>, settings: Settings, first: usize, end: usize) -> PyResult<FactorBlock> {
        let (scene, settings) = (&*self.scene, settings.all());
        detached(py, false, |_| Ok(FormFactors::new(scene)?.block(first..end, &settings, || {})?)).map(FactorBlock)
    }

    /// The matrix of blocks of all rows.
    fn join(&self, py: Python<'_>, settings: Settings, blocks: Vec<PyRef<'_, FactorBlock>>) -> PyResult<FactorMatrix> {
        let blocks = blocks.iter().map(|block| block.0.clone()).collect();
        let matrix = computed(py, || FormFactors::new(&self.scene)?.join(blocks))?.map_err(refused)?;
        Ok(FactorMatrix { scene: Arc::clone(&self.scene), matrix: Arc::new(matrix), settings: settings.all() })
    }

    /// The areas of faces that have factors.
    #[getter]
    fn row_areas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let faces = computed(py, || FormFactors::new(&self.scene).map(|factors| factors.faces()))?.map_err(refused)?;
        let areas: Vec<f64> = self.scene.polygons().map(radgrad_core::Polygon::area).collect();
        Ok(PyArray1::from_iter(py, faces.into_iter().map(|face| areas[face])))
    }
}

/// Blocks after which it is looked whether to stop.
pub(crate) fn in_blocks<T>(
    factors: &FormFactors<'_>,
    stop: &Stop,
    block: impl Fn(std::ops::Range<usize>) -> Result<T, Ended>,
) -> Result<Vec<T>, Ended> {
    const BLOCKS: usize = 64;
    let rows = factors.faces().len();
    let length = rows.div_ceil(BLOCKS).max(1);
    let part = |start: usize| if stop.is_set() { Err(Ended::Stopped) } else { block(start..rows.min(start + length)) };
    (0..rows).step_by(length).map(part).collect()
}

/// Settings of the factors; `None` takes Rust's default.
#[derive(Debug, Clone, Copy, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Settings {
    tolerance: Option<f64>,
    relative: Option<f64>,
    most_cells: Option<usize>,
    estimate: Option<f64>,
    most_points: Option<usize>,
}

impl Settings {
    fn all(self) -> FactorSettings {
        let rest = FactorSettings::default();
        FactorSettings {
            tolerance: self.tolerance.unwrap_or(rest.tolerance),
            relative: self.relative.unwrap_or(rest.relative),
            most_cells: self.most_cells.unwrap_or(rest.most_cells),
            estimate: self.estimate.unwrap_or(rest.estimate),
            most_points: self.most_points.unwrap_or(rest.most_points),
            ..rest
        }
    }
}
