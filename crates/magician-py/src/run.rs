//! Plans on their way through an arm.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::DeviceTime;
use magician::words::Guards;
use magician::{Arm, Error, ErrorKind, Owed, Ran, Result, RunOptions, Set};
use magician_program::resume::Tally;
use magician_program::{Problem, Program, Report, Rest, Timetable};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tokio::sync::watch;

use crate::call::{Call, Reporter};
use crate::core::Core;
use crate::program::{PyPlan, SURFACE_ARGUMENT, Source, Start, findings, refusal};

/// The longest that is waited for a run which somebody has stopped, to give settings back.
const LEAVING: Duration = Duration::from_secs(5);

/// How a plan is run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct How {
    /// Counted from 1.
    first_step: i64,
    check: bool,
    keep: bool,
    require_homed: bool,
    allow_laser: bool,
    restore: bool,
    watched: bool,
}

impl How {
    /// The step that it begins with, counted from 0.
    fn first(&self) -> u64 {
        u64::try_from(self.first_step - 1).unwrap_or(u64::MAX)
    }
}

/// What a run has come to.
struct Done {
    ran: Ran,
    steps: u64,
    seconds: f64,
    report: Report,
}

impl Done {
    fn parts(&self, py: Python<'_>, source: &Source) -> PyResult<Py<PyAny>> {
        let parts = PyDict::new(py);
        parts.set_item("steps", self.steps)?;
        parts.set_item("commands", self.ran.commands)?;
        parts.set_item("seconds", self.seconds)?;
        parts.set_item("first_index", self.ran.first.map(|index| index.0))?;
        parts.set_item("last_index", self.ran.last.map(|index| index.0))?;
        parts.set_item("report", findings(py, &self.report, source)?)?;
        Ok(parts.into_any().unbind())
    }
}

/// A plan, an arm, and how it is run.
struct Drive {
    arm: Arm,
    program: Program,
    source: Source,
    how: How,
    reporter: Reporter,
    /// Stops of before, which are not its own.
    stops: u64,
    /// Whether it may have changed what it gives back.
    owing: watch::Sender<bool>,
}

/// What was found before anything moves.
struct Found {
    rest: Rest,
    report: Report,
    /// Only for who watches it.
    timetable: Timetable,
}

impl Drive {
    async fn run(self) -> Result<Done> {
        self.permit()?;
        let guards = Guards::default().require_homed(self.how.require_homed);
        let first: Vec<Set> = self.program.plan().commands().take(1).collect();
        self.arm.check_ready(&first, guards).await?;
        if !self.how.keep {
            // A run of nothing says whether commands of others wait: better than a check from a start that nobody knows.
            self.arm.run([], |_| {}).await?;
        }
        let found = self.look_ahead().await?;
        let mut owed = match self.how.restore {
            true => Owed::read(&self.arm, found.rest.changes()).await?,
            false => Owed::default(),
        };
        let begun = self.clock().await?;
        self.owing.send_replace(true);
        let outcome = self.perform(&found).await;
        if outcome.is_err() && self.arm.stop().await.is_ok() {
            // The error that is on its way is the better story.
            let _ = owed.give_back(&self.arm).await;
        }
        let ran = outcome?;
        owed.give_back(&self.arm).await?;
        let clock = self.clock().await?;
        Ok(Done {
            ran,
            steps: self.steps() - found.rest.from().min(self.steps()),
            seconds: f64::from(clock.wrapping_sub(begun)) / 1000.0,
            report: found.report,
        })
    }

    /// What a person has to say first.
    fn permit(&self) -> Result<()> {
        if is_virtual(&self.arm) {
            return Ok(());
        }
        if self.source.assumed {
            return Err(Error::invalid(SURFACE_ARGUMENT));
        }
        if self.program.plan().burns() && !self.how.allow_laser {
            return Err(Error::invalid(format!(
                "this burns with the laser of the arm at {}; nothing was sent: put on goggles for its wavelength, clear what \
                 must not burn, stay with it, and say allow_laser=True",
                self.arm.name()
            )));
        }
        Ok(())
    }

    /// Steps in all.
    fn steps(&self) -> u64 {
        self.program.plan().steps.len() as u64
    }

    async fn clock(&self) -> Result<u32> {
        Ok(self.arm.get::<DeviceTime>().await?.g_systick)
    }

    /// Checks it from where the arm stands. That may take a while, and others have connections to be served.
    async fn look_ahead(&self) -> Result<Found> {
        let start = self.arm.preflight_for(&self.program.kinds()).await?;
        let (program, first, watched) = (self.program.clone(), self.how.first(), self.how.watched);
        let look = move || Ok::<_, Problem>(Found::of(program.rest(first, start)?, watched));
        let found = tokio::task::spawn_blocking(look)
            .await
            .map_err(|error| Error::new(ErrorKind::Closed, error.to_string()))??;
        match refusal(&found.report, &self.source).filter(|_| self.how.check) {
            Some(refusal) => Err(refusal),
            None => Ok(found),
        }
    }

    async fn perform(&self, found: &Found) -> Result<Ran> {
        let rest = &found.rest;
        let mut tally = Tally::new(rest.lead(), true);
        let options = RunOptions::default().keep(self.how.keep);
        let run = self.arm.begin(rest.commands(), options);
        let run = run.along(rest.start().clone());
        let mut run = run.unless_stopped_since(self.stops);
        let ran = run
            .finish(|progress| {
                tally.note(progress.sent, progress.last.0);
                let done = tally.finished(progress.current.0).least;
                let left = found.timetable.left(done);
                self.reach(rest.from() + done, left, progress.silent);
            })
            .await?;
        self.reach(self.steps(), Some(Duration::ZERO), Duration::ZERO);
        Ok(ran)
    }

    /// Tells how many steps are finished, over all, how long the rest takes, and how long the arm has not answered.
    fn reach(&self, steps: u64, left: Option<Duration>, silent: Duration) {
        // How fast a virtual arm's clock runs is not known here.
        let left = left.filter(|left| left.is_zero() || !is_virtual(&self.arm));
        let left = left.map(|left| left.as_secs_f64());
        let parts = (steps, left, silent.as_secs_f64());
        self.reporter
            .report(move |py| Ok(parts.into_pyobject(py)?.into_any().unbind()));
    }
}

impl Found {
    fn of(rest: Rest, watched: bool) -> Self {
        let report = rest.check();
        let timetable = match watched {
            true => rest.timetable(&report),
            false => Timetable::default(),
        };
        Self {
            rest,
            report,
            timetable,
        }
    }
}

/// Whether it is in this process: nothing burns, and nothing is run into.
fn is_virtual(arm: &Arm) -> bool {
    arm.name() == "sim" || arm.name().starts_with("sim:")
}

#[pymethods]
impl Core {
    /// Whether it is a virtual arm in this process.
    fn is_virtual(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(is_virtual(&self.arm(py)?))
    }

    /// Asks the arm what a check of a plan depends on.
    fn start_of(&self, py: Python<'_>, plan: &PyPlan) -> PyResult<Call> {
        let (arm, plan) = (self.arm(py)?, Arc::clone(&plan.plan));
        let ask = async move { arm.preflight_for(&plan.kinds()).await };
        Ok(Call::start(ask, |py, preflight| {
            Ok(Py::new(py, Start { preflight })?.into_any())
        }))
    }

    /// Checks a plan, runs it and waits for its end. The second call ends when nothing of it is left to do: it outlives the
    /// first one, which may be let go of.
    fn run(&self, py: Python<'_>, plan: &PyPlan, how: How) -> PyResult<(Call, Call)> {
        if how.first_step < 1 {
            let error = Error::invalid("steps are counted from 1");
            return Err(crate::errors::raise(py, &error));
        }
        let (arm, source, of_report) = (self.arm(py)?, plan.source.clone(), plan.source.clone());
        let program = Program::new(Arc::clone(&plan.plan), Some(1));
        let (owing, mut owed) = watch::channel(false);
        let drive = |reporter| Drive {
            stops: arm.stops(),
            arm: arm.clone(),
            program,
            source,
            how,
            reporter,
            owing,
        };
        let task = |reporter| {
            let drive = drive(reporter);
            async move {
                // Who lets go of a run stops the arm, and then it still gives the settings back.
                let running = tokio::spawn(drive.run());
                let bug = |error: tokio::task::JoinError| {
                    Error::new(ErrorKind::Closed, error.to_string())
                };
                running.await.map_err(bug)?
            }
        };
        let call = Call::moving(&arm, task, move |py, done: Done| done.parts(py, &of_report));
        let over = async move {
            // What was stopped before anything was sent sends nothing, however long its check goes on.
            let rest = async { while *owed.borrow_and_update() && owed.changed().await.is_ok() {} };
            let _ = tokio::time::timeout(LEAVING, rest).await;
            Ok(())
        };
        let over = Call::waiting(over);
        Ok((call, over))
    }
}
