//! Reading, setting and queueing of commands, and raw frames.

use magician::Set;
use magician::commands::Pose;
use magician::protocol::{Ctrl, FrameBuf, Layout as _, NoArgs, Readable as _, Row};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};

use super::Core;
use crate::call::Call;
use crate::errors;
use crate::values::{self, Kind};

/// Refuses a dangerous command unless it is allowed.
fn check_dangerous(py: Python<'_>, row: &Row, allow_dangerous: bool) -> PyResult<()> {
    let Some(danger) = row.danger().filter(|_| !allow_dangerous) else {
        return Ok(());
    };
    let message = format!("it {danger}; allow_dangerous=True sends it");
    Err(errors::invalid(py, row.set_name, message))
}

/// Converts an iterable of commands.
pub(super) fn commands(commands: &Bound<'_, PyAny>) -> PyResult<Vec<Set>> {
    // The length is only a claim of the object: limit the memory reserved for it.
    let mut all = Vec::with_capacity(commands.len().unwrap_or(0).min(1 << 16));
    for command in commands.try_iter()? {
        all.push(values::command(&command?)?);
    }
    Ok(all)
}

#[pymethods]
impl Core {
    /// Reads a value, given its class or a query.
    fn get(&self, what: &Bound<'_, PyAny>) -> PyResult<Call> {
        let py = what.py();
        let Kind { row, layout } = values::kind(what)?;
        let Some(answer) = row.value else {
            let why = "it cannot be read, only set";
            return Err(errors::invalid(py, layout.name, why));
        };
        let asks = row.query.unwrap_or(NoArgs::INFO);
        let (class, params) = if layout == answer && what.is_instance_of::<PyType>() {
            if !asks.fields.is_empty() {
                let why = format!("read it with {}(...)", asks.name);
                return Err(errors::invalid(py, layout.name, why));
            }
            (what.clone(), Vec::new())
        } else if layout == asks && what.is_instance_of::<PyType>() {
            let why = format!("it takes values: {}(...)", asks.name);
            return Err(errors::invalid(py, layout.name, why));
        } else if layout == asks {
            let class = py.import("magician.commands")?.getattr(answer.name)?;
            (class, values::encode(row, asks, what)?)
        } else {
            let why = "it is not a query; use a class, or the query that its docstring names";
            return Err(errors::invalid(py, layout.name, why));
        };
        let (arm, class) = (self.arm(py)?, class.unbind());
        let ask = async move { arm.raw(row.id, Ctrl::GET, &params).await };
        Ok(Call::start(ask, move |py, reply| {
            values::decode(class.bind(py), answer, reply.frame().params())
        }))
    }

    /// Current pose: read, or known from the last motion.
    fn known_pose(&self, class: &Bound<'_, PyAny>) -> PyResult<Call> {
        let (arm, class) = (self.arm(class.py())?, class.clone().unbind());
        let ask = async move {
            let pose = arm.front_end().known_pose().await?;
            let frame = FrameBuf::encode(Pose::ROW.id, Ctrl::GET, &pose)?;
            Ok::<_, magician::Error>(frame)
        };
        Ok(Call::start(ask, move |py, pose| {
            values::decode(class.bind(py), Pose::INFO, pose.frame().params())
        }))
    }

    /// Sets a value or orders an action, at once.
    fn set(
        &self,
        command: &Bound<'_, PyAny>,
        allow_dangerous: bool,
        allow_laser: bool,
    ) -> PyResult<Call> {
        let py = command.py();
        let command = values::command(command)?;
        check_dangerous(py, command.row(), allow_dangerous)?;
        let arm = self.burning(py, allow_laser)?;
        Ok(Call::plain(async move { arm.set_any(&command).await }))
    }

    /// Sets an output pin that has the matching function.
    fn drive(&self, command: &Bound<'_, PyAny>, allow_laser: bool) -> PyResult<Call> {
        let arm = self.burning(command.py(), allow_laser)?;
        let command = values::command(command)?;
        Ok(Call::plain(async move { arm.pins().drive(&command).await }))
    }

    /// Queues a command and returns its index.
    fn enqueue(&self, command: &Bound<'_, PyAny>, allow_laser: bool) -> PyResult<Call> {
        let arm = self.burning(command.py(), allow_laser)?;
        let command = values::command(command)?;
        Ok(Call::start(
            async move { arm.enqueue_set(&command).await },
            |py, index| Ok(index.0.into_pyobject(py)?.into_any().unbind()),
        ))
    }

    /// Sends an arbitrary frame and returns the parameters of the reply.
    fn raw(
        &self,
        py: Python<'_>,
        id: u8,
        ctrl: u8,
        params: Vec<u8>,
        allow_dangerous: bool,
        allow_laser: bool,
    ) -> PyResult<Call> {
        let ctrl = Ctrl(ctrl);
        if let Some(row) = Row::with_id(id).filter(|row| row.sets(ctrl)) {
            check_dangerous(py, row, allow_dangerous)?;
        }
        let arm = self.burning(py, allow_laser)?;
        Ok(Call::start(
            async move { arm.raw(id, ctrl, &params).await },
            |py, reply| {
                let params = PyBytes::new(py, reply.frame().params());
                Ok(params.into_any().unbind())
            },
        ))
    }
}
