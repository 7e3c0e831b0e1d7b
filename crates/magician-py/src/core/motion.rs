//! Motions, waits and stops.

use std::time::Duration;

use magician::preflight::{Guards, Preflight};
use magician::{Error, ErrorCode, Progress, QueueIndex, RunOptions, RunSummary, Set};
use magician_job::{WorkSurface, store_surface, touch_off};
use magician_program::{Surface, Tool};
use pyo3::prelude::*;

use super::Core;
use super::verbs::commands;
use crate::call::{Call, Reporter};
use crate::errors;

/// Default guards without the named ones.
pub(super) fn guards(py: Python<'_>, skip: &[String], require_homed: bool) -> PyResult<Guards> {
    let mut guards = Guards::default().require_homed(require_homed);
    for name in skip {
        guards = match name.as_str() {
            "reach" => guards.reach(false),
            "unknown_start" => guards.unknown_start(false),
            "jog" => guards.jog(false),
            "laser" => guards.laser(false),
            "alarms" => guards.alarms(false),
            other => {
                let message = format!(
                    "unknown check `{other}`; known are reach, unknown_start, jog, laser, alarms"
                );
                return Err(errors::raise(py, &Error::invalid(message)));
            }
        };
    }
    Ok(guards)
}

/// Checks commands and returns their duration. Runs on a blocking thread: many commands take a
/// while, and the runtime also serves other connections.
async fn check_commands(
    check: Preflight,
    commands: Vec<Set>,
) -> magician::Result<(Vec<Set>, Duration)> {
    let checked = tokio::task::spawn_blocking(move || {
        let time = check.program(&commands)?.time();
        Ok((commands, time))
    });
    let bug = |error: tokio::task::JoinError| Error::new(ErrorCode::Closed, error.to_string());
    checked.await.map_err(bug)?
}

/// Forwards progress to a reporter.
pub(super) fn report(reporter: &Reporter, progress: Progress) {
    reporter.report(move |py| {
        let parts = (
            progress.current.0,
            progress.last.0,
            progress.sent,
            progress.total,
            progress.silent.as_secs_f64(),
        );
        Ok(parts.into_pyobject(py)?.into_any().unbind())
    });
}

/// Converts the summary of a run: number of commands, first and last index.
pub(super) fn run_summary(py: Python<'_>, ran: RunSummary) -> PyResult<Py<PyAny>> {
    let index = |index: Option<QueueIndex>| index.map(|index| index.0);
    let parts = (ran.commands, index(ran.first), index(ran.last));
    Ok(parts.into_pyobject(py)?.into_any().unbind())
}

#[pymethods]
impl Core {
    /// Checks commands, runs them and waits for their end.
    fn perform(
        &self,
        commands: &Bound<'_, PyAny>,
        skip: Vec<String>,
        require_homed: bool,
        keep: bool,
        allow_laser: bool,
    ) -> PyResult<Call> {
        let py = commands.py();
        let guards = guards(py, &skip, require_homed)?;
        let commands = self::commands(commands)?;
        let arm = self.burning(py, allow_laser)?;
        let options = RunOptions::default()
            .guards(guards)
            .keep(keep)
            .unless_stopped_since(arm.stops());
        let task = |reporter: Reporter| {
            let arm = arm.clone();
            async move {
                let on_progress = |progress| report(&reporter, progress);
                arm.run_with(&commands, options, on_progress).await
            }
        };
        Ok(Call::moving(&arm, task, run_summary))
    }

    /// Checks commands and returns their duration, s.
    fn estimate(&self, commands: &Bound<'_, PyAny>, skip: Vec<String>) -> PyResult<Call> {
        let py = commands.py();
        let guards = guards(py, &skip, false)?;
        let commands = self::commands(commands)?;
        let arm = self.arm(py)?;
        let estimate = async move {
            let check = arm.preflight_for(&commands).await?;
            check_commands(check.guards(guards), commands).await
        };
        Ok(Call::start(estimate, |py, (_, time)| {
            // `Duration::MAX` stands for a program that may never end, such as one with a trigger.
            let endless = time == Duration::MAX;
            let seconds = if endless {
                f64::INFINITY
            } else {
                time.as_secs_f64()
            };
            Ok(seconds.into_pyobject(py)?.into_any().unbind())
        }))
    }

    /// Homes the arm.
    fn home(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let homing = arm.clone();
        let task = |_| async move { homing.home().await };
        Ok(Call::moving(&arm, task, |py, ()| Ok(py.None())))
    }

    /// Returns the height of the surface that the tool touches. For a real arm it is saved.
    fn touch_off(&self, py: Python<'_>, unhomed: bool) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let arm = if unhomed { arm.allowing_unhomed() } else { arm };
        let draws = crate::calibrate::default_tool(py)?.unwrap_or(Tool::Pen);
        let touch = async move {
            let touch = touch_off(&arm, draws).await?;
            // The table of a virtual arm has nothing to do with a real one.
            if !arm.is_virtual() {
                store_surface(Some(WorkSurface::Plane(Surface::level(touch.height))))?;
            }
            Ok::<_, magician::Error>(touch.height)
        };
        Ok(Call::start(touch, |py, height| {
            Ok(height.into_pyobject(py)?.into_any().unbind())
        }))
    }

    /// Waits until a queued command has finished.
    fn wait_for(&self, py: Python<'_>, index: u64) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let waiting = arm.clone();
        let task = |reporter: Reporter| async move {
            let progress = move |progress| report(&reporter, progress);
            waiting.wait_with(QueueIndex(index), progress).await
        };
        Ok(Call::moving(&arm, task, |py, ()| Ok(py.None())))
    }

    /// Waits until the arm is at rest.
    fn wait_still(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let waiting = arm.clone();
        let task = |_| async move { waiting.wait_still().await };
        Ok(Call::moving(&arm, task, |py, ()| Ok(py.None())))
    }

    /// Stops the arm.
    fn stop(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::lasting(async move { arm.stop().await }))
    }

    /// Requests a stop without waiting.
    fn request_stop(&self, py: Python<'_>) -> PyResult<()> {
        let asked = self.arm.get(py)?.stopper().request_stop();
        asked.map_err(|error| errors::raise(py, &error))
    }

    /// Starts the queue once the arm is at rest.
    fn start_queue(&self, py: Python<'_>, allow_laser: bool) -> PyResult<Call> {
        let arm = self.burning(py, allow_laser)?;
        Ok(Call::plain(async move { arm.queue().start().await }))
    }

    /// Stops the queue after the command under way.
    fn stop_gentle(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::lasting(async move { arm.stop_gentle().await }))
    }

    /// Ends a jog.
    fn stop_jog(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::lasting(async move { arm.stop_jog().await }))
    }
}
