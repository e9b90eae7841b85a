//! Emitters and their emission.

use numpy::{PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use radgrad_core::{DVec3, Emission, Error, Linear, Polygon};

use crate::arrays::{slice, vectors};
use crate::refused;

/// A pickle: the constructor that Python calls to restore the object, and its arguments.
type Reduced<'py, T> = (Bound<'py, PyAny>, T);

/// Coefficients and exponents as Python has them.
type GivenTerms = Vec<(f64, (u8, u8, u8))>;

/// Emission that is an affine function of the position: `value` at vertex 0, and a gradient.
#[pyclass(frozen, eq, module = "radgrad")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Affine {
    /// Value at vertex 0 of the emitter, in the unit of the emission.
    #[pyo3(get)]
    value: f64,
    gradient: [f64; 3],
}

#[pymethods]
impl Affine {
    #[new]
    fn new(value: f64, gradient: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self { value, gradient: components(gradient, "gradient")? })
    }

    #[getter]
    fn gradient(&self) -> (f64, f64, f64) {
        self.gradient.into()
    }

    fn __repr__(&self) -> String {
        format!("Affine({:?}, {:?})", self.value, self.gradient)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (f64, [f64; 3])>> {
        Ok((slf.getattr("__class__")?, (slf.get().value, slf.get().gradient)))
    }
}

/// Emission that is a polynomial of the position.
#[pyclass(frozen, eq, module = "radgrad")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polynomial(radgrad_core::Polynomial);

type Terms = Vec<(f64, [u8; 3])>;

#[pymethods]
impl Polynomial {
    #[new]
    fn new(origin: &Bound<'_, PyAny>, terms: &Bound<'_, PyAny>) -> PyResult<Self> {
        let given: Terms = terms.extract().map_err(|error| {
            refused(format!("terms: expected a list of (coefficient, (i, j, k)), exponents whole and from 0 to 255: {error}"))
        })?;
        radgrad_core::Polynomial::new(components(origin, "origin")?.into(), given).map(Self).map_err(refused)
    }

    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.0.origin().to_array().into()
    }

    /// Each a coefficient and the exponents of x, y and z.
    #[getter]
    fn terms(&self) -> GivenTerms {
        self.0.terms().iter().map(|term| (term.coefficient, term.powers.into())).collect()
    }

    fn __repr__(&self) -> String {
        let terms: Vec<String> = self.terms().iter().map(|(value, powers)| format!("({value:?}, {powers:?})")).collect();
        format!("Polynomial({:?}, [{}])", self.0.origin().to_array(), terms.join(", "))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, ([f64; 3], GivenTerms)>> {
        Ok((slf.getattr("__class__")?, (slf.get().0.origin().to_array(), slf.get().terms())))
    }
}

/// Three numbers of an argument of that name.
fn components(given: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 3]> {
    given.extract().map_err(|error| refused(format!("{name}: expected three numbers: {error}")))
}

/// A polygon of rounded vertices, or the reason for its refusal and a remedy.
fn polygon(vertices: &PyReadonlyArrayDyn<'_, f64>, precision: f64) -> PyResult<Result<Polygon, String>> {
    Ok(Polygon::from_rounded(vectors(vertices)?, precision).map_err(|error| match error {
        Error::NotPlanar { .. } => {
            format!("{error}: divide it into triangles, or state how exact its coordinates are, Emitter(..., precision=LENGTH)")
        }
        _ => error.to_string(),
    }))
}

/// A polygon that emits.
#[pyclass(frozen, eq, subclass, module = "radgrad._radgrad")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Emitter(pub(crate) radgrad_core::Emitter);

#[pymethods]
impl Emitter {
    #[new]
    fn new(vertices: PyReadonlyArrayDyn<'_, f64>, emission: &Bound<'_, PyAny>, precision: f64) -> PyResult<Self> {
        let polygon = polygon(&vertices, precision)?.map_err(refused)?;
        radgrad_core::Emitter::new(polygon, stated(emission)?).map(Self).map_err(refused)
    }

    /// The vertices, an array of shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vertices_of(py, self.0.polygon())
    }

    /// The length by which each coordinate of a vertex may be off.
    #[getter]
    fn precision(&self) -> f64 {
        self.0.polygon().precision()
    }

    /// What was stated: a number, an array of a number for each vertex, [`Affine`] or [`Polynomial`].
    #[getter]
    fn emission<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.0.emission() {
            Emission::Constant(value) => value.into_pyobject(py)?.into_any(),
            Emission::Linear(Linear::AtVertices(values)) => PyArray1::from_slice(py, values).into_any(),
            Emission::Linear(Linear::Gradient { value, gradient }) => {
                Bound::new(py, Affine { value: *value, gradient: gradient.to_array() })?.into_any()
            }
            Emission::Polynomial(polynomial) => Bound::new(py, Polynomial(polynomial.clone()))?.into_any(),
        })
    }

    /// Unit normal to the side that is lit, an array of shape (3,).
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.0.polygon().normal().to_array())
    }

    /// Area.
    #[getter]
    fn area(&self) -> f64 {
        self.0.polygon().area()
    }

    /// Emission at points of its plane: rows of three numbers.
    fn emission_at<'py>(&self, py: Python<'py>, points: PyReadonlyArrayDyn<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = vectors(&points)?.into_iter().map(|point| self.0.emission_at(point));
        Ok(PyArray1::from_iter(py, values))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let arguments =
            (slf.get().vertices(slf.py())?, slf.get().emission(slf.py())?, slf.get().precision()).into_pyobject(slf.py())?;
        Ok((slf.getattr("__class__")?, arguments))
    }
}

/// The vertices of a polygon.
pub(crate) fn vertices_of<'py>(py: Python<'py>, polygon: &Polygon) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = polygon.vertices().iter().map(|vertex| vertex.to_array().to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// The emission that was meant.
fn stated(emission: &Bound<'_, PyAny>) -> PyResult<Emission> {
    if let Ok(affine) = emission.cast::<Affine>() {
        return Ok(Emission::gradient(affine.get().value, DVec3::from(affine.get().gradient)));
    }
    if let Ok(polynomial) = emission.cast::<Polynomial>() {
        return Ok(Emission::Polynomial(polynomial.get().0.clone()));
    }
    if let Ok(values) = emission.extract::<PyReadonlyArrayDyn<'_, f64>>() {
        return Ok(Emission::at_vertices(slice(&values)?.to_vec()));
    }
    let number = emission.extract::<f64>().map(Emission::Constant);
    number.map_err(|_| {
        PyTypeError::new_err("emission: expected a number, a number for each vertex, radgrad.Affine or radgrad.Polynomial")
    })
}

/// The emitters of a list.
pub(crate) fn all<'a>(emitters: &'a [PyRef<'_, Emitter>]) -> Vec<&'a radgrad_core::Emitter> {
    emitters.iter().map(|emitter| &emitter.0).collect()
}

/// Polygons that hide, each an array of vertices and their precision.
pub(crate) fn occluders(all: &[(PyReadonlyArrayDyn<'_, f64>, f64)]) -> PyResult<Vec<Polygon>> {
    let outline = |(index, (vertices, precision)): (usize, &(PyReadonlyArrayDyn<'_, f64>, f64))| {
        polygon(vertices, *precision)?.map_err(|error| refused(format!("occluder {index}: {error}")))
    };
    all.iter().enumerate().map(outline).collect()
}
