//! Plan on its way over a faulty line to a virtual arm, on a clock that advances only when nothing
//! else happens: the marks, the end, and how it was resumed. Also used by
//! `cargo xtask soak drawing`.

use std::cell::Cell;
use std::future::Future;
use std::rc::Rc;
use std::time::Duration;

use magician::commands::DeviceTime;
use magician::faults::Faults;
use magician::preflight::{Guards, Preflight};
use magician::sim::world::Drawing;
use magician::sim::{LineTiming, Runner, Speed};
use magician::{Arm, Error, ErrorKind, Options, Run, RunSummary, Set, VirtualArm};
use magician_program::StepNumbering;
use magician_program::rehearse::{RehearseOptions, stage, start_of};
use magician_program::resume::{Checkpoint, ObservedProgress, ResumePoint, StepCounter, StepRange};
use magician_program::{Action, Continuation, Plan, Step};
use tokio::time::{Instant, sleep};

/// Timing of a serial line: baud rate, and reply time of the arm, us.
const SERIAL_TIMING: LineTiming = LineTiming {
    baud: Some(115_200),
    turnaround: Duration::from_millis(1),
};
/// Largest number of times that an interrupted run is resumed.
const MAX_RESUMES: usize = 200;
/// Largest number of times for the same cause, which a reconnected line does not fix.
const MAX_RESUMES_PER_CAUSE: usize = 5;
/// Time for which an arm is left alone to finish its queue.
const QUIET_TIME: Duration = Duration::from_secs(2);
/// Largest distance of the arm from its expected position, mm.
const POSITION_TOLERANCE: f64 = 0.5;

/// Line with its faults.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaultSetup {
    pub(crate) faults: Faults,
    pub(crate) window: usize,
}

/// Result of a plan.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// Drawing at the end of the run, good or bad.
    pub(crate) drawing: Drawing,
    /// Drawing at each interruption.
    pub(crate) between: Vec<Drawing>,
    /// Cause of each interruption.
    pub(crate) why: Vec<String>,
    /// End of the run.
    pub(crate) end: Result<RunSummary, Error>,
    /// Bounds of the finished steps, for a run that ended badly.
    pub(crate) steps: Option<StepRange>,
    /// Step at which it was resumed, and the drawing after that, if the step was known.
    pub(crate) rest: Option<(usize, Drawing)>,
    /// Duration of the run until its end.
    pub(crate) took: Duration,
    /// Number of requests sent, and retransmitted.
    pub(crate) requests: [u64; 2],
}

/// Runs a future on a clock that jumps.
pub(crate) fn on_virtual_clock<T>(work: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .start_paused(true)
        .build();
    runtime.expect("a runtime has no needs").block_on(work)
}

/// Arm for a plan at the end of a serial line, faster than real time by this factor.
fn cell(plan: &Plan, pace: f64) -> Result<VirtualArm, Error> {
    let arm = stage(plan, &RehearseOptions::default())?;
    Ok(Runner::new(arm, Speed::Times(pace), SERIAL_TIMING).into())
}

fn drawn(cell: &VirtualArm) -> Drawing {
    cell.with(|arm| arm.drawing())
}

/// Runs a plan over a faulty line. Interrupted runs are resumed; a run that ended is resumed from a
/// step over a good line, if the step is known.
pub(crate) async fn draw(plan: &Plan, trouble: FaultSetup) -> Result<Outcome, Error> {
    draw_at(plan, trouble, 1.0).await
}

/// Like [`draw`], with an arm that is faster than the host assumes by this factor, so that its
/// queue runs empty early.
pub(crate) async fn draw_at(plan: &Plan, trouble: FaultSetup, pace: f64) -> Result<Outcome, Error> {
    let cell = cell(plan, pace)?;
    let options = (Options::default())
        .window(trouble.window)
        .faults(trouble.faults);
    let arm = connected(&cell, &options).await?;
    let start = start_of(&stage(plan, &RehearseOptions::default())?);
    let mut ride = ResumedRun::of(plan, start.clone(), trouble.window);
    let pulled = Rc::clone(&ride.pulled);
    let commands = (plan.commands()).inspect(move |_| pulled.set(pulled.get() + 1));
    let mut run = arm.start(commands).along(start);
    let mut between = Vec::new();
    let begun = Instant::now();
    let end = ride.finish(&arm, &mut run, &cell, &mut between).await;
    let took = begun.elapsed();
    let (stats, _) = arm.stats().await.unwrap_or_default();
    drop(run);
    let drawing = drawn(&cell);
    let mut outcome = Outcome {
        drawing,
        between,
        why: std::mem::take(&mut ride.why),
        end,
        steps: None,
        rest: None,
        took,
        requests: [stats.sent, stats.resent],
    };
    if outcome.end.is_err() {
        arm.detach();
        drop(arm);
        outcome.drawing = still(&cell).await;
        let arm = Arm::simulated(cell.clone(), Options::default()).await?;
        ride.resume(&arm, &cell, &mut outcome).await?;
    }
    Ok(outcome)
}

/// Retries on a line so bad that no reply arrives.
async fn connected(cell: &VirtualArm, options: &Options) -> Result<Arm, Error> {
    let mut tries = 0;
    loop {
        let mut options = options.clone();
        options.faults.seed = options.faults.seed.wrapping_add(tries);
        match Arm::simulated(cell.clone(), options).await {
            Err(error) if error.kind() == ErrorKind::InvalidInput || tries > 20 => {
                return Err(error);
            }
            Err(_) => tries += 1,
            Ok(arm) => return Ok(arm),
        }
    }
}

/// Drawing once the arm is at rest.
async fn still(cell: &VirtualArm) -> Drawing {
    loop {
        sleep(QUIET_TIME).await;
        let state = cell.state();
        let queue = state.queue;
        let has_work = queue.running.is_some() || queue.waiting > 0;
        let goes_on = has_work && queue.started && !queue.held;
        if !state.moving && !goes_on {
            return drawn(cell);
        }
    }
}

/// Progress of a plan, recorded as `magician run` does.
struct ResumedRun<'p> {
    plan: &'p Plan,
    start: Preflight,
    counter: StepCounter,
    checkpoint: Checkpoint,
    why: Vec<String>,
    /// Number of commands taken from the plan.
    pulled: Rc<Cell<u64>>,
}

impl<'p> ResumedRun<'p> {
    fn of(plan: &'p Plan, start: Preflight, window: usize) -> Self {
        let lit = |step: &Step| match step.action {
            Action::Burn { power, .. } => power > 0.0,
            Action::Laser(on) => on,
            _ => false,
        };
        // The driver inserts commands between burns, and above window 1 it may skip indices.
        let mixed = window > 1 || plan.steps.iter().any(lit);
        let steps = u64::try_from(plan.steps.len()).unwrap_or(u64::MAX);
        Self {
            plan,
            start,
            counter: StepCounter::new(lead(plan), mixed),
            checkpoint: Checkpoint::new(&plan.title, Some(steps), mixed),
            why: Vec::new(),
            pulled: Rc::default(),
        }
    }

    async fn finish<C: Iterator<Item = Set>>(
        &mut self,
        arm: &Arm,
        run: &mut Run<C>,
        cell: &VirtualArm,
        between: &mut Vec<Drawing>,
    ) -> Result<RunSummary, Error> {
        let (mut told, mut again) = (None, 0);
        for _ in 0..MAX_RESUMES {
            let error = match self.run_once(run).await {
                Ok(ran) => return Ok(ran),
                Err(error) => error,
            };
            // Go on if nothing was sent yet or the run can be resumed, but not forever for the same
            // cause.
            let may_go_on = run.is_interrupted() || run.ran() == RunSummary::default();
            let line = matches!(error.kind(), ErrorKind::Port | ErrorKind::Timeout);
            let says = error.to_string();
            again = if !line && told.as_ref() == Some(&says) {
                again + 1
            } else {
                0
            };
            if !may_go_on || again > MAX_RESUMES_PER_CAUSE {
                return Err(error);
            }
            self.why.push(says.clone());
            told = Some(says);
            between.push(drawn(cell));
            // A line that stays down shows when the run is resumed.
            let _ = arm.reconnected().await;
        }
        self.run_once(run).await
    }

    async fn run_once<C: Iterator<Item = Set>>(
        &mut self,
        run: &mut Run<C>,
    ) -> Result<RunSummary, Error> {
        let (counter, checkpoint) = (&mut self.counter, &mut self.checkpoint);
        let ended = run
            .wait(|progress| {
                counter.note(progress.sent, progress.last.0);
                let done = counter.finished(progress.current.0).least;
                checkpoint.finished = checkpoint.finished.max(done);
                checkpoint.index = counter.last().or(checkpoint.index);
            })
            .await;
        self.note(run.ran());
        ended
    }

    fn note(&mut self, ran: RunSummary) {
        if let Some(last) = ran.last {
            self.counter.note(ran.commands, last.0);
            self.checkpoint.index = self.counter.last();
        }
        self.checkpoint.handed = self.pulled.get().saturating_sub(lead(self.plan));
    }

    /// Resumes a run that is over, at the place that the arm reports.
    async fn resume(
        &mut self,
        arm: &Arm,
        cell: &VirtualArm,
        outcome: &mut Outcome,
    ) -> Result<(), Error> {
        let seen = ObservedProgress {
            current: arm.queue().current_index().await?.0,
            clock: arm.get::<DeviceTime>().await?.g_systick,
        };
        arm.stop().await?;
        arm.clear_alarms().await?;
        let now = arm.preflight().await?;
        let resume_point =
            self.checkpoint
                .resume_point(Some(seen), &StepNumbering::default(), |steps| {
                    self.stands_after(steps, &now)
                });
        let (step, span) = match resume_point {
            ResumePoint::After(steps) => (Some(steps), exactly(steps)),
            ResumePoint::Again(steps) => (
                Some(steps),
                StepRange {
                    least: steps,
                    most: steps + 1,
                },
            ),
            ResumePoint::Doubt(span) => (None, span),
        };
        outcome.steps = Some(span);
        let Some(step) = step.and_then(|step| usize::try_from(step).ok()) else {
            return Ok(());
        };
        if step < self.plan.steps.len() {
            let rest = Continuation::from_step(self.plan, step, &now)?;
            let commands: Vec<Set> = rest.plan.commands().collect();
            arm.start(commands).wait(|_| {}).await?;
        }
        outcome.rest = Some((step, drawn(cell)));
        Ok(())
    }

    /// True if the arm stands where this many steps leave it; `None` if unknown.
    fn stands_after(&self, steps: u64, now: &Preflight) -> Option<bool> {
        let mut course = self.start.clone().guards(Guards::NONE);
        let commands = usize::try_from(steps + lead(self.plan)).ok()?;
        for command in self.plan.commands().take(commands) {
            // A command that the check refuses was never sent.
            let _ = course.check(&command);
        }
        let (at, stands) = (course.arm()?.pose, now.arm()?.pose);
        Some(at.distance_to(&stands) <= POSITION_TOLERANCE)
    }
}

/// Number of commands before the first step.
fn lead(plan: &Plan) -> u64 {
    plan.preamble().into_iter().count() as u64
}

fn exactly(steps: u64) -> StepRange {
    StepRange {
        least: steps,
        most: steps,
    }
}
