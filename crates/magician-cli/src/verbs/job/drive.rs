//! A running job, as a person at a terminal or a reader of its output sees it.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use magician::{Arm, ErrorKind};
use magician_job::recording::{Clock, Options, Recorder};
use magician_job::{
    FileJournal, Job, JobEvent, JobHandle, JobOutcome, JobSpec, JobState, NOTICEABLE, PauseReason,
    ResumeError, SpeedError, Start, StartsAt, StopOrder, report,
};
use magician_program::Tool;
use magician_station::JobOrder;
use serde::Serialize;
use serde_json::Value;

use super::PreparedJob;
use super::input::Input;
use super::tell::ProgressReporter;
use super::tui::Screen;
use super::under_way::{Next, Obeyed, UnderWay};
use super::wording::{self, Wording};
use crate::context::{Context, Ended};
use crate::failure::{Failure, Kind};
use crate::interrupt::{Control, JobControl, Signals};
use crate::output::Output;
use crate::paint::Paint;
use crate::saved::SavedSettings;
use crate::serving::unix_time;

/// Readings of a recording for a second of the arm's clock, and the most for one of ours.
pub(super) const RATE: f64 = 20.0;
const MOST: f64 = 500.0;

/// Steps of a run that a station can go on with, at most: its plan is written before the arm moves.
const MOST_STEPS: usize = 100_000;

/// What is to run, and how.
pub(super) struct Drive<'a> {
    pub(super) made: &'a PreparedJob,
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    /// How far a burn that is resumed begins before the place where its light went out, mm.
    pub(super) overlap: f64,
    pub(super) keep: bool,
    /// Whether several commands may be under way on the line at a time.
    pub(super) windowed: bool,
    pub(super) require_homed: bool,
    /// Whether an arm is taken that is not known to be homed.
    pub(super) unhomed: bool,
    pub(super) record: Option<&'a Path>,
    /// Readings of it for a second of the arm's clock.
    pub(super) rate: f64,
    /// Whether they have a line of units.
    pub(super) units: bool,
    pub(super) json: bool,
    /// Whether it goes on until it is stopped, which is its good end.
    pub(super) repeats: bool,
    /// Whether it has the whole terminal, and what it is called there.
    pub(super) tui: bool,
    pub(super) verb: &'static str,
    /// True if a station carries the line to the arm.
    pub(super) at_station: bool,
    /// Whether the arm outlives this program.
    pub(super) lasting: bool,
    /// How fast the arm's clock runs, if that is known.
    pub(super) pace: Option<f64>,
}

/// What a run has come to.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) job: Arc<magician_job::Done>,
    /// Why the recording that was asked for is not whole.
    pub(super) unrecorded: Option<Failure>,
}

/// How a run has ended that went well.
#[derive(Debug)]
pub(super) enum Ran {
    /// All of it is done.
    Done(Done),
    /// It was to go on until it was stopped.
    Stopped(StoppedReport),
}

/// Where an arm stands that was stopped, as JSON has it.
#[derive(Debug, Serialize)]
pub(super) struct StoppedReport {
    stopped: bool,
    at: [f32; 3],
}

impl StoppedReport {
    pub(super) fn show(&self, context: &mut Context) -> Result<(), Failure> {
        let [x, y, z] = self.at;
        context.show(self, |out| {
            out.line(format_args!("stopped at x {x:.1} y {y:.1} z {z:.1}"))
        })
    }
}

/// What an object says of a line that was not obeyed.
const RESUME: &str = "{\"do\":\"resume\"}";

/// A line that was not obeyed, as JSON has it.
#[derive(Serialize)]
struct Ignored<'a> {
    event: &'static str,
    line: &'a str,
    /// Why, where it means something.
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<&'a str>,
}

/// Where a run goes on that was interrupted, as JSON has it.
#[derive(Serialize)]
struct Starts {
    event: &'static str,
    /// From 1.
    step: u64,
    /// Whether it goes on within the step, and not at its beginning.
    within: bool,
    burnt_twice_mm: f64,
}

impl<'a> Ignored<'a> {
    const fn of(line: &'a str) -> Self {
        Self {
            event: "ignored",
            line,
            message: None,
        }
    }
}

impl Drive<'_> {
    fn spec(&self, saved: &SavedSettings) -> JobSpec {
        let made = self.made;
        JobSpec::new(made.prepared.program.clone())
            .ending(made.prepared.ending)
            .start(match (self.resume, self.from) {
                (true, _) => Start::Resume,
                (false, from) => Start::Step(from.map_or(0, |step| step - 1)),
            })
            .overlap(self.overlap)
            .origin(made.source.name.clone())
            .keep(self.keep)
            .require_homed(self.require_homed)
            .passes_over(self.windowed)
            .begins_here(made.prepared.start.is_some())
            .lasting(self.lasting)
            .saved(saved.clone())
    }

    /// The journal of the run. What a station needs to go on with it is beside it, where the arm outlives this program.
    fn journal(&self, arm: &Arm) -> FileJournal {
        let prepared = &self.made.prepared;
        let plan = prepared.program.plan();
        if !self.lasting || plan.steps.len() > MOST_STEPS {
            return FileJournal::new();
        }
        let loops = prepared.program.iterations();
        let order = JobOrder::of_plan(plan.to_json(), loops, prepared.start);
        let order = serde_json::json!({
            "version": 1,
            "started": unix_time().as_secs_f64(),
            "port": arm.name(),
            "steps": plan.steps.len(),
            "order": order,
        });
        match order {
            Value::Object(order) => FileJournal::new().with_order(order),
            _ => FileJournal::new(),
        }
    }

    /// Runs it to its end.
    pub(super) async fn run(
        &self,
        arm: &Arm,
        out: &mut Output,
        saved: &SavedSettings,
        signals: &mut Signals,
        mut input: Input,
    ) -> Result<Ran, Ended> {
        let control = JobControl::listen()?;
        input.listen();
        let unhomed = arm.allowing_unhomed();
        let arm = if self.unhomed { &unhomed } else { arm };
        let job = Job::start(arm, self.spec(saved), self.journal(arm));
        let mut run = UnderWay::of(job, signals, control, input, self.json);
        let (mut recorder, mut unrecorded) = (None, None);
        if self.record.is_some() {
            // What is recorded begins before the arm moves, and after all is checked.
            drop(run.job.pause(PauseReason::Person));
        }
        let from = self.checked(&mut run, out).await;
        if let (Some(path), JobState::Paused { .. }) = (self.record, run.job.state()) {
            match self.recorder(arm, path, &run.job).await {
                Ok(begun) => recorder = Some(begun),
                // The file is there and takes nothing: a full disk costs the recording, not the work.
                Err(failure) if failure.kind == Kind::Driver(ErrorKind::Closed) => {
                    unrecorded = Some(failure);
                }
                Err(failure) => {
                    run.job.stop();
                    let _ = run.job.outcome().await;
                    return Err(failure.into());
                }
            }
            let begins: Result<(), ResumeError> = run.job.resume().await;
            if let Err(error) = begins {
                run.job.stop();
                let _ = run.job.outcome().await;
                return Err(self.wording().resume(&error).into());
            }
        }
        if self.tui && run.job.state() != JobState::Ended {
            match Screen::open(arm, self).await {
                Ok(screen) => run.screen = Some(screen),
                Err(failure) => {
                    run.job.stop();
                    let _ = run.job.outcome().await;
                    return Err(failure.into());
                }
            }
        }
        let screen = run.screen.as_ref().map(Screen::model);
        let teller =
            ProgressReporter::new(out, self.json, self.made.prepared.program.steps(), screen);
        if let Some(from @ 1..) = from {
            teller.say(&format!(
                "beginning at step {}{}",
                from + 1,
                self.wording().of()
            ));
        }
        if let Some(full) = &unrecorded {
            teller.say(&says_unrecorded(full));
        }
        let ended = self.attend(&mut run, &teller, &mut recorder).await;
        drop(teller);
        if let Some(screen) = run.screen.take() {
            // A terminal that takes nothing more is no failure of the work.
            let _ = screen.close();
        }
        if let Some(recorder) = recorder {
            unrecorded = unrecorded.or(recorder.finish().await.err().map(Failure::from));
        }
        let unrecorded = unrecorded.or(ended.unrecorded);
        match ended.outcome {
            Some(Ok(job)) => Ok(Ran::Done(Done { job, unrecorded })),
            Some(Err(error)) if error.is_stop() => {
                let (failure, stands) = self.wording().stopped(&error);
                let well = self.repeats && !error.line_ends;
                if let (true, true, Some(pose)) = (well, stands, &error.pose) {
                    return Ok(Ran::Stopped(StoppedReport {
                        stopped: true,
                        at: [pose.x, pose.y, pose.z],
                    }));
                }
                Err(Ended::Interrupted { failure, stands })
            }
            Some(Err(error)) => Err(self.wording().failure(&error).into()),
            None => Err(Ended::Interrupted {
                failure: Failure::new(Kind::Interrupted, wording::UNKNOWN),
                stands: false,
            }),
        }
    }

    fn wording(&self) -> Wording<'_> {
        Wording {
            made: self.made,
            at_station: self.at_station,
        }
    }

    /// Waits until it has been checked, and begins; the steps before its first. Nothing where it ends before that.
    async fn checked(&self, run: &mut UnderWay<'_>, out: &mut Output) -> Option<u64> {
        let mut from = 0;
        loop {
            match run.next(None).await {
                Next::Event(event) => match event {
                    JobEvent::Settled(settled) => out.settled(&settled, self.json),
                    JobEvent::Unfinished {
                        finished,
                        resumable,
                    } => {
                        let note = self.wording().unfinished(finished, resumable);
                        out.note(&note, self.json);
                    }
                    JobEvent::Unkept(cause) => {
                        // Output without a reader is no reason to stop.
                        let _ = out.note_at_once(&report::unkept(&cause), self.json);
                    }
                    JobEvent::Starts(starts) => {
                        from = starts.steps;
                        self.tell_start(starts, out);
                    }
                    JobEvent::State(JobState::Running | JobState::Paused { .. }) => {
                        return Some(from);
                    }
                    JobEvent::State(JobState::Ended) => return None,
                    other => run.hears(&other),
                },
                Next::Stop(None) | Next::Pressed(_) => {}
                Next::Stop(Some(order)) => {
                    run.stop();
                    if order == StopOrder::AtOnce {
                        return None;
                    }
                }
                // The pause that begins a recording ends by itself: what is asked for before it waits for that.
                Next::Control(control) if self.record.is_some() => {
                    run.suspends = control == Control::Suspend;
                }
                Next::Control(control) => run.hears_early(control),
                Next::Typed(typed) => match run.obeys(typed) {
                    Obeyed::Yes => {}
                    // Output without a reader is no reason to stop.
                    Obeyed::Ignored(line) => {
                        let _ = out.event(&Ignored::of(&line)).and_then(|()| out.flush());
                    }
                    Obeyed::Refused(error) => super::say(&as_fast_as_before(error)),
                },
                Next::Resumed(_) => run.resuming = None,
                Next::Paused(paused) => run.is_paused_early(paused),
                Next::Unrecorded(_) | Next::Over => return None,
            }
        }
    }

    /// Where a run goes on that was interrupted.
    fn tell_start(&self, starts: StartsAt, out: &mut Output) {
        let step = starts.steps + 1;
        let twice = starts.burnt_twice;
        if self.json && self.resume {
            let starts = Starts {
                event: "starts",
                step,
                within: starts.within,
                burnt_twice_mm: (twice * 100.0).round() / 100.0,
            };
            // Output without a reader is no reason to stop.
            let _ = out.event(&starts).and_then(|()| out.flush());
        }
        let burns = self.made.prepared.program.plan().burns();
        let within = starts.within && self.resume;
        let text = match (starts.again, within, twice >= NOTICEABLE) {
            (true, _, false) => {
                format!("step {step} was cut short, or its end is unknown: it is repeated")
            }
            (true, _, true) => format!(
                "step {step} was cut short, or its end is unknown: it is repeated, and up to {twice:.1} mm are burnt twice"
            ),
            (false, _, true) if starts.at_most => {
                format!(
                    "it is not known exactly where the light went out: it continues in step {step}, before where it \
                     stopped, and up to {twice:.1} mm are burnt twice"
                )
            }
            (false, _, true) => {
                format!(
                    "it continues in step {step}, before where the light went out: {twice:.1} mm are burnt twice"
                )
            }
            (false, true, false) if burns => {
                format!("step {step} was cut short: it continues where the light went out")
            }
            (false, true, false) => {
                format!("step {step} was cut short: it continues where it stopped")
            }
            (false, false, false) if starts.nothing_queued => {
                format!(
                    "nothing was queued yet when the last run ended: it begins with step {step}"
                )
            }
            (false, false, false) => return,
        };
        if !self.json {
            super::say(&text);
        }
    }

    /// Shows how far it is, to its end.
    async fn attend(
        &self,
        run: &mut UnderWay<'_>,
        teller: &ProgressReporter<'_>,
        recorder: &mut Option<Recorder>,
    ) -> Attended {
        let mut unrecorded = None;
        // A pause from the time of the check; the one that begins a recording is not told.
        let state = run.job.state();
        let mut paused = recorder.is_none() && matches!(state, JobState::Paused { .. });
        if let (true, JobState::Paused { reason, part }) = (paused, state) {
            teller.paused(reason, part, run.job.pause_text().as_deref());
            run.stops_unanswered();
        }
        if std::mem::take(&mut run.suspends) {
            run.hears_control(Control::Suspend, teller);
        }
        loop {
            match run.next(recorder.as_mut()).await {
                Next::Event(JobEvent::Progress(progress)) => {
                    let left = progress.left.and_then(|left| self.of_wall(left));
                    teller.at(&progress, left);
                }
                Next::Event(JobEvent::State(state)) => match state {
                    JobState::Pausing => teller.pausing(),
                    JobState::Paused { reason, part } => {
                        paused = true;
                        teller.paused(reason, part, run.job.pause_text().as_deref());
                        run.stops_unanswered();
                    }
                    JobState::Running if std::mem::take(&mut paused) => teller.resumed(),
                    JobState::Stopping => teller.ends(true),
                    JobState::Ending => teller.ends(false),
                    _ => {}
                },
                Next::Event(JobEvent::Speed(percent)) => teller.speed(percent),
                Next::Event(JobEvent::Unkept(cause)) => teller.note(&report::unkept(&cause)),
                Next::Typed(typed) => match run.obeys(typed) {
                    Obeyed::Yes => {}
                    Obeyed::Ignored(line) => teller.object(&Ignored::of(&line)),
                    Obeyed::Refused(error) => teller.say(&as_fast_as_before(error)),
                },
                Next::Control(control) => run.hears_control(control, teller),
                Next::Paused(paused) => {
                    run.pausing = None;
                    let act = run.suspension.paused(paused);
                    run.acts(act, teller);
                }
                Next::Resumed(resumed) => {
                    run.resuming = None;
                    match resumed {
                        // A running job is resumed already.
                        Ok(()) | Err(ResumeError::NotPaused) => run.stops_unanswered(),
                        Err(error) => {
                            let failure = self.wording().resume(&error);
                            teller.say(&format!("still paused: {}", failure.message));
                            teller.object(&Ignored {
                                message: Some(&failure.message),
                                ..Ignored::of(RESUME)
                            });
                        }
                    }
                }
                Next::Event(event) => run.hears(&event),
                Next::Stop(None) | Next::Pressed(_) => {}
                Next::Stop(Some(order)) => {
                    run.stop();
                    if order == StopOrder::AtOnce {
                        return Attended {
                            outcome: run.stopped_at_once().await,
                            unrecorded,
                        };
                    }
                }
                // A recording that cannot go on costs itself, and never the work.
                Next::Unrecorded(error) => {
                    let failure = Failure::from(error);
                    teller.say(&says_unrecorded(&failure));
                    *recorder = None;
                    unrecorded = Some(failure);
                }
                Next::Over => {
                    let outcome = Some(run.job.outcome().await);
                    return Attended {
                        outcome,
                        unrecorded,
                    };
                }
            }
        }
    }

    /// What keeps the poses, on the arm's clock: a virtual one may be faster than ours.
    async fn recorder(&self, arm: &Arm, path: &Path, job: &JobHandle) -> Result<Recorder, Failure> {
        // On an arm that runs as fast as it can the recorder's time is the arm's.
        let pace = self.pace.filter(|pace| pace.is_finite()).unwrap_or(1.0);
        let rate = (self.rate * pace).clamp(self.rate, MOST);
        let plan = self.made.prepared.program.plan();
        let options = Options {
            paper: plan.surface.filter(|_| plan.tool == Some(Tool::Pen)),
            units: self.units,
            clock: Clock::Arm,
            steps: Some(job.finished()),
            ..Options::new(SystemTime::now(), rate)
        };
        Ok(Recorder::begin(arm, path, options).await?)
    }

    /// A time of the arm's clock in wall time; unknown where the arm runs as fast as it can.
    fn of_wall(&self, time: Duration) -> Option<Duration> {
        match self.pace {
            None => Some(time),
            Some(pace) => pace.is_finite().then(|| time.div_f64(pace.max(1e-3))),
        }
    }
}

/// How a job ended that was attended.
struct Attended {
    /// None if unknown: the second stop does not wait for it.
    outcome: Option<JobOutcome>,
    unrecorded: Option<Failure>,
}

/// Why a job is no faster and no slower.
fn as_fast_as_before(error: SpeedError) -> String {
    format!("speed unchanged: {error}")
}

/// A recording has ended before the work.
fn says_unrecorded(failure: &Failure) -> String {
    let warning = Paint::for_stderr().note("warning:").to_string();
    format!(
        "{warning} the recording stops here, the work goes on: {}",
        failure.message
    )
}
