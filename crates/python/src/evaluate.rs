//! Many receivers and the emitters that they see, summed or one by one.
//!
//! Points come as rows and kernels want columns. Both are turned a chunk at a time, in the cache, by the thread that computes the chunk.

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use radgrad_core::batch::{Answers, Emitters, Engine, Receivers};
use radgrad_core::{Answer, Error, Method, Polygon};
use rayon::prelude::*;

use crate::arrays::{Number, Points, Shape, rows, slice};
use crate::detached::{Ended, Stop, detached, left};
use crate::emitter::{self, Emitter};
use crate::refused;

/// Points of a chunk: rows and columns of one take 300 kB.
const CHUNK: usize = 2048;

/// Points times emitters that take a few milliseconds at most.
const SHORT: usize = 4096;

/// The same with occluders, or in many digits.
pub(crate) const SHORT_ONE_BY_ONE: usize = 64;

/// The place of a method in `radgrad.METHODS`: the dearer, the later.
pub(crate) const fn code(method: Method) -> u8 {
    match method {
        Method::Zero => 0,
        Method::Quadrature => 1,
        Method::ClosedForm => 2,
        Method::DoubleDouble => 3,
        Method::ArbitraryPrecision => 4,
        Method::OnSurface => 5,
        _ => 6,
    }
}

/// Answers as arrays that numpy takes over.
struct Columns<F> {
    radiosity: Vec<F>,
    radiosity_error: Vec<F>,
    /// Row by row.
    gradient: Vec<F>,
    gradient_error: Vec<F>,
    method: Vec<u8>,
}

/// A stretch of them, to be written.
struct Rows<'a, F> {
    radiosity: &'a mut [F],
    radiosity_error: &'a mut [F],
    gradient: &'a mut [F],
    gradient_error: &'a mut [F],
    method: &'a mut [u8],
}

impl<F: Number> Columns<F> {
    fn new(count: usize) -> Self {
        let zeros = |count: usize| vec![F::default(); count];
        Self {
            radiosity: zeros(count),
            radiosity_error: zeros(count),
            gradient: zeros(3 * count),
            gradient_error: zeros(count),
            method: vec![0; count],
        }
    }

    /// Stretches of so many entries.
    fn chunks(&mut self, length: usize) -> impl IndexedParallelIterator<Item = Rows<'_, F>> {
        let Self { radiosity, radiosity_error, gradient, gradient_error, method } = self;
        let values = radiosity.par_chunks_mut(length).zip(radiosity_error.par_chunks_mut(length));
        let gradients = gradient.par_chunks_mut(3 * length).zip(gradient_error.par_chunks_mut(length));
        values.zip(gradients).zip(method.par_chunks_mut(length)).map(
            |(((radiosity, radiosity_error), (gradient, gradient_error)), method)| Rows {
                radiosity,
                radiosity_error,
                gradient,
                gradient_error,
                method,
            },
        )
    }

    fn into_tuple<'py>(self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Self { radiosity, radiosity_error, gradient, gradient_error, method } = self;
        (
            PyArray1::from_vec(py, radiosity),
            PyArray1::from_vec(py, radiosity_error),
            PyArray1::from_vec(py, gradient),
            PyArray1::from_vec(py, gradient_error),
            PyArray1::from_vec(py, method),
        )
            .into_pyobject(py)
    }
}

/// A sum of answers, with what adding them rounds.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    radiosity: f64,
    radiosity_error: f64,
    gradient: [f64; 3],
    gradient_error: f64,
    method: u8,
}

impl Sum {
    fn add(&mut self, answer: &Answer) {
        self.radiosity += answer.radiosity;
        self.radiosity_error += answer.radiosity_error + f64::UNIT_ROUNDOFF * self.radiosity.abs();
        let mut rounded = 0.0;
        for (sum, term) in self.gradient.iter_mut().zip(answer.gradient.to_array()) {
            *sum += term;
            rounded += sum.abs();
        }
        self.gradient_error += answer.gradient_error + f64::UNIT_ROUNDOFF * rounded;
        self.method = self.method.max(code(answer.method));
    }

    /// Writes it in the precision asked for: the bounds hold what that rounds, and are rounded up. `count` is of the terms.
    fn write<F: Number>(&self, entry: usize, count: usize, rows: &mut Rows<'_, F>) -> Result<(), Error> {
        let overflow = |quantity| Error::Overflow { quantity };
        let up = |error: f64, size: f64| {
            let rounding = if F::UNIT_ROUNDOFF > f64::UNIT_ROUNDOFF { F::UNIT_ROUNDOFF * size + F::LEAST_NORMAL } else { 0.0 };
            F::rounded((error + rounding) * (1.0 + (count as f64 + 8.0) * f64::UNIT_ROUNDOFF) * (1.0 + 4.0 * F::UNIT_ROUNDOFF))
        };
        let finite = |value: f64, quantity| {
            let value = F::rounded(value);
            if value.into().is_finite() { Ok(value) } else { Err(overflow(quantity)) }
        };
        rows.radiosity[entry] = finite(self.radiosity, "radiosity")?;
        for (slot, component) in rows.gradient[3 * entry..3 * entry + 3].iter_mut().zip(self.gradient) {
            *slot = finite(component, "gradient")?;
        }
        let is_exact = self.method == code(Method::Zero);
        let size = self.gradient.iter().map(|component| component.abs()).sum();
        rows.radiosity_error[entry] = if is_exact { F::default() } else { up(self.radiosity_error, self.radiosity.abs()) };
        rows.gradient_error[entry] = if is_exact { F::default() } else { up(self.gradient_error, size) };
        rows.method[entry] = self.method;
        Ok(())
    }
}

/// Columns of a chunk, used again for the next one.
struct Chunk<F> {
    position: [Vec<F>; 3],
    normal: [Vec<F>; 3],
    answers: Answers<F>,
    sums: Vec<Sum>,
}

impl<F: Number> Chunk<F> {
    fn new(points: &Points<'_, F>) -> Self {
        let column = |axis: usize| match points.normals {
            [normal] => vec![normal[axis]; CHUNK],
            _ => vec![F::default(); CHUNK],
        };
        let room = || vec![F::default(); CHUNK];
        Self { position: [room(), room(), room()], normal: [0, 1, 2].map(column), answers: Answers::new(), sums: Vec::new() }
    }

    /// Answers the points from `start` on that the rows are for.
    fn answer(
        &mut self,
        points: &Points<'_, F>,
        start: usize,
        (engine, emitters, tolerance): (Engine, &[&radgrad_core::Emitter], f64),
        rows: &mut Rows<'_, F>,
    ) -> Result<(), Error> {
        let count = rows.radiosity.len();
        turned(&points.positions[start..start + count], &mut self.position);
        if points.normals.len() > 1 {
            turned(&points.normals[start..start + count], &mut self.normal);
        }
        let reflectances =
            if points.reflectances.len() == 1 { points.reflectances } else { &points.reflectances[start..start + count] };
        let [position, normal] = [&self.position, &self.normal].map(|of| of.each_ref().map(|column| &column[..count]));
        let receivers = Receivers::new(position, normal, reflectances)?;
        if let [emitter] = emitters {
            engine.evaluate_to(&receivers, emitter, tolerance, &mut self.answers)?;
            self.copy(rows);
            return Ok(());
        }
        self.sums.clear();
        self.sums.resize(count, Sum::default());
        for emitter in emitters {
            engine.evaluate_to(&receivers, emitter, tolerance, &mut self.answers)?;
            for (entry, sum) in self.sums.iter_mut().enumerate() {
                sum.add(&entry_of(&self.answers, entry));
            }
        }
        let write = |(entry, sum): (usize, &Sum)| sum.write(entry, emitters.len(), rows);
        self.sums.iter().enumerate().try_for_each(write)
    }

    /// One emitter's answers as they are.
    fn copy(&self, rows: &mut Rows<'_, F>) {
        rows.radiosity.copy_from_slice(&self.answers.radiosity);
        rows.radiosity_error.copy_from_slice(&self.answers.radiosity_error);
        rows.gradient_error.copy_from_slice(&self.answers.gradient_error);
        let [x, y, z] = &self.answers.gradient;
        for (row, ((x, y), z)) in rows.gradient.as_chunks_mut::<3>().0.iter_mut().zip(x.iter().zip(y).zip(z)) {
            *row = [*x, *y, *z];
        }
        for (slot, method) in rows.method.iter_mut().zip(&self.answers.method) {
            *slot = code(*method);
        }
    }
}

/// Rows as columns.
fn turned<F: Copy>(rows: &[[F; 3]], [x, y, z]: &mut [Vec<F>; 3]) {
    for (row, ((x, y), z)) in rows.iter().zip(x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut())) {
        [*x, *y, *z] = *row;
    }
}

fn entry_of<F: Number>(answers: &Answers<F>, entry: usize) -> Answer {
    Answer {
        radiosity: answers.radiosity[entry].into(),
        gradient: answers.gradient.each_ref().map(|column| column[entry].into()).into(),
        radiosity_error: answers.radiosity_error[entry].into(),
        gradient_error: answers.gradient_error[entry].into(),
        method: answers.method[entry],
    }
}

/// What was refused of the points from `start` on, in the caller's words.
fn at(shape: &Shape, start: usize) -> impl Fn(Error) -> Ended {
    move |error| match error {
        Error::InBatch { index, error } => Ended::Refused(format!("{}{error}", shape.place(start + index))),
        error => Ended::Refused(error.to_string()),
    }
}

/// The light of all emitters together at receivers.
fn summed<F: Number>(
    points: Points<'_, F>,
    emitters: &[&radgrad_core::Emitter],
    occluders: &[Polygon],
    tolerance: f64,
    (shape, stop): (&Shape, &Stop),
) -> Result<Columns<F>, Ended> {
    let mut columns = Columns::new(points.positions.len());
    let engine = Engine::new();
    if occluders.is_empty() {
        columns.chunks(CHUNK).enumerate().try_for_each_init(
            || Chunk::new(&points),
            |chunk, (index, mut rows)| {
                let start = index * CHUNK;
                if stop.is_set() {
                    return Err(Ended::Stopped);
                }
                stop.step(CHUNK);
                chunk.answer(&points, start, (engine, emitters, tolerance), &mut rows).map_err(at(shape, start))
            },
        )?;
        return Ok(columns);
    }
    columns.chunks(1).enumerate().try_for_each(|(index, mut rows)| {
        if stop.is_set() {
            return Err(Ended::Stopped);
        }
        let mut answer = || -> Result<(), Error> {
            let receiver = points.receiver(index)?;
            let mut sum = Sum::default();
            for emitter in emitters {
                sum.add(&radgrad_core::evaluate_to(&receiver, emitter, occluders, tolerance)?);
            }
            sum.write(0, emitters.len(), &mut rows)
        };
        answer().map_err(|error| Ended::Refused(format!("{}{error}", shape.place(index))))
    })?;
    Ok(columns)
}

/// Receivers in one of the two precisions.
#[derive(FromPyObject)]
pub(crate) enum Numbers<'py> {
    Double(PyReadonlyArrayDyn<'py, f64>),
    Single(PyReadonlyArrayDyn<'py, f32>),
}

/// Radiosity and gradient of many receivers due to all emitters: five arrays, the gradient row by row, the last one codes of methods.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "called by one place of the Python layer")]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    positions: Numbers<'py>,
    normals: Numbers<'py>,
    reflectances: Numbers<'py>,
    emitters: Vec<PyRef<'py, Emitter>>,
    occluders: Vec<(PyReadonlyArrayDyn<'py, f64>, f64)>,
    tolerance: f64,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (emitters, occluders) = (emitter::all(&emitters), emitter::occluders(&occluders)?);
    check(tolerance)?;
    let shape = Shape(shape);
    match (&positions, &normals, &reflectances) {
        (Numbers::Double(x), Numbers::Double(n), Numbers::Double(rho)) => {
            let points = Points::new(x, n, rho)?;
            let is_short = is_short(points.positions.len(), emitters.len(), &occluders);
            detached(py, is_short, |stop| summed(points, &emitters, &occluders, tolerance, (&shape, stop)))?.into_tuple(py)
        }
        (Numbers::Single(x), Numbers::Single(n), Numbers::Single(rho)) => {
            let points = Points::new(x, n, rho)?;
            let is_short = is_short(points.positions.len(), emitters.len(), &occluders);
            detached(py, is_short, |stop| summed(points, &emitters, &occluders, tolerance, (&shape, stop)))?.into_tuple(py)
        }
        _ => Err(PyTypeError::new_err("positions, normals and reflectances are not of one precision")),
    }
}

fn is_short(points: usize, emitters: usize, occluders: &[Polygon]) -> bool {
    points.saturating_mul(emitters) <= if occluders.is_empty() { SHORT } else { SHORT_ONE_BY_ONE }
}

/// Before any work.
pub(crate) fn check(tolerance: f64) -> PyResult<()> {
    if (0.0..=1.0).contains(&tolerance) { Ok(()) } else { Err(refused(Error::Tolerance { value: tolerance })) }
}

/// Radiosity and gradient of each receiver due to each emitter: arrays as of [`evaluate`], a receiver's entries next to each other.
#[pyfunction]
pub(crate) fn each<'py>(
    py: Python<'py>,
    positions: PyReadonlyArrayDyn<'py, f64>,
    normals: PyReadonlyArrayDyn<'py, f64>,
    reflectances: PyReadonlyArrayDyn<'py, f64>,
    emitters: Vec<PyRef<'py, Emitter>>,
    tolerance: f64,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyTuple>> {
    let emitters: Vec<radgrad_core::Emitter> = emitters.iter().map(|emitter| emitter.0.clone()).collect();
    check(tolerance)?;
    let (points, shape) = (Points::new(&positions, &normals, &reflectances)?, Shape(shape));
    let (count, is_short) = (emitters.len(), is_short(points.positions.len(), emitters.len(), &[]));
    let work = |stop: &Stop| -> Result<Columns<f64>, Ended> {
        let mut columns = Columns::new(points.positions.len() * count);
        if count == 0 {
            return Ok(columns);
        }
        let sorted = Emitters::<f64>::new(&emitters);
        columns.chunks(count).enumerate().try_for_each_init(Answers::new, |answers, (index, mut rows)| {
            if stop.is_set() {
                return Err(Ended::Stopped);
            }
            let refused = |error: Error| Ended::Refused(format!("{}{error}", shape.place(index)));
            let receiver = points.receiver(index).map_err(refused)?;
            Engine::new().each_to(&receiver, &sorted, tolerance, answers).map_err(refused)?;
            for entry in 0..count {
                let mut sum = Sum::default();
                sum.add(&entry_of(answers, entry));
                sum.write(entry, 1, &mut rows).map_err(refused)?;
            }
            Ok(())
        })?;
        Ok(columns)
    };
    detached(py, is_short, work)?.into_tuple(py)
}

/// Values of one receiver as decimals: radiosity, gradient, and bounds on their errors.
#[pyfunction]
pub(crate) fn digits(
    py: Python<'_>,
    position: PyReadonlyArrayDyn<'_, f64>,
    normal: PyReadonlyArrayDyn<'_, f64>,
    reflectance: PyReadonlyArrayDyn<'_, f64>,
    emitter: PyRef<'_, Emitter>,
    occluders: Vec<(PyReadonlyArrayDyn<'_, f64>, f64)>,
    digits: u32,
) -> PyResult<(String, [String; 3], String, String)> {
    let receiver = Points::new(&position, &normal, &reflectance)?.receiver(0).map_err(refused)?;
    let (emitter, occluders) = (emitter.0.clone(), emitter::occluders(&occluders)?);
    let found = left(py, move || Ok(radgrad_core::evaluate_digits(&receiver, &emitter, &occluders, digits)?))?;
    Ok((found.radiosity, found.gradient, found.radiosity_error, found.gradient_error))
}

/// Second derivatives: the matrices row by row, bounds on the Frobenius norms of their errors, codes of methods.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "called by one place of the Python layer")]
pub(crate) fn hessian<'py>(
    py: Python<'py>,
    positions: PyReadonlyArrayDyn<'py, f64>,
    normals: PyReadonlyArrayDyn<'py, f64>,
    reflectances: PyReadonlyArrayDyn<'py, f64>,
    emitters: Vec<PyRef<'py, Emitter>>,
    occluders: Vec<(PyReadonlyArrayDyn<'py, f64>, f64)>,
    tolerance: f64,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (emitters, occluders) = (emitter::all(&emitters), emitter::occluders(&occluders)?);
    check(tolerance)?;
    let (points, shape) = (Points::new(&positions, &normals, &reflectances)?, Shape(shape));
    let one = |index: usize| -> Result<([f64; 9], f64, u8), Error> {
        let receiver = points.receiver(index)?;
        let (mut matrix, mut error, mut method) = ([0.0; 9], 0.0, 0);
        for emitter in &emitters {
            let found = radgrad_core::hessian_to(&receiver, emitter, &occluders, tolerance)?;
            let mut size = 0.0;
            // Symmetric: columns are rows.
            for (sum, term) in matrix.iter_mut().zip(found.matrix.to_cols_array()) {
                *sum += term;
                size += sum.abs();
            }
            error += found.error + if emitters.len() > 1 { f64::UNIT_ROUNDOFF * size } else { 0.0 };
            method = method.max(code(found.method));
        }
        Ok((matrix, error * (1.0 + emitters.len() as f64 * f64::EPSILON), method))
    };
    let count = points.positions.len();
    let is_short = count.saturating_mul(emitters.len()) <= SHORT_ONE_BY_ONE;
    let found = detached(py, is_short, |stop| {
        let at = |index| match stop.is_set() {
            true => Err(Ended::Stopped),
            false => one(index).map_err(|error| Ended::Refused(format!("{}{error}", shape.place(index)))),
        };
        (0..count).into_par_iter().map(at).collect::<Result<Vec<_>, _>>()
    })?;
    (
        PyArray1::from_iter(py, found.iter().flat_map(|(matrix, ..)| *matrix)),
        PyArray1::from_iter(py, found.iter().map(|(_, error, _)| *error)),
        PyArray1::from_iter(py, found.iter().map(|(.., method)| *method)),
    )
        .into_pyobject(py)
}

/// Irradiance vectors, row by row.
#[pyfunction]
pub(crate) fn irradiance_vector<'py>(
    py: Python<'py>,
    positions: PyReadonlyArrayDyn<'py, f64>,
    normals: PyReadonlyArrayDyn<'py, f64>,
    emitters: Vec<PyRef<'py, Emitter>>,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (emitters, shape) = (emitter::all(&emitters), Shape(shape));
    let points = Points { positions: rows(slice(&positions)?), normals: rows(slice(&normals)?), reflectances: &[1.0] };
    points.check()?;
    let count = points.positions.len();
    let one = |index: usize| -> Result<[f64; 3], Error> {
        let receiver = points.receiver(index)?;
        let vectors = emitters.iter().map(|emitter| radgrad_core::irradiance_vector(&receiver, emitter));
        vectors.sum::<Result<radgrad_core::DVec3, Error>>().map(|sum| sum.to_array())
    };
    let found = detached(py, count.saturating_mul(emitters.len()) <= SHORT, |stop| {
        let at = |index| match stop.is_set() {
            true => Err(Ended::Stopped),
            false => one(index).map_err(|error| Ended::Refused(format!("{}{error}", shape.place(index)))),
        };
        (0..count).into_par_iter().map(at).collect::<Result<Vec<_>, _>>()
    })?;
    Ok(PyArray1::from_vec(py, found.into_iter().flatten().collect()))
}
