//! Python's exceptions of the driver's errors.

use magician::Error;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::wording;

/// The exception of an error: its class by the kind alone, its parts as attributes (`magician.errors`).
pub(crate) fn raise(py: Python<'_>, error: &Error) -> PyErr {
    made(py, error).unwrap_or_else(|failed| failed)
}

fn made(py: Python<'_>, error: &Error) -> PyResult<PyErr> {
    let parts = PyDict::new(py);
    parts.set_item("command", error.command())?;
    parts.set_item("value", error.value())?;
    parts.set_item("limit", error.limit())?;
    parts.set_item("unit", error.unit())?;
    parts.set_item("from_index", error.from_index())?;
    parts.set_item("to_index", error.to_index())?;
    let codes: Option<Vec<u32>> = error
        .alarms()
        .map(|alarms| alarms.codes().map(u32::from).collect());
    parts.set_item("alarms", codes)?;
    let told = py.import("magician._told")?.getattr("error")?;
    let mut message = wording::for_python(&error.to_string());
    if error.wants_laser() {
        message.push_str(wording::LASER);
    }
    let exception = told.call((error.kind().name(), message), Some(&parts))?;
    Ok(PyErr::from_value(exception))
}

/// What a program is told that asks for something which makes no sense.
pub(crate) fn invalid(py: Python<'_>, command: &str, why: impl Into<String>) -> PyErr {
    raise(py, &Error::invalid(why).with_command(command))
}
