//! Files that are written whole or not at all.

use std::path::PathBuf;

use magician_job::files;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

/// Writes a file so that it is whole or, after an error, as it was.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<()> {
    let written = py.detach(|| files::write_whole(&path, &data));
    written.map_err(|error| match error.raw_os_error() {
        // Its first argument makes it a FileNotFoundError, a PermissionError ..
        Some(number) => PyOSError::new_err((number, error.to_string(), path)),
        None => error.into(),
    })
}
