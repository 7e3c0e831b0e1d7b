//! A program on its way through an arm, and what is left when it ends badly.

use std::cell::RefCell;
use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use magician::commands::{DeviceSn, DeviceTime, Pose};
use magician::words::Guards;
use magician::{Arm, ErrorKind, Owed, Progress, Ran, RunOptions, Set};
use magician_program::resume::{Mark, Tally};
use magician_program::{Report, Rest, Timetable};

use super::journal::Journal;
use super::tell::Teller;
use super::{Made, needs_start, report};
use crate::debts::{Access, Debts};
use crate::failure::{Failure, Kind};
use crate::output::{Output, Paint};
use crate::recording::{Clock, Options, Recorder};

/// Readings of a recording for a second of the arm's clock, and the most for one of ours.
const RATE: f64 = 20.0;
const MOST: f64 = 500.0;

/// What is to run, and how.
pub(super) struct Drive<'a> {
    pub(super) made: &'a Made,
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    pub(super) keep: bool,
    /// The driver may put commands of its own between those of the program, or pass over indices.
    pub(super) mixed: bool,
    pub(super) require_homed: bool,
    /// Whether an arm that was not homed is refused, because of what the program is.
    pub(super) refuses_unhomed: bool,
    pub(super) record: Option<&'a Path>,
    pub(super) json: bool,
    /// Whether the arm outlives this program.
    pub(super) lasting: bool,
    /// How fast the arm's clock runs, if that is known.
    pub(super) pace: Option<f64>,
    pub(super) state: RefCell<State>,
}

/// What must be known after the run was given up in its middle.
#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) journal: Option<Journal>,
    pub(super) tally: Tally,
    /// Commands taken from the program.
    pub(super) pulled: u64,
    /// What is run.
    pub(super) rest: Option<Rest>,
    /// How far the pen goes up when the run is stopped now, mm.
    pub(super) lift: Option<f64>,
    /// How to go on, once that is known.
    pub(super) advice: Option<String>,
}

/// What a run has come to.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) ran: Ran,
    /// The first step, from 0.
    pub(super) from: u64,
    /// Seconds of the arm's clock.
    pub(super) seconds: f64,
    pub(super) report: Report,
    pub(super) end: Option<End>,
    /// Why the recording that was asked for is not whole.
    pub(super) unrecorded: Option<Failure>,
}

/// How the tool stands when all is done, where something is made of that.
#[derive(Debug)]
pub(super) struct End {
    pub(super) pose: Pose,
    /// Whether the pen of a drawing is up.
    pub(super) up: Option<bool>,
    pub(super) parked: bool,
}

/// What was found before anything moves.
struct Ahead {
    rest: Rest,
    timetable: Timetable,
    begun: Begun,
    /// Steps that are, for who keeps the poses.
    finished: Arc<AtomicU64>,
}

/// When a run began, by our clock and by the arm's, ms.
#[derive(Clone, Copy)]
struct Begun {
    wall: Instant,
    clock: u32,
}

impl State {
    /// The first step, over all rounds.
    pub(super) fn from(&self) -> u64 {
        self.rest.as_ref().map_or(0, Rest::from)
    }
}

impl Drive<'_> {
    /// Runs it to its end.
    pub(super) async fn run(
        &self,
        arm: &Arm,
        out: &mut Output,
        debts: &Debts,
    ) -> Result<Done, Failure> {
        let guards = Guards::default().require_homed(self.require_homed);
        let first: Vec<Set> = self.made.program.plan().commands().take(1).collect();
        if self.resume && self.made.program.plan().burns() {
            // A run that died may have left it burning.
            arm.darken().await?;
            arm.stop_gentle().await?;
            arm.clear_queue().await?;
        }
        if self.refuses_unhomed {
            arm.check_homed().await?;
        }
        arm.check_ready(&first, guards).await?;
        let mut journal = self.journal(arm).await;
        let (from, within) = match (self.resume, self.from) {
            (true, _) => self.resumed(arm, &journal).await?,
            (false, from) => (from.map_or(0, |step| step - 1), None),
        };
        if self.made.start.is_some() && self.made.program.depends_on_start(from) {
            return Err(needs_start());
        }
        let settled = Debts::settle(arm, Access::Sets).await;
        out.settled(&settled, self.json);
        if !self.keep {
            // A run of nothing says whether commands of others wait: better than a check from a start that nobody knows.
            arm.run([], |_| {}).await?;
        }
        let begun = Begun::now(arm).await?;
        journal.begins((from, within), begun.clock, at_rest(arm).await?);
        let rests_at = journal.mark.rest;
        let start = arm.preflight_for(&self.made.program.kinds()).await?;
        let rest = self.made.program.rest_within(from, within, start);
        let rest = rest.map_err(|problem| self.made.source.failure(&problem))?;
        let report = rest.check();
        if !report.is_good() {
            let way_out = self.made.way_out(&rest);
            return Err(report::failure(self.made, &report, false, way_out));
        }
        self.made.ending.check(&rest)?;
        let ahead = Ahead {
            timetable: rest.timetable(&report),
            begun,
            finished: Arc::new(AtomicU64::new(from)),
            rest,
        };
        let recorder = match self.record {
            Some(path) => Some(self.recorder(arm, path, &ahead.finished).await),
            None => None,
        };
        let (recorder, full) = match recorder.transpose() {
            Ok(recorder) => (recorder, None),
            // The file is there and takes nothing: a full disk costs the recording, not the work.
            Err(failure) if failure.kind == Kind::Driver(ErrorKind::Closed) => {
                (None, Some(failure))
            }
            Err(failure) => return Err(failure),
        };
        let owed = Owed::read(arm, ahead.rest.changes()).await?;
        debts.owe_all(arm, owed).await;
        *self.state.borrow_mut() = State {
            journal: Some(journal),
            tally: Tally::new(ahead.rest.lead(), self.passes_over(arm)).from_rest(rests_at),
            pulled: 0,
            rest: Some(ahead.rest.clone()),
            lift: self.made.ending.after_stop(self.made.program.plan()),
            advice: None,
        };
        let teller = Teller::new(out, self.json, self.made.program.steps());
        if from > 0 {
            teller.say(&format!("beginning at step {}{}", from + 1, self.of()));
        }
        if let Some(full) = &full {
            teller.say(&unrecorded(full));
        }
        let ran = self.perform(arm, &ahead, &teller, recorder).await;
        drop(teller);
        let (ran, broken) = match ran {
            Ok(ran) => ran,
            Err(failure) => return Err(self.fails(arm, failure).await),
        };
        // What follows waits as long as the run did.
        let arm = &arm.patient(RunOptions::default().patience);
        let seconds = ahead.begun.seconds(arm).await?;
        if let Some(journal) = self.state.borrow_mut().journal.take() {
            journal.remove();
        }
        let end = self.ends(arm).await.map_err(|mut failure| {
            failure.message = format!("all steps are done, and then: {}", failure.message);
            failure
        })?;
        debts.pay(arm).await?;
        Ok(Done {
            ran,
            from,
            seconds,
            report,
            end,
            unrecorded: full.or(broken),
        })
    }

    /// All is done: the pen goes up as far as the program has not lifted it, and the tool to where it is parked.
    async fn ends(&self, arm: &Arm) -> Result<Option<End>, Failure> {
        let (plan, ending) = (self.made.program.plan(), &self.made.ending);
        if !ending.draws(plan) && ending.park.is_none() {
            return Ok(None);
        }
        let mut pose = arm.get::<Pose>().await?;
        let up = ending.after_done(plan, [pose.x, pose.y, pose.z].map(f64::from));
        // Who stops the arm from here on finds a pen that has to go up so far only.
        self.state.borrow_mut().lift = up;
        if let Some(up) = up {
            pose = arm.lift(up).await?.pose;
            self.state.borrow_mut().lift = None;
        }
        if let Some(place) = ending.park {
            pose = arm.park(place).await?;
        }
        Ok(Some(End {
            pose,
            up: ending.draws(plan).then_some(!ending.stay),
            parked: ending.park.is_some(),
        }))
    }

    /// `of 800`.
    pub(super) fn of(&self) -> String {
        self.made
            .program
            .steps()
            .map(|steps| format!(" of {steps}"))
            .unwrap_or_default()
    }

    /// Whether indices may be passed over: the driver may put commands of its own between those of the program, and a line
    /// that doubles what it carries does.
    fn passes_over(&self, arm: &Arm) -> bool {
        self.mixed || !arm.keeps_order()
    }

    /// What is kept of it for one that goes on with it.
    async fn journal(&self, arm: &Arm) -> Journal {
        let serial = arm.get::<DeviceSn>().await;
        let serial = serial
            .map(|serial| serial.device_sn.to_string())
            .unwrap_or_default();
        let name = match (self.lasting, serial.trim()) {
            (false, _) => "virtual",
            (true, "") => arm.name(),
            (true, serial) => serial,
        };
        let title = &self.made.program.plan().title;
        let mark = Mark::new(title, self.made.program.steps(), self.passes_over(arm));
        Journal::new(&self.made.program.key(), name, mark, self.lasting)
    }

    async fn perform(
        &self,
        arm: &Arm,
        ahead: &Ahead,
        teller: &Teller<'_>,
        mut recorder: Option<Recorder>,
    ) -> Result<(Ran, Option<Failure>), Failure> {
        let rest = &ahead.rest;
        let commands = rest.commands().inspect(|_| self.pulls(rest.lead()));
        let options = RunOptions::default().keep(self.keep);
        let mut run = arm.begin(commands, options).along(rest.start().clone());
        let run = run.finish(|progress| {
            let done = self.reached(&progress, ahead.begun);
            ahead.finished.store(done, Ordering::Relaxed);
            let left = ahead.timetable.left(done.saturating_sub(rest.from()));
            let left = left.and_then(|left| self.of_wall(left));
            teller.at(done, left, progress.silent);
        });
        // A recording that cannot go on costs itself, and never the work.
        let mut broken = None;
        let watch = async {
            if let Some(recording) = &mut recorder {
                let failure = recording.failed().await;
                teller.say(&unrecorded(&failure));
                recorder = None;
                broken = Some(failure);
            }
            std::future::pending::<Infallible>().await
        };
        let ran = tokio::select! {
            biased;
            ran = run => ran.map_err(Failure::from),
            never = watch => match never {},
        };
        if let Some(recorder) = recorder {
            broken = recorder.finish().await.err();
        }
        Ok((ran?, broken))
    }

    /// What keeps the poses, on the arm's clock: a virtual one may be faster than ours.
    async fn recorder(
        &self,
        arm: &Arm,
        path: &Path,
        finished: &Arc<AtomicU64>,
    ) -> Result<Recorder, Failure> {
        let options = Options {
            clock: Clock::Arm,
            steps: Some(Arc::clone(finished)),
            ..Options::at((RATE * self.pace.unwrap_or(1.0)).clamp(RATE, MOST))
        };
        Recorder::begin(arm, path, options).await
    }

    /// A time of the arm's clock as a person waits for it; nobody can tell where it runs as fast as it can.
    fn of_wall(&self, time: Duration) -> Option<Duration> {
        match self.pace {
            None => Some(time),
            Some(pace) => pace.is_finite().then(|| time.div_f64(pace.max(1e-3))),
        }
    }

    /// The next command is about to go out.
    fn pulls(&self, lead: u64) {
        let mut state = self.state.borrow_mut();
        state.pulled += 1;
        let steps = state.from() + state.pulled.saturating_sub(lead);
        if let Some(journal) = &mut state.journal {
            journal.hands(steps);
        }
    }

    /// So much has been sent and finished; the steps that are.
    fn reached(&self, progress: &Progress, begun: Begun) -> u64 {
        let mut state = self.state.borrow_mut();
        let from = state.from();
        state.tally.note(progress.sent, progress.last.0);
        let finished = from + state.tally.finished(progress.current.0).least;
        let last = state.tally.last();
        let index = last.map(|(index, steps)| (index, from + steps));
        if let Some(journal) = &mut state.journal {
            journal.mark.clock = begun.clock_at_least();
            journal.reached(finished, index);
        }
        finished
    }
}

/// A recording has ended before the work.
fn unrecorded(failure: &Failure) -> String {
    let warning = Paint::for_stderr().note("warning:").to_string();
    format!(
        "{warning} the recording ends here, the work goes on: {}",
        failure.message
    )
}

/// The index that the arm has finished last, if its queue is empty.
async fn at_rest(arm: &Arm) -> Result<Option<u64>, Failure> {
    let (_, places) = arm.stats().await?;
    let empty = arm.left_space().await? >= places;
    let index = arm.current_index().await?.0;
    Ok(empty.then_some(index))
}

impl Begun {
    async fn now(arm: &Arm) -> Result<Self, Failure> {
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        let wall = Instant::now();
        Ok(Self { wall, clock })
    }

    /// What the arm's clock shows by now, at least: it may be an eighth slower than ours.
    fn clock_at_least(self) -> u32 {
        let elapsed = u32::try_from(self.wall.elapsed().as_millis()).unwrap_or(u32::MAX);
        self.clock.saturating_add(elapsed - elapsed / 8)
    }

    /// Seconds since then by the arm's clock.
    async fn seconds(self, arm: &Arm) -> Result<f64, Failure> {
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        Ok(f64::from(clock.wrapping_sub(self.clock)) / 1000.0)
    }
}
