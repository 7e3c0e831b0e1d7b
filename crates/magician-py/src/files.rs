//! Files that are written atomically.

use std::path::PathBuf;

use magician::Error;
use magician_job::files;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::errors;

/// Refuses an output that is one of the inputs, or another output.
#[pyfunction]
pub(crate) fn check_distinct(
    py: Python<'_>,
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
) -> PyResult<()> {
    let [reads, writes] = [&inputs, &outputs].map(|paths| paths.iter().map(PathBuf::as_path));
    files::check_distinct(reads, writes)
        .map_err(|same| errors::raise(py, &Error::invalid(same.to_string())))
}

/// Writes a file so that it is whole or, after an error, as it was.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<()> {
    let written = py.detach(|| files::write_whole(&path, &data));
    written.map_err(|error| match error.raw_os_error() {
        // With an error number as its first argument, Python chooses the subclass:
        // FileNotFoundError, PermissionError and so on.
        Some(number) => PyOSError::new_err((number, error.to_string(), path)),
        None => error.into(),
    })
}
