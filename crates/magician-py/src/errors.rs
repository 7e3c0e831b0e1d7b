//! Conversion of driver errors to Python exceptions.

use magician::{Action, Error, ErrorCode, Message, Setting, SettingValue, Voice};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::voice;

/// Advice for an error about the laser permission.
const LASER_ADVICE: &str = ": wear goggles for its wavelength, clear away what must not burn, and stay \
        with it; allow_laser=True allows it";

/// Creates the exception of an error. Its class depends on the kind alone; its parts become
/// attributes (`magician.errors`).
pub(crate) fn raise(py: Python<'_>, error: &Error) -> PyErr {
    exception(py, error).unwrap_or_else(|failed| failed)
}

fn exception(py: Python<'_>, error: &Error) -> PyResult<PyErr> {
    let parts = PyDict::new(py);
    parts.set_item("code", error.code().name())?;
    parts.set_item("step", error.step())?;
    let remedies = error.remedies().iter();
    let remedies: Vec<String> = remedies.map(|remedy| remedy.act.to_string()).collect();
    parts.set_item("remedies", remedies)?;
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
    parts.set_item("station", error.station())?;
    let convert = py.import("magician._conversion")?.getattr("error")?;
    let message = sentence(error);
    let exception = convert.call((error.kind().name(), message), Some(&parts))?;
    Ok(PyErr::from_value(exception))
}

/// Fact and remedies in one sentence, worded for Python.
pub(crate) fn sentence(error: &Error) -> String {
    if error.code() == ErrorCode::LaserNotAllowed {
        return format!("{error}{LASER_ADVICE}");
    }
    match voice::Python.remedies(error.remedies()) {
        Some(remedies) => format!("{error}; {remedies}"),
        None => error.to_string(),
    }
}

/// An exception of every code, with all there is to do about errors: for tests of what they say.
#[pyfunction]
pub(crate) fn every_error(py: Python<'_>) -> Vec<PyErr> {
    let all = ErrorCode::ALL.iter().map(|code| {
        let error = Error::new(*code, "it is so").with_command("SetPTPCmd");
        let error = Action::ALL
            .iter()
            .fold(error, |error, action| error.remedy(*action, "mends it"));
        let given = |setting: &Setting| (*setting, SettingValue::Number(1.0));
        let error = Setting::ALL.iter().fold(error, |error, setting| {
            error.remedy(given(setting), "is a way")
        });
        raise(py, &error)
    });
    all.collect()
}

/// Creates the exception for an invalid use of a command.
pub(crate) fn invalid(py: Python<'_>, command: &str, why: impl Into<Message>) -> PyErr {
    raise(py, &Error::invalid(why).with_command(command))
}
