//! The derivatives that a line asks for.

use serde::Serialize;

use crate::error::Error;

/// A derivative with a proven bound on its error; a vector's on the Euclidean norm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DerivativeRecord<V> {
    /// The derivative.
    pub value: V,
    /// The bound. Where none is known, as where an edge is seen along another one, it is infinite, which is written as `null`.
    pub error: f64,
}

/// Derivatives of the radiosity by everything that shapes it, as of [`radgrad_core::Derivatives`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DerivativesRecord {
    /// By each vertex of the emitter, in the unit of the emission over that of length.
    pub vertices: Vec<DerivativeRecord<[f64; 3]>>,
    /// By each vertex of each occluder, likewise.
    pub occluders: Vec<Vec<DerivativeRecord<[f64; 3]>>>,
    /// By each parameter of the emission, in the order of the case.
    pub emission: Vec<DerivativeRecord<f64>>,
    /// By the unit normal, in the unit of the emission.
    pub normal: DerivativeRecord<[f64; 3]>,
    /// By the reflectance, in the unit of the emission.
    pub reflectance: DerivativeRecord<f64>,
}

impl From<radgrad_core::Derivative<radgrad_core::DVec3>> for DerivativeRecord<[f64; 3]> {
    fn from(derivative: radgrad_core::Derivative<radgrad_core::DVec3>) -> Self {
        Self { value: derivative.value.to_array(), error: derivative.error }
    }
}

impl From<radgrad_core::Derivative<f64>> for DerivativeRecord<f64> {
    fn from(radgrad_core::Derivative { value, error }: radgrad_core::Derivative<f64>) -> Self {
        Self { value, error }
    }
}

impl DerivativesRecord {
    /// The record of derivatives.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a derivative is no number that JSON has.
    pub fn new(found: &radgrad_core::Derivatives) -> Result<Self, Error> {
        let record = Self {
            vertices: found.vertices.iter().map(|&vertex| vertex.into()).collect(),
            occluders: found.occluders.iter().map(|vertices| vertices.iter().map(|&vertex| vertex.into()).collect()).collect(),
            emission: found.emission.iter().map(|&parameter| parameter.into()).collect(),
            normal: found.normal.into(),
            reflectance: found.reflectance.into(),
        };
        let vectors = record.vertices.iter().chain(record.occluders.iter().flatten()).chain([&record.normal]);
        let numbers = record.emission.iter().chain([&record.reflectance]).map(|derivative| derivative.value);
        vectors.flat_map(|derivative| derivative.value).chain(numbers).try_for_each(|value| finite("a derivative", value))?;
        Ok(record)
    }
}

pub(super) fn finite(what: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { what: what.to_owned(), value }) }
}
