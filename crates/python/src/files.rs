//! Files of the package: written whole or not at all, and read only where they are regular.

use std::io::Write;
use std::path::PathBuf;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Writes a file by way of another one: whatever fails, it is as it was before.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, file: PathBuf, content: &[u8]) -> PyResult<()> {
    let written = py.detach(|| radgrad_scene::output::write_whole(&file, |out| out.write_all(content)));
    written.map_err(|error| PyOSError::new_err(error.to_string()))
}

/// The content of a regular file of no more bytes than `budget`: of pipes, devices and folders none.
#[pyfunction]
pub(crate) fn read_regular(py: Python<'_>, file: PathBuf, budget: u64) -> PyResult<Py<PyBytes>> {
    let read = py.detach(|| radgrad_scene::read_file(&file, budget));
    let content = read.map_err(|error| PyOSError::new_err(format!("`{}` cannot be read: {error}", file.display())))?;
    Ok(PyBytes::new(py, &content).unbind())
}
