//! Runs of plans on an arm: jobs of the job engine, with Python's words.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use magician::{Action, Error, ErrorCode};
use magician_job::{
    Fault, FileJournal, JobError, JobEvent, JobHandle, JobProgress, JobSpec, JobState, JobSummary,
    JournalError, NoJournal, PauseError, PauseReason, PenLift, ResumeError, SavedSettings,
    SpeedError, Start as StartsWhere, StopOrder, StopRule, StopSignal, report,
};
use magician_program::{Ending, Program};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracing::warn;

use crate::call::{Call, Reporter};
use crate::core::Core;
use crate::errors;
use crate::program::{PyPlan, SURFACE_ARGUMENT, Source, Start, findings, refusal};
use crate::runtime::{self, Local};
use crate::serving::LOGGER;

/// Longest wait for a stopped job to lift the pen and restore settings.
const CLEANUP_TIMEOUT: Duration = Duration::from_secs(8);

/// Options of a run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct JobOptions {
    /// First step, counted from 1.
    first_step: i64,
    resume: bool,
    overlap: f64,
    check: bool,
    keep: bool,
    require_homed: bool,
    unhomed: bool,
    stay: bool,
    park: Option<[f64; 3]>,
    lift: Option<f64>,
    allow_laser: bool,
    restore: bool,
}

/// A plan under way.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Job {
    inner: Local<Inner>,
}

struct Inner {
    handle: JobHandle,
    source: Source,
    is_virtual: bool,
    /// Rule for repeated interrupts of a wait, and the time origin for it.
    stops: Mutex<StopRule>,
    begun: Instant,
}

/// Finished steps, seconds left, and seconds without a reply.
type Progress = (u64, Option<f64>, f64);

fn parts(progress: &JobProgress, is_virtual: bool) -> Progress {
    // The speed of a virtual arm's clock is unknown here, so the time left cannot be told.
    let left = progress
        .remaining
        .filter(|left| left.is_zero() || !is_virtual);
    let left = left.map(|left| left.as_secs_f64());
    (progress.step, left, progress.silent.as_secs_f64())
}

/// Converts the result of a job.
fn result_parts(py: Python<'_>, done: &JobSummary, source: &Source) -> PyResult<Py<PyAny>> {
    let parts = PyDict::new(py);
    let end = done.end.as_ref();
    let pen = end.and_then(|end| end.pen_is_up);
    parts.set_item("steps", done.steps)?;
    parts.set_item("commands", done.ran.commands)?;
    parts.set_item("seconds", done.seconds)?;
    parts.set_item("first_index", done.ran.first.map(|index| index.0))?;
    parts.set_item("last_index", done.ran.last.map(|index| index.0))?;
    parts.set_item("pen", pen.map(|up| if up { "up" } else { "down" }))?;
    parts.set_item("parked", end.is_some_and(|end| end.parked))?;
    parts.set_item("report", findings(py, &done.report, source)?)?;
    Ok(parts.into_any().unbind())
}

/// Converts the reason for which a job failed.
fn failure_reason(error: &JobError, source: &Source) -> Arc<Error> {
    let invalid = |message: String| Arc::new(Error::invalid(message));
    match &error.fault {
        Fault::Arm(error) => Arc::clone(error),
        Fault::Program(problem) if problem.lacks_surface() => invalid(SURFACE_ARGUMENT.to_owned()),
        Fault::Program(problem) => Arc::new(Error::from(problem.clone())),
        Fault::Refused { report, .. } => {
            let refusal = refusal(report, source);
            refusal.map_or_else(|| invalid(error.to_string()), Arc::new)
        }
        Fault::Stopped { .. } if error.stopped_by_line_end => {
            let message = "the station ended, and the job was stopped before its end";
            Arc::new(Error::new(ErrorCode::Stopped, message))
        }
        Fault::Stopped { .. } => {
            let message = "the job was stopped before its end";
            Arc::new(Error::new(ErrorCode::Stopped, message))
        }
        Fault::Journal(JournalError::NotFound | JournalError::OtherPrograms(_)) => invalid(
            "nothing to resume: no interrupted job of this plan, in this placement, on this arm; \
                first_step=N begins \
             at any step"
                .to_owned(),
        ),
        Fault::Doubt { span, .. } => {
            let message = format!(
                "{error}; look at the work, then first_step={} repeats them, first_step={} skips \
                    them",
                span.least + 1,
                span.most + 1
            );
            Arc::new(Error::new(ErrorCode::Uncertain, message))
        }
        Fault::StuckQueue { waiting } => {
            let message = format!(
                "{waiting} commands of the last job wait in the arm's queue, and nothing moves"
            );
            let error = Error::new(ErrorCode::ForeignCommands, message);
            let error = error.remedy(Action::ListAlarms, "shows what may hold it");
            Arc::new(error.remedy(Action::Stop, "drops them"))
        }
        _ => invalid(error.to_string()),
    }
}

/// Describes the state of the arm after a stop. `None` if there is nothing to tell.
fn stopped_state_text(error: &JobError) -> Option<String> {
    let text = match (&error.lift, &error.unconfirmed) {
        (_, Some(doubt)) => {
            format!("the arm was told to stop, but has not confirmed it: {doubt}")
        }
        (PenLift::Lifted(lifted), _) => lifted.to_string(),
        (PenLift::Failed(error), _) => format!("the pen was not lifted: {error}"),
        (PenLift::TimedOut, _) => "the pen may not be up: lifting it took too long".to_owned(),
        _ => return None,
    };
    Some(text)
}

fn pause_result(outcome: Result<(), PauseError>) -> magician::Result<()> {
    outcome.map_err(|error| Error::new(ErrorCode::RunOver, error.to_string()))
}

fn resume_result(outcome: Result<(), ResumeError>) -> Result<(), Arc<Error>> {
    outcome.map_err(|error| match error {
        ResumeError::Arm(error) | ResumeError::Refused(error) => error,
        ResumeError::Program(problem) => Arc::new(Error::from(problem)),
        error if error.wants_homing() => {
            let message = format!("{error}; the job stays paused");
            let error = Error::new(ErrorCode::PositionUnknown, message);
            Arc::new(error.remedy(Action::Home, "corrects its position"))
        }
        error => Arc::new(Error::invalid(error.to_string())),
    })
}

/// Reason of a pause, part, and text for the person.
type Pause = (&'static str, Option<u64>, Option<String>);

#[pymethods]
impl Job {
    /// Waits for its end, and reports its progress. Dropping this stops the job.
    fn outcome(&self, py: Python<'_>) -> PyResult<Call> {
        let inner = self.inner.get(py)?;
        let (source, of_report) = (inner.source.clone(), inner.source.clone());
        let (handle, stopping, is_virtual) =
            (inner.handle.clone(), inner.handle.clone(), inner.is_virtual);
        let task = |reporter: Reporter| async move {
            let tell = |progress: &JobProgress| {
                let parts = parts(progress, is_virtual);
                reporter.report(move |py| Ok(parts.into_pyobject(py)?.into_any().unbind()));
            };
            let mut events = handle.events();
            while let Some(event) = events.next().await {
                match event {
                    JobEvent::Progress(progress) => tell(&progress),
                    JobEvent::NotStored(cause) => {
                        warn!(target: LOGGER, "{}", report::not_stored_note(&cause).message);
                    }
                    _ => {}
                }
            }
            handle
                .outcome()
                .await
                .map_err(|error| failure_reason(&error, &source))
        };
        let convert =
            move |py: Python<'_>, done: Arc<JobSummary>| result_parts(py, &done, &of_report);
        Ok(Call::under_way(move || stopping.stop(), task, convert))
    }

    /// Waits for the cleanup of a stopped job. Returns the state of the arm as text, or `None` if
    /// there is nothing to report.
    fn over(&self, py: Python<'_>) -> PyResult<Call> {
        let handle = self.inner.get(py)?.handle.clone();
        Ok(Call::waiting(async move {
            let outcome = tokio::time::timeout(CLEANUP_TIMEOUT, handle.outcome()).await;
            Ok(match outcome {
                Ok(Err(error)) => stopped_state_text(&error),
                _ => None,
            })
        }))
    }

    /// Pauses the job.
    fn pause(&self, py: Python<'_>) -> PyResult<Call> {
        let pause = self.inner.get(py)?.handle.pause(PauseReason::Person);
        Ok(Call::plain(async move { pause_result(pause.await) }))
    }

    /// Waits until the job is paused or over. Returns the message for the operator, if the plan has
    /// one.
    fn paused(&self, py: Python<'_>) -> PyResult<Call> {
        let handle = self.inner.get(py)?.handle.clone();
        let wait = async move {
            let mut events = handle.events();
            loop {
                match handle.state() {
                    JobState::Paused { .. } => {
                        let text = handle.pause_text().map(|text| text.to_string());
                        return Ok::<_, Error>(Some(text.unwrap_or_default()));
                    }
                    JobState::Ended => return Ok(None),
                    _ => drop(events.next().await),
                }
            }
        };
        Ok(Call::waiting(wait))
    }

    /// Reason of the pause, and message for the operator.
    fn pause_reason(&self, py: Python<'_>) -> PyResult<Option<Pause>> {
        let handle = &self.inner.get(py)?.handle;
        let JobState::Paused { reason, part } = handle.state() else {
            return Ok(None);
        };
        let text = handle.pause_text().map(|text| text.to_string());
        Ok(Some((reason.name(), part, text)))
    }

    /// Resumes the job.
    fn resume(&self, py: Python<'_>) -> PyResult<Call> {
        let resume = self.inner.get(py)?.handle.resume();
        let resume = async move { resume_result(resume.await) };
        Ok(Call::start(resume, |py, ()| Ok(py.None())))
    }

    /// Handles an interrupt (Ctrl-C) of a wait. A second interrupt stops the job at once, unless it
    /// follows too soon to be deliberate.
    fn interrupted(&self, py: Python<'_>) -> PyResult<()> {
        let inner = self.inner.get(py)?;
        let mut stops = inner.stops.lock().unwrap_or_else(PoisonError::into_inner);
        let order = stops.order_for(StopSignal::Interrupt, inner.begun.elapsed());
        // The first interrupt has already stopped the job, by dropping the wait.
        if order == Some(StopOrder::Halt) {
            inner.handle.stop();
        }
        Ok(())
    }

    /// Stops the job.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        self.inner.get(py)?.handle.stop();
        Ok(())
    }

    /// Sets the speed of unsent commands, percent of the planned speed.
    fn set_speed(&self, py: Python<'_>, percent: u8) -> PyResult<()> {
        let set = self.inner.get(py)?.handle.set_speed(percent);
        set.map_err(|error| {
            let code = match error {
                SpeedError::Ending | SpeedError::Ended => ErrorCode::RunOver,
                _ => ErrorCode::InvalidValue,
            };
            errors::raise(py, &Error::new(code, error.to_string()))
        })
    }

    /// Speed of unsent commands, percent of the planned speed.
    fn speed(&self, py: Python<'_>) -> PyResult<u8> {
        Ok(self.inner.get(py)?.handle.speed())
    }

    /// Current phase of the job.
    fn state(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(self.inner.get(py)?.handle.state().name())
    }

    /// Current progress.
    fn progress(&self, py: Python<'_>) -> PyResult<Progress> {
        let inner = self.inner.get(py)?;
        Ok(parts(&inner.handle.progress(), inner.is_virtual))
    }
}

#[pymethods]
impl Core {
    /// True for an in-process virtual arm.
    fn is_virtual(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.arm(py)?.is_virtual())
    }

    /// Reads the arm state that the check of a plan depends on.
    fn start_of(&self, py: Python<'_>, plan: &PyPlan) -> PyResult<Call> {
        let (arm, plan) = (self.arm(py)?, Arc::clone(&plan.plan));
        let ask = async move { arm.preflight_for(&plan.kinds()).await };
        Ok(Call::start(ask, |py, preflight| {
            Ok(Py::new(py, Start { preflight })?.into_any())
        }))
    }

    /// Starts a plan as a job.
    fn start(&self, py: Python<'_>, plan: &PyPlan, options: JobOptions) -> PyResult<Job> {
        let raise = |error: Error| Err(errors::raise(py, &error));
        let Ok(first) = u64::try_from(options.first_step - 1) else {
            return raise(Error::invalid("steps are counted from 1"));
        };
        let arm = self.burning(py, options.allow_laser)?;
        let arm = if options.unhomed {
            arm.allowing_unhomed()
        } else {
            arm
        };
        let (source, is_virtual) = (plan.source.clone(), arm.is_virtual());
        let mut ending = Ending::default();
        (ending.stay, ending.park) = (options.stay, options.park);
        ending.drawing = source.is_drawing;
        ending.lift = options.lift.or(source.lift).unwrap_or(ending.lift);
        let stays = options.stay && ending.draws(&plan.plan);
        let program = Program::new(Arc::clone(&plan.plan), Some(1)).pen_stays_down(stays);
        let spec = JobSpec::new(program)
            .ending(ending)
            .start(if options.resume {
                StartsWhere::Resume
            } else {
                StartsWhere::Step(first)
            })
            .overlap(options.overlap)
            .origin(source.name.clone().unwrap_or_default())
            .keep(options.keep)
            .require_homed(options.require_homed)
            .assumes_surface(source.assumed)
            .check(options.check)
            .index_may_skip(true)
            .saved(options.restore.then(SavedSettings::default));
        let started = runtime::within(|| {
            // A virtual arm in this process ends with it, so its jobs cannot be resumed later.
            if arm.front_end().is_in_process() {
                magician_job::Job::start(&arm, spec, NoJournal)
            } else {
                magician_job::Job::start(&arm, spec, FileJournal::new())
            }
        });
        let Some(handle) = started else {
            return raise(Error::new(ErrorCode::Closed, "the connection is closed"));
        };
        let inner = Inner {
            handle,
            source,
            is_virtual,
            stops: Mutex::default(),
            begun: Instant::now(),
        };
        Ok(Job {
            inner: Local::new(inner),
        })
    }
}
