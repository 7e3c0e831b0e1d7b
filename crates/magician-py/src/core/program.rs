//! A run that can go on after the line broke.

use std::sync::Arc;

use magician::{Arm, Ran, Run, Set};
use pyo3::prelude::*;
use tokio::sync::Mutex;

use super::Core;
use super::motion::{ran, report, run_options};
use super::verbs::commands;
use crate::call::{Call, Reporter};
use crate::runtime::Local;

/// A program on its way through the queue.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Program {
    arm: Local<Arm>,
    run: Local<Arc<Mutex<Run<std::vec::IntoIter<Set>>>>>,
}

#[pymethods]
impl Core {
    /// Commands to run; nothing is sent yet.
    fn begin(
        &self,
        commands: &Bound<'_, PyAny>,
        keep: bool,
        horizon: f64,
        laser_horizon: f64,
        trust_pose: bool,
        patience: f64,
        allow_laser: bool,
    ) -> PyResult<Program> {
        let py = commands.py();
        let options = run_options(py, keep, horizon, laser_horizon, trust_pose, patience)?;
        let arm = self.burning(py, allow_laser)?;
        let run = arm.begin(self::commands(commands)?, options);
        Ok(Program {
            arm: Local::new(arm),
            run: Local::new(Arc::new(Mutex::new(run))),
        })
    }
}

#[pymethods]
impl Program {
    /// Runs what has not been run.
    fn finish(&self, py: Python<'_>) -> PyResult<Call> {
        let run = Arc::clone(self.run.get(py)?);
        let task = |reporter: Reporter| async move {
            let mut run = run.lock().await;
            run.finish(move |progress| report(&reporter, progress))
                .await
        };
        Ok(Call::moving(self.arm.get(py)?, task, ran))
    }

    /// Whether it can go on; not while it runs.
    fn is_interrupted(&self, py: Python<'_>) -> PyResult<bool> {
        let run = self.run.get(py)?.try_lock();
        Ok(run.is_ok_and(|run| run.is_interrupted()))
    }

    /// What it has done; `None` while it runs.
    fn ran(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let done: Option<Ran> = self.run.get(py)?.try_lock().ok().map(|run| run.ran());
        done.map(|done| ran(py, done)).transpose()
    }
}
