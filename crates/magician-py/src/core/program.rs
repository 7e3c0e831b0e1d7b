//! Runs that can continue after the line was lost.

use std::sync::Arc;

use magician::{Arm, Run, RunOptions, RunSummary, Set};
use pyo3::prelude::*;
use tokio::sync::Mutex;

use super::motion::{report, run_summary};
use super::verbs::commands;
use super::{Core, seconds};
use crate::call::{Call, Reporter};
use crate::runtime::Local;

/// Options of a program: treatment of the queue, and permissions.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct ProgramOptions {
    keep: bool,
    horizon: f64,
    laser_horizon: f64,
    trust_pose: bool,
    patience: f64,
    allow_laser: bool,
}

impl ProgramOptions {
    fn options(&self, py: Python<'_>) -> PyResult<RunOptions> {
        Ok(RunOptions::default()
            .keep(self.keep)
            .horizon(seconds(py, "the horizon", self.horizon)?)
            .laser_horizon(seconds(py, "the laser horizon", self.laser_horizon)?)
            .trust_pose(self.trust_pose)
            .patience(seconds(py, "the patience", self.patience)?))
    }
}

/// Resumable run of a program through the queue.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Program {
    arm: Local<Arm>,
    run: Local<Arc<Mutex<Run<std::vec::IntoIter<Set>>>>>,
}

#[pymethods]
impl Core {
    /// Prepares a run of commands. Nothing is sent yet.
    fn begin(&self, commands: &Bound<'_, PyAny>, options: ProgramOptions) -> PyResult<Program> {
        let py = commands.py();
        let run_options = options.options(py)?;
        let arm = self.burning(py, options.allow_laser)?;
        let run = arm.start_with(self::commands(commands)?, run_options);
        Ok(Program {
            arm: Local::new(arm),
            run: Local::new(Arc::new(Mutex::new(run))),
        })
    }
}

#[pymethods]
impl Program {
    /// Runs the rest of the program.
    fn finish(&self, py: Python<'_>) -> PyResult<Call> {
        let run = Arc::clone(self.run.get(py)?);
        let task = |reporter: Reporter| async move {
            let mut run = run.lock().await;
            run.wait(move |progress| report(&reporter, progress)).await
        };
        Ok(Call::moving(self.arm.get(py)?, task, run_summary))
    }

    /// True if the run can be resumed; false while it runs.
    fn is_interrupted(&self, py: Python<'_>) -> PyResult<bool> {
        let run = self.run.get(py)?.try_lock();
        Ok(run.is_ok_and(|run| run.is_interrupted()))
    }

    /// Summary of the finished commands; `None` while it runs.
    fn ran(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let done: Option<RunSummary> = self.run.get(py)?.try_lock().ok().map(|run| run.ran());
        done.map(|done| run_summary(py, done)).transpose()
    }
}
