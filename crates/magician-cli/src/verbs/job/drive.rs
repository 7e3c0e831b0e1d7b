//! A program on its way through an arm, and what is left when it ends badly.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use magician::commands::{DeviceSn, DeviceTime, Pose};
use magician::words::{Guards, Preflight};
use magician::{Arm, Error, ErrorKind, Ran, RunOptions, Set};
use magician_program::Report;
use magician_program::resume::{Mark, Seen, Span, Tally, Verdict, settle};
use tokio::time::{sleep, timeout};

use super::journal::Journal;
use super::owed::owe;
use super::program::{Program, Rest};
use super::report;
use super::tell::Teller;
use crate::context::Stood;
use crate::debts::Debts;
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::progress::attended;
use crate::recording::{Clock, Options, Recorder};
use crate::source::Source;

/// How far from where it should an arm may stand, mm.
const NEAR: f64 = 0.5;
/// How long an arm that failed is asked how it stands.
const AFTERMATH: Duration = Duration::from_secs(3);
/// Readings of a recording for a second of the arm's clock, and the most for one of ours.
const RATE: f64 = 20.0;
const MOST: f64 = 500.0;
/// Between two looks at an arm that still has something to do.
const LOOKS: Duration = Duration::from_millis(100);
/// A queue that stands for so long does not go on by itself.
const STANDING: Duration = Duration::from_secs(3);

/// What is to run, and how.
pub(super) struct Drive<'a> {
    pub(super) source: &'a Source,
    pub(super) program: &'a Program,
    /// What the arm is told before the first step, besides what the plan says.
    pub(super) settings: &'a [Set],
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    pub(super) keep: bool,
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
    journal: Option<Journal>,
    tally: Tally,
    /// The first step, over all loops.
    from: u64,
    /// Commands taken from the program.
    pulled: u64,
    /// Where the run began.
    start: Option<Preflight>,
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

impl Drive<'_> {
    /// Runs it to its end.
    pub(super) async fn run(
        &self,
        arm: &Arm,
        out: &mut Output,
        debts: &Debts,
    ) -> Result<Done, Failure> {
        let guards = Guards::default().require_homed(self.require_homed);
        let first: Vec<Set> = self.program.plan.commands().take(1).collect();
        arm.check_alarms(&first, guards).await?;
        let serial = arm.get::<DeviceSn>().await;
        let serial = serial
            .map(|serial| serial.device_sn.to_string())
            .unwrap_or_default();
        let name = match (self.lasting, serial.trim()) {
            (false, _) => "virtual",
            (true, "") => arm.name(),
            (true, serial) => serial,
        };
        let mark = Mark::new(
            &self.program.plan.title,
            self.program.steps(),
            self.program.burns(),
        );
        let mut journal = Journal::new(&self.program.key(), name, mark, self.lasting);
        let from = match (self.resume, self.from) {
            (true, _) => self.resumed(arm, &journal).await?,
            (false, from) => from.map_or(0, |step| step - 1),
        };
        journal.mark.finished = from;
        journal.mark.handed = from;
        journal.mark.clock = arm.get::<DeviceTime>().await?.g_systick;
        let begun = (Instant::now(), journal.mark.clock);
        let start = arm.preflight_for(&self.kinds()).await?;
        let told = self.told(&start)?;
        let rest = self.rest(from, &told)?;
        let report = self.program.check(&rest, &told);
        if !report.is_good() {
            return Err(report::failure(&report, self.source, rest.offset(), false));
        }
        let finished = Arc::new(AtomicU64::new(from));
        let recorder = match self.record {
            Some(path) => Some(self.recorder(arm, path, &finished).await?),
            None => None,
        };
        owe(
            arm,
            debts,
            self.settings.iter().chain(self.program.plan.settings()),
        )
        .await?;
        *self.state.borrow_mut() = State {
            journal: Some(journal),
            tally: Tally::new(self.lead(&rest), self.program.burns()),
            from,
            pulled: 0,
            start: Some(start.clone()),
        };
        let teller = Teller::new(out, self.json, self.program.steps());
        if from > 0 {
            teller.say(&format!("beginning at step {}{}", from + 1, self.of()));
        }
        let ran = self
            .perform(
                arm, &rest, start, &report, &teller, begun, &finished, recorder,
            )
            .await;
        drop(teller);
        let ran = match ran {
            Ok(ran) => ran,
            Err(failure) => return Err(self.fails(arm, failure).await),
        };
        debts.pay(arm).await?;
        if let Some(journal) = &self.state.borrow().journal {
            journal.remove();
        }
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        Ok(Done {
            ran,
            from,
            seconds: f64::from(clock.wrapping_sub(begun.1)) / 1000.0,
            report,
        })
    }

    /// `of 800`.
    fn of(&self) -> String {
        self.program
            .steps()
            .map(|steps| format!(" of {steps}"))
            .unwrap_or_default()
    }

    fn rest(&self, from: u64, start: &Preflight) -> Result<Rest<'_>, Failure> {
        match self.program.steps() {
            Some(steps) if from >= steps && steps > 0 => Err(Failure::usage(format!(
                "there is no step {}: the last is {steps}",
                from + 1
            ))),
            _ => self.program.rest(from, start),
        }
    }

    /// Commands before the first step.
    fn lead(&self, rest: &Rest<'_>) -> u64 {
        self.settings.len() as u64 + rest.lead
    }

    fn kinds(&self) -> Vec<Set> {
        self.settings
            .iter()
            .copied()
            .chain(self.program.kinds())
            .collect()
    }

    /// The start of the check, when the arm has been told what comes before the program.
    fn told(&self, start: &Preflight) -> Result<Preflight, Failure> {
        let mut start = start.clone();
        for setting in self.settings {
            start.check(setting)?;
        }
        Ok(start)
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "the parts of one run, named once"
    )]
    async fn perform(
        &self,
        arm: &Arm,
        rest: &Rest<'_>,
        start: Preflight,
        report: &Report,
        teller: &Teller<'_>,
        begun: (Instant, u32),
        finished: &AtomicU64,
        mut recorder: Option<Recorder>,
    ) -> Result<Ran, Failure> {
        let times = rest.times(&start, self.settings);
        let lead = self.lead(rest);
        let commands = self
            .settings
            .iter()
            .copied()
            .chain(rest.commands())
            .inspect(|_| self.pulls(lead));
        let options = RunOptions::default().keep(self.keep);
        let mut run = arm.begin(commands, options).along(start);
        let run = run.finish(|progress| {
            let done = self.reached(progress.sent, progress.last.0, progress.current.0, begun);
            finished.store(done, Ordering::Relaxed);
            let left = times.left(report.time, done - rest.from.min(done));
            teller.at(done, left.map(|left| self.of_wall(left)));
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

    /// A time of the arm's clock as a person waits for it.
    fn of_wall(&self, time: Duration) -> Duration {
        self.pace.map_or(time, |pace| time.div_f64(pace.max(1e-3)))
    }

    /// The next command is about to go out.
    fn pulls(&self, lead: u64) {
        let mut state = self.state.borrow_mut();
        state.pulled += 1;
        let steps = state.from + state.pulled.saturating_sub(lead);
        if let Some(journal) = &mut state.journal {
            journal.hands(steps);
        }
    }

    /// So much has been sent and finished; the steps that are.
    fn reached(&self, sent: u64, last: u64, current: u64, begun: (Instant, u32)) -> u64 {
        let mut state = self.state.borrow_mut();
        let from = state.from;
        state.tally.note(sent, last);
        let finished = from + state.tally.finished(current).least;
        let index = state
            .tally
            .last()
            .map(|(index, steps)| (index, from + steps));
        let elapsed = u32::try_from(begun.0.elapsed().as_millis()).unwrap_or(u32::MAX);
        if let Some(journal) = &mut state.journal {
            journal.mark.clock = begun.1.saturating_add(elapsed.saturating_sub(elapsed / 8));
            journal.reached(finished, index);
        }
        finished
    }

    /// The run has failed: the arm is stopped and asked how far it came, if it can be.
    async fn fails(&self, arm: &Arm, failure: Failure) -> Failure {
        let gone = matches!(failure.kind, Kind::Driver(ErrorKind::Port));
        let asked = async {
            arm.stop().await?;
            let pose = arm.get::<Pose>().await?;
            Ok::<_, Error>(Stood {
                pose,
                index: arm.current_index().await?.0,
            })
        };
        let stood = match gone {
            true => None,
            false => timeout(AFTERMATH, asked).await.ok().and_then(Result::ok),
        };
        self.over(failure, stood)
    }

    /// The run is over before its end: what is known is kept, and the failure says how to go on.
    pub(super) fn over(&self, failure: Failure, stood: Option<Stood>) -> Failure {
        let mut state = self.state.borrow_mut();
        let Some(mut journal) = state.journal.take() else {
            return failure;
        };
        if state.pulled == 0 {
            return failure;
        }
        let steps = state.from + state.pulled;
        journal.mark.handed = steps.min(self.program.steps().unwrap_or(u64::MAX));
        let command = "the same command with --resume";
        let Some(stood) = stood else {
            journal.breaks_off();
            return failure.hint(format!(
                "the arm finishes what it has; {command} asks it how far it came, and goes on"
            ));
        };
        let span = state.tally.finished(stood.index);
        let from = state.from;
        let verdict = match span.least == span.most {
            true => settle(from + span.least, |steps| {
                self.stands_after(&state, steps, &stood.pose, true)
            }),
            false => Verdict::Doubt(Span {
                least: from + span.least,
                most: from + span.most,
            }),
        };
        journal.ends(verdict);
        failure.hint(self.advice(verdict, command))
    }

    fn advice(&self, verdict: Verdict, command: &str) -> String {
        let of = self.of();
        match verdict {
            Verdict::After(steps) => format!(
                "{steps}{of} steps are done; {command} goes on with step {}",
                steps + 1
            ),
            Verdict::Again(steps) => format!(
                "{steps}{of} steps are done and the next was cut short; {command} goes on with step {}",
                steps + 1
            ),
            Verdict::Doubt(span) => in_doubt(span),
        }
    }

    /// Whether the arm stands where so many steps leave it. `stopped`: somebody stopped it, and a wait was cut short then.
    fn stands_after(&self, state: &State, steps: u64, pose: &Pose, stopped: bool) -> Option<bool> {
        let done = steps.checked_sub(state.from).filter(|done| *done > 0)?;
        let start = state.start.clone()?.guards(Guards::NONE);
        let rest = self
            .program
            .rest(state.from, &self.told(&start).ok()?)
            .ok()?;
        let count = usize::try_from(done + rest.lead).ok()?;
        let mut course = start;
        let mut last = None;
        for command in self
            .settings
            .iter()
            .copied()
            .chain(rest.commands())
            .take(count + self.settings.len())
        {
            // What could not be checked was not sent.
            let _ = course.check(&command);
            last = Some(command);
        }
        if stopped && matches!(last, Some(Set::WaitCmd(_) | Set::TrigCmd(_))) {
            return Some(false);
        }
        let at = course.arm()?.pose;
        let [x, y, z] = [pose.x, pose.y, pose.z].map(f64::from);
        let off = [x - at.x, y - at.y, z - at.z];
        Some(off.iter().all(|off| off.abs() <= NEAR))
    }

    /// The step at which an earlier run of the same goes on.
    async fn resumed(&self, arm: &Arm, journal: &Journal) -> Result<u64, Failure> {
        let mark = journal.left()?;
        if mark.ended.is_none() {
            self.settled(arm).await?;
        }
        let seen = Seen {
            current: arm.current_index().await?.0,
            clock: arm.get::<DeviceTime>().await?.g_systick,
        };
        let pose = arm.get::<Pose>().await?;
        let state = State {
            start: Some(arm.preflight_for(&self.kinds()).await?),
            ..State::default()
        };
        let seen = self.lasting.then_some(seen);
        let verdict = mark.verdict(seen, |steps| self.stands_after(&state, steps, &pose, false));
        let steps = match verdict {
            Verdict::After(steps) => steps,
            Verdict::Again(steps) => {
                self.say(&format!(
                    "step {} was cut short, or nobody knows how it ended: it is done again",
                    steps + 1
                ));
                steps
            }
            Verdict::Doubt(span) => {
                let message = "nobody can tell how far the last run came: the arm was switched off, or others have used it";
                let failure = Failure::new(Kind::Driver(ErrorKind::Uncertain), message);
                return Err(failure.hint(in_doubt(span)));
            }
        };
        if self.program.steps().is_some_and(|all| steps >= all) {
            journal.remove();
            return Err(Failure::invalid(
                "there is nothing to resume: all steps are done",
            ));
        }
        Ok(steps)
    }

    /// Waits until the arm has done what a run that died has left in its queue.
    async fn settled(&self, arm: &Arm) -> Result<(), Failure> {
        let (_, places) = arm.stats().await?;
        let wait = async {
            let mut before = None;
            let mut changed = Instant::now();
            loop {
                let left = arm.left_space().await?;
                let waiting = places.saturating_sub(left);
                let now = (arm.current_index().await?, arm.get::<Pose>().await?);
                if waiting == 0 && before == Some(now) {
                    return Ok(());
                }
                if before.replace(now) != Some(now) {
                    changed = Instant::now();
                }
                if changed.elapsed() > STANDING {
                    let message = format!(
                        "{waiting} commands of the last run wait in the arm's queue, and nothing moves"
                    );
                    return Err(Failure::invalid(message).hint(
                        "`magician alarms` shows what may hold it; `magician stop` drops them, then --resume goes on",
                    ));
                }
                sleep(LOOKS).await;
            }
        };
        attended(self.json, "waiting for what the arm still has", wait).await
    }

    fn say(&self, text: &str) {
        if !self.json {
            eprintln!("{text}");
        }
    }
}

fn in_doubt(Span { least, most }: Span) -> String {
    format!(
        "{least} steps are done for certain, steps {} to {most} may be: look at the work, then --from {} does them again, \
         --from {} leaves them out",
        least + 1,
        least + 1,
        most + 1
    )
}
