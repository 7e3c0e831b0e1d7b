//! Plans on their way through an arm.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician::commands::{DeviceTime, Pose};
use magician::words::Guards;
use magician::{Arm, Error, ErrorKind, Owed, Ran, Result, RunOptions, Set};
use magician_program::resume::Tally;
use magician_program::{Ending, Problem, Program, Report, Rest, Timetable};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tokio::sync::watch;

use crate::call::{Call, Reporter};
use crate::core::Core;
use crate::program::{PyPlan, SURFACE_ARGUMENT, Source, Start, findings, refusal};
use crate::wording::for_python;

/// The longest that is waited for a run which somebody has stopped, to lift the pen and give settings back.
const LEAVING: Duration = Duration::from_secs(8);

/// How a plan is run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct How {
    /// Counted from 1.
    first_step: i64,
    check: bool,
    keep: bool,
    require_homed: bool,
    unhomed: bool,
    stay: bool,
    park: Option<[f64; 3]>,
    lift: Option<f64>,
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
    /// Whether the pen of a drawing is up.
    pen_is_up: Option<bool>,
    parked: bool,
}

impl Done {
    fn parts(&self, py: Python<'_>, source: &Source) -> PyResult<Py<PyAny>> {
        let parts = PyDict::new(py);
        parts.set_item("steps", self.steps)?;
        parts.set_item("commands", self.ran.commands)?;
        parts.set_item("seconds", self.seconds)?;
        parts.set_item("first_index", self.ran.first.map(|index| index.0))?;
        parts.set_item("last_index", self.ran.last.map(|index| index.0))?;
        parts.set_item(
            "pen",
            self.pen_is_up.map(|up| if up { "up" } else { "down" }),
        )?;
        parts.set_item("parked", self.parked)?;
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
    ending: Ending,
    /// Stops of before, which are not its own.
    stops: u64,
    /// Whether nobody waits for its end any more.
    left: Arc<AtomicBool>,
    /// What became of the arm after a stop.
    said: Arc<Mutex<Option<String>>>,
    /// Whether it may have changed what it gives back.
    owing: watch::Sender<bool>,
}

/// Notes that nobody waits for a run any more, when it is dropped before the run has ended.
struct Leaving {
    left: Arc<AtomicBool>,
    has_ended: bool,
}

impl Drop for Leaving {
    fn drop(&mut self) {
        if !self.has_ended {
            self.left.store(true, Ordering::SeqCst);
        }
    }
}

/// What was found before anything moves.
struct Found {
    rest: Rest,
    report: Report,
    /// Only for who watches it.
    timetable: Timetable,
}

/// What must be known of a run that is given up in its middle.
struct UnderWay {
    tally: Tally,
    /// How far the pen goes up then, mm.
    lift: Option<f64>,
}

impl Drive {
    async fn run(self) -> Result<Done> {
        self.permit()?;
        if self.source.needs_homed_arm && !self.how.unhomed && !self.arm.is_virtual() {
            self.arm.check_homed().await?;
        }
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
        let mut under_way = UnderWay {
            tally: Tally::new(found.rest.lead(), true),
            lift: self.ending.after_stop(self.program.plan()),
        };
        let done = self.perform_to_the_end(&found, begun, &mut under_way);
        let outcome = done.await;
        if let Err(error) = &outcome {
            // The error that is on its way is the better story.
            match self.arm.stop().await {
                Ok(()) => {
                    self.lift_after(error, &found, &under_way).await;
                    let _ = owed.give_back(&self.arm).await;
                }
                Err(doubt) => self.say(format!(
                    "the arm was told to stop, and it is not certain that it does: {doubt}"
                )),
            }
        }
        let (ran, seconds) = outcome?;
        owed.give_back(&self.arm.patient(RunOptions::default().patience))
            .await?;
        let draws = self.ending.draws(self.program.plan());
        Ok(Done {
            ran,
            steps: self.steps() - found.rest.from().min(self.steps()),
            seconds,
            report: found.report,
            pen_is_up: draws.then_some(!self.ending.stay),
            parked: self.ending.park.is_some(),
        })
    }

    /// Runs it, lifts the pen as far as the plan has not, and parks the tool.
    async fn perform_to_the_end(
        &self,
        found: &Found,
        begun: u32,
        under_way: &mut UnderWay,
    ) -> Result<(Ran, f64)> {
        let ran = self.perform(found, &mut under_way.tally).await?;
        // What follows waits as long as the run did.
        let arm = self.arm.patient(RunOptions::default().patience);
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        let seconds = f64::from(clock.wrapping_sub(begun)) / 1000.0;
        let pose = arm.get::<Pose>().await?;
        let at = [pose.x, pose.y, pose.z].map(f64::from);
        under_way.lift = self.ending.after_done(self.program.plan(), at);
        if let Some(up) = under_way.lift {
            arm.lift(up).await?;
            under_way.lift = None;
        }
        if let Some(place) = self.ending.park {
            arm.park(place).await?;
        }
        Ok((ran, seconds))
    }

    /// The pen of a drawing that was stopped goes up, unless something else than the end of the waiting has stopped the arm.
    async fn lift_after(&self, error: &Error, found: &Found, under_way: &UnderWay) {
        let wanted = self.left.load(Ordering::SeqCst) || error.kind().lifts();
        let Some(height) = under_way.lift.filter(|_| wanted) else {
            return;
        };
        let stands = async {
            let pose = self.arm.get::<Pose>().await?;
            Ok::<_, Error>((self.arm.current_index().await?.0, pose))
        };
        let has_moved = |(index, pose)| found.rest.has_moved(&under_way.tally, index, &pose);
        if !stands.await.map_or(true, has_moved) {
            return;
        }
        self.say(match self.arm.lift(height).await {
            Ok(lifted) => lifted.to_string(),
            Err(error) => format!("the pen was not lifted: {error}"),
        });
    }

    fn say(&self, said: String) {
        let mut place = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        *place = Some(for_python(&said));
    }

    /// What a person has to say first.
    fn permit(&self) -> Result<()> {
        if self.arm.is_virtual() {
            return Ok(());
        }
        if self.source.assumed {
            return Err(Error::invalid(SURFACE_ARGUMENT));
        }
        // The handle may burn if that was allowed.
        let commands: Vec<Set> = self.program.plan().commands().collect();
        self.arm.permit(&commands)
    }

    /// Steps in all.
    fn steps(&self) -> u64 {
        self.program.steps().unwrap_or_default()
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
            None => {
                self.ending.check(&found.rest)?;
                Ok(found)
            }
        }
    }

    async fn perform(&self, found: &Found, tally: &mut Tally) -> Result<Ran> {
        let rest = &found.rest;
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
        let left = left.filter(|left| left.is_zero() || !self.arm.is_virtual());
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

#[pymethods]
impl Core {
    /// Whether it is a virtual arm in this process.
    fn is_virtual(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.arm(py)?.is_virtual())
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
        let arm = self.burning(py, how.allow_laser)?;
        let (source, of_report) = (plan.source.clone(), plan.source.clone());
        let mut ending = Ending::default();
        (ending.stay, ending.park) = (how.stay, how.park);
        ending.drawing = source.needs_homed_arm;
        ending.lift = how.lift.or(source.lift).unwrap_or(ending.lift);
        let stays = how.stay && ending.draws(&plan.plan);
        let program = Program::new(Arc::clone(&plan.plan), Some(1)).pen_stays_down(stays);
        let (left, said) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let (leaving, telling) = (Arc::clone(&left), Arc::clone(&said));
        let (owing, mut owed) = watch::channel(false);
        let drive = |reporter| Drive {
            stops: arm.stops(),
            arm: arm.clone(),
            program,
            source,
            how,
            reporter,
            owing,
            ending,
            left,
            said,
        };
        let task = |reporter| {
            let drive = drive(reporter);
            async move {
                // Who lets go of a run stops the arm, and then it still lifts the pen and gives the settings back.
                let mut leaving = Leaving {
                    left: leaving,
                    has_ended: false,
                };
                let running = tokio::spawn(drive.run());
                let bug = |error: tokio::task::JoinError| {
                    Error::new(ErrorKind::Closed, error.to_string())
                };
                let done = running.await.map_err(bug)?;
                leaving.has_ended = true;
                done
            }
        };
        let call = Call::moving(&arm, task, move |py, done: Done| done.parts(py, &of_report));
        let over = async move {
            // What was stopped before anything was sent sends nothing, however long its check goes on.
            let rest = async { while *owed.borrow_and_update() && owed.changed().await.is_ok() {} };
            let _ = tokio::time::timeout(LEAVING, rest).await;
            let said = telling
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .take();
            Ok(said)
        };
        let over = Call::waiting(over);
        Ok((call, over))
    }
}
