//! A program on its way through an arm, and what is left when it ends badly.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use magician::commands::{DeviceSn, DeviceTime};
use magician::words::Guards;
use magician::{Arm, Owed, Progress, Ran, RunOptions, Set};
use magician_program::resume::{Mark, Tally};
use magician_program::{Program, Report, Rest, Timetable};

use super::journal::Journal;
use super::report;
use super::tell::Teller;
use crate::debts::Debts;
use crate::failure::Failure;
use crate::output::Output;
use crate::recording::{Clock, Options, Recorder};
use crate::source::Source;

/// Readings of a recording for a second of the arm's clock, and the most for one of ours.
const RATE: f64 = 20.0;
const MOST: f64 = 500.0;

/// What is to run, and how.
pub(super) struct Drive<'a> {
    pub(super) source: &'a Source,
    pub(super) program: &'a Program,
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    /// Where the program was begun, if that has to be said when it goes on.
    pub(super) start: Option<[f64; 3]>,
    pub(super) keep: bool,
    /// The driver may put commands of its own between those of the program, or pass over indices.
    pub(super) mixed: bool,
    pub(super) require_homed: bool,
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
        let first: Vec<Set> = self.program.plan().commands().take(1).collect();
        arm.check_ready(&first, guards).await?;
        let mut journal = self.journal(arm).await;
        let from = match (self.resume, self.from) {
            (true, _) => self.resumed(arm, &journal).await?,
            (false, from) => from.map_or(0, |step| step - 1),
        };
        if !self.keep {
            // A run of nothing says whether commands of others wait: better than a check from a start that nobody knows.
            arm.run([], |_| {}).await?;
        }
        let begun = Begun::now(arm).await?;
        journal.begins(from, begun.clock);
        let start = arm.preflight_for(&self.program.kinds()).await?;
        let rest = self.program.rest(from, start);
        let rest = rest.map_err(|problem| self.source.failure(&problem))?;
        let report = rest.check();
        if !report.is_good() {
            return Err(report::failure(&report, self.source, false));
        }
        let ahead = Ahead {
            timetable: rest.timetable(&report),
            begun,
            finished: Arc::new(AtomicU64::new(from)),
            rest,
        };
        let recorder = match self.record {
            Some(path) => Some(self.recorder(arm, path, &ahead.finished).await?),
            None => None,
        };
        debts.owe_all(Owed::read(arm, ahead.rest.changes()).await?);
        *self.state.borrow_mut() = State {
            journal: Some(journal),
            tally: Tally::new(ahead.rest.lead(), self.mixed),
            pulled: 0,
            rest: Some(ahead.rest.clone()),
        };
        let teller = Teller::new(out, self.json, self.program.steps());
        if from > 0 {
            teller.say(&format!("beginning at step {}{}", from + 1, self.of()));
        }
        let ran = self.perform(arm, &ahead, &teller, recorder).await;
        drop(teller);
        let ran = match ran {
            Ok(ran) => ran,
            Err(failure) => return Err(self.fails(arm, failure).await),
        };
        debts.pay(arm).await?;
        if let Some(journal) = &self.state.borrow().journal {
            journal.remove();
        }
        Ok(Done {
            ran,
            from,
            seconds: ahead.begun.seconds(arm).await?,
            report,
        })
    }

    /// `of 800`.
    pub(super) fn of(&self) -> String {
        self.program
            .steps()
            .map(|steps| format!(" of {steps}"))
            .unwrap_or_default()
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
        let title = &self.program.plan().title;
        let mark = Mark::new(title, self.program.steps(), self.mixed);
        Journal::new(&self.program.key(), name, mark, self.lasting)
    }

    async fn perform(
        &self,
        arm: &Arm,
        ahead: &Ahead,
        teller: &Teller<'_>,
        mut recorder: Option<Recorder>,
    ) -> Result<Ran, Failure> {
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
        let watch = async {
            match &mut recorder {
                Some(recorder) => recorder.failed().await,
                None => std::future::pending().await,
            }
        };
        let ran = tokio::select! {
            biased;
            ran = run => ran.map_err(Failure::from),
            failure = watch => return Err(failure),
        };
        let recorded = match recorder {
            Some(recorder) => recorder.finish().await.map(drop),
            None => Ok(()),
        };
        let ran = ran?;
        recorded.map(|()| ran)
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
