//! The extension module of the Python package `radgrad`: arrays in, arrays out, without Python's lock while it computes.
//!
//! Users see the layer in `python/radgrad`: it broadcasts shapes, refuses those that do not fit, and has the documentation. This
//! module gets contiguous arrays of the shapes that the layer promises. It checks their values, and raises a `ValueError` with
//! the value, its place and the rule.

mod arrays;
mod audit;
mod derivatives;
mod detached;
mod emitter;
mod evaluate;
mod factors;
mod files;
mod heat;
mod pool;
mod rays;
mod scene;
mod solution;
mod tree;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A wrong input, in the words of the crate that refuses it.
fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The program `radgrad`: its arguments, the first of which is its name. Returns its exit status.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
    pool::computed(py, || radgrad_cli::run(arguments))
}

#[pymodule]
mod _radgrad {
    #[pymodule_export]
    use super::audit::{AuditTable, audit_case, audit_families, audit_shard, merge_shards};
    #[pymodule_export]
    use super::derivatives::derivatives;
    #[pymodule_export]
    use super::detached::watched_by;
    #[pymodule_export]
    use super::emitter::{Affine, Emitter, Polynomial};
    #[pymodule_export]
    use super::evaluate::{digits, each, evaluate, hessian, irradiance_vector};
    #[pymodule_export]
    use super::factors::{FactorBlock, FactorMatrix};
    #[pymodule_export]
    use super::files::{read_regular, write_whole};
    #[pymodule_export]
    use super::heat::{heat, heat_jacobian};
    #[pymodule_export]
    use super::pool::threads;
    #[pymodule_export]
    use super::program;
    #[pymodule_export]
    use super::rays::{BlockCore, RayCore};
    #[pymodule_export]
    use super::scene::SceneCore;
    #[pymodule_export]
    use super::solution::SolutionCore;
    #[pymodule_export]
    use super::tree::Tree;
}
