//! Steps of a plan, singly and as arrays.

use magician_program::{Action, Grip, Step, Travel};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::PyPlan;
use super::check::numbers;
use crate::values;

#[pymethods]
impl PyPlan {
    /// Returns a step, counted from 0, as a dictionary.
    fn step<'py>(&self, py: Python<'py>, at: usize) -> PyResult<Bound<'py, PyDict>> {
        let step = self.plan.steps.get(at);
        let step = step.ok_or_else(|| PyIndexError::new_err("there is no such step"))?;
        let place = step.origin;
        let known = |value: u32| Some(value).filter(|value| *value > 0 && !self.source.rows);
        let row = place.line.checked_sub(1).filter(|_| self.source.rows);
        let parts = PyDict::new(py);
        parts.set_item("number", at + 1)?;
        parts.set_item("action", step.action.name())?;
        parts.set_item("by", travel_name(&step.action))?;
        parts.set_item("values", numbers_of(&step.action))?;
        parts.set_item("target", step.action.target())?;
        parts.set_item("line", known(place.line))?;
        parts.set_item("column", known(place.column))?;
        parts.set_item("row", row)?;
        parts.set_item("name", self.plan.name_of(&place))?;
        let command = step.action.command();
        let command = command
            .map(|command| values::object(py, &command))
            .transpose()?;
        parts.set_item("command", command)?;
        Ok(parts)
    }

    /// All commands of the plan, the tool's first.
    fn commands(&self, py: Python<'_>) -> PyResult<Vec<Py<PyAny>>> {
        let commands = self.plan.commands();
        commands.map(|set| values::object(py, &set)).collect()
    }

    /// Targets of the steps: three numbers each, NaN for a step without a target.
    fn targets<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let targets = py.detach(|| {
            let steps = self.plan.steps.iter();
            let each = |step: &Step| {
                step.action
                    .target()
                    .map_or([f64::NAN; 3], |to| to.map(f64::from))
            };
            steps.map(each).collect::<Vec<_>>()
        });
        numbers(py, targets.as_flattened())
    }
}

/// Kind of travel of an action. `None` if it does not travel from point to point.
fn travel_name(action: &Action) -> Option<&'static str> {
    let named = |by: &Travel| match by {
        Travel::Joints => "joints",
        Travel::Line => "line",
        Travel::Jump => "jump",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    match action {
        Action::Move { by, .. } | Action::Joints { by, .. } => Some(named(by)),
        Action::Shift { line: true, .. } => Some("line"),
        Action::Shift { line: false, .. } => Some("joints"),
        _ => None,
    }
}

/// Numbers of an action, in the order of its name: x, y, z, r; seconds; 1 for on.
fn numbers_of(action: &Action) -> Vec<f64> {
    let all = |numbers: &[f32]| numbers.iter().copied().map(f64::from).collect();
    match action {
        Action::Move { to, .. } | Action::Joints { to, .. } => all(to),
        Action::Shift { by, .. } => all(by),
        Action::Arc { via, to } => all(&[*via, *to].concat()),
        Action::Path { to } => all(to),
        Action::Burn {
            to: [x, y, z],
            power,
        } => all(&[*x, *y, *z, *power]),
        Action::Suction(on) | Action::Laser(on) => vec![f64::from(u8::from(*on))],
        Action::Gripper(grip) => vec![match grip {
            Grip::Off => -1.0,
            Grip::Open => 0.0,
            Grip::Close => 1.0,
        }],
        Action::Wait(milliseconds) => vec![f64::from(*milliseconds) / 1000.0],
        Action::Home | Action::Command(_) | Action::Part(_) | Action::Pause(_) => Vec::new(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
