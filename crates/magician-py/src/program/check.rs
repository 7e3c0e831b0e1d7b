//! Results of a check: as a Python dictionary, and as the error that refuses a run.

use magician::blocking::Arm;
use magician::preflight::Preflight;
use magician::{Error, Options};
use magician_picture::{Preview, PreviewOptions};
use magician_program::rehearse::{RehearseOptions, rehearse, stage};
use magician_program::{Plan, RefusedStep, Report, check};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::{PyPlan, Source, tool, with_text};
use crate::core::seconds;
use crate::picture::{Ink, Picture};
use crate::{errors, values};

/// Start of a check: state of an arm when it was read.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Start {
    pub(crate) preflight: Preflight,
}

/// Prepares a virtual arm for the plan and returns its start.
fn start_of_virtual_arm(plan: &Plan) -> Result<Preflight, Error> {
    let arm = stage(plan, &RehearseOptions::default())?;
    Arm::simulated(arm, Options::default())?.preflight_for(&plan.kinds())
}

impl PyPlan {
    /// Start of the given arm, or of a virtual arm that is ready for the plan.
    pub(super) fn start_or_virtual(
        &self,
        py: Python<'_>,
        start: Option<&Start>,
    ) -> PyResult<Preflight> {
        match start {
            Some(start) => Ok(start.preflight.clone()),
            None => py
                .detach(|| start_of_virtual_arm(&self.plan))
                .map_err(|error| errors::raise(py, &error)),
        }
    }
}

#[pymethods]
impl PyPlan {
    /// Checks the plan. Returns the report as a dictionary.
    fn check<'py>(&self, py: Python<'py>, start: Option<&Start>) -> PyResult<Bound<'py, PyDict>> {
        let start = self.start_or_virtual(py, start)?;
        let report = py.detach(|| check(&self.plan, &start));
        findings(py, &report, &self.source)
    }

    /// Picture of the plan.
    fn preview(
        &self,
        py: Python<'_>,
        start: Option<&Start>,
        side: Option<bool>,
        sheet: Option<Vec<[f64; 2]>>,
    ) -> PyResult<Picture> {
        let start = self.start_or_virtual(py, start)?;
        let svg = py.detach(|| {
            let mut options = PreviewOptions::default();
            (options.side, options.sheet) = (side, sheet);
            let page = self.source.placed.and_then(|(.., page)| page);
            options.page = page.map(Vec::from);
            let report = check(&self.plan, &start);
            Preview::new(&self.plan, &report, &start, &options)
                .to_svg()
                .to_owned()
        });
        Ok(Picture::new(svg))
    }

    /// Runs the plan on a private virtual arm at full speed. Returns the result as a dictionary.
    fn rehearse<'py>(
        &self,
        py: Python<'py>,
        tool: Option<&str>,
        table: Option<f64>,
        watch: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut options = RehearseOptions::default();
        options.tool = self::tool(py, tool)?;
        options.table = table;
        options.watch = watch.map(|each| seconds(py, "watch", each)).transpose()?;
        let done = py.detach(|| rehearse(&self.plan, &options));
        let done = done.map_err(|error| errors::raise(py, &error))?;
        let parts = PyDict::new(py);
        parts.set_item("good", done.is_good())?;
        parts.set_item("seconds", done.time.as_secs_f64())?;
        parts.set_item("steps", done.steps)?;
        parts.set_item("pose", done.pose.to_array())?;
        parts.set_item("joints", done.joints.to_array())?;
        parts.set_item("alarms", values::alarms(py, &done.alarms)?)?;
        let log = done.log.iter();
        let log = log.map(|(at, event)| (at.as_secs_f64(), event.in_words(None).to_string()));
        parts.set_item("log", log.collect::<Vec<_>>())?;
        parts.set_item("way", numbers(py, done.way.as_flattened()))?;
        parts.set_item("drawing", Py::new(py, Ink::new(done.drawing))?)?;
        Ok(parts)
    }
}

/// Encodes numbers as the bytes of an array.
pub(crate) fn numbers<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = numbers
        .iter()
        .flat_map(|number| number.to_ne_bytes())
        .collect();
    PyBytes::new(py, &bytes)
}

/// Converts the findings of a check.
pub(crate) fn findings<'py>(
    py: Python<'py>,
    report: &Report,
    source: &Source,
) -> PyResult<Bound<'py, PyDict>> {
    let parts = PyDict::new(py);
    parts.set_item("refused", report.refused)?;
    parts.set_item("steps", report.steps)?;
    parts.set_item("counts", report.counts.clone())?;
    parts.set_item("seconds", report.time.map(|time| time.as_secs_f64()))?;
    parts.set_item("drawn", report.drawn)?;
    parts.set_item("travelled", report.travelled)?;
    parts.set_item("power", report.power)?;
    parts.set_item("bounds", report.bounds)?;
    parts.set_item("travel_bounds", report.travel_bounds)?;
    let longest = report
        .longest_motion
        .map(|(step, way)| (report.number(step), way));
    parts.set_item("longest_way", longest)?;
    let longest = report
        .longest_time
        .map(|(step, time)| (report.number(step), time.as_secs_f64()));
    parts.set_item("longest_time", longest)?;
    let complaints = report.refused_steps.iter();
    let complaints = complaints.map(|refused_step| objection(py, report, refused_step, source));
    parts.set_item("complaints", complaints.collect::<PyResult<Vec<_>>>()?)?;
    Ok(parts)
}

/// Converts a refused step: step, line, column, name, row, and the exception for it.
fn objection<'py>(
    py: Python<'py>,
    report: &Report,
    refused_step: &RefusedStep,
    source: &Source,
) -> PyResult<Bound<'py, PyDict>> {
    let place = refused_step.origin;
    let known = |value: u32| Some(value).filter(|value| *value > 0 && !source.rows);
    let row = place.line.checked_sub(1).filter(|_| source.rows);
    let parts = PyDict::new(py);
    parts.set_item("step", report.number(refused_step.step))?;
    parts.set_item("line", known(place.line))?;
    parts.set_item("column", known(place.column))?;
    parts.set_item("row", row)?;
    parts.set_item("name", refused_step.name.as_deref())?;
    parts.set_item(
        "error",
        errors::raise(py, &refused_step.error).into_value(py),
    )?;
    Ok(parts)
}

/// Error for a run that is refused: the first refused step, and the number of them. `None` if none
/// is refused.
pub(crate) fn refusal(report: &Report, source: &Source) -> Option<Error> {
    let first = report.refused_steps.first()?;
    let mut place = Vec::new();
    let line = first.origin.line;
    match (source.rows, line, first.origin.column) {
        (_, 0, _) => {}
        (true, line, _) => place.push(format!("row {}", line - 1)),
        (false, line, 0) => place.push(format!("line {line}")),
        (false, line, column) => place.push(format!("line {line}, column {column}")),
    }
    place.push(format!("step {}", report.number(first.step)));
    let name = first
        .name
        .as_ref()
        .map(|name| format!(" ({name})"))
        .unwrap_or_default();
    let file = source
        .name
        .as_ref()
        .map(|file| format!("{file}: "))
        .unwrap_or_default();
    let count = match report.refused {
        1 => "1 step is refused".to_owned(),
        many => format!("{many} steps are refused"),
    };
    let place = place.join(", ");
    let mut why = first.error.to_string();
    if let Some(command) = first.error.command() {
        // The command's name is already in front.
        why = why.replacen(&format!("{command}: "), "", 1);
    }
    let text = format!("{file}{place}{name}: {why}; {count}, nothing was sent");
    Some(with_text(&first.error, text))
}
