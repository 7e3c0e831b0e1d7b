//! The `magician` command, included in the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command with these arguments, the first of which is the name it was started by; its exit status. For a process that
/// does nothing else: the command takes over its signals and its log.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| magician_cli::run(&arguments))
}
