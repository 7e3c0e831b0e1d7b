//! Follows a running job at a terminal or as JSON output: progress, keys, suspension, recording.
//!
//! [`Drive::run`] starts the job and handles its events until it ends. With a recording the job is
//! paused right after its checks, until the recorder runs, so that the file holds the complete
//! motion. Failures of output, picture or recording never stop the arm: they are reported at the
//! end.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use magician::{Arm, ErrorKind};
use magician_job::recording::{Clock, Options, Recorder};
use magician_job::{
    FileJournal, Job, JobEvent, JobHandle, JobOutcome, JobSpec, JobState, MIN_REPORTED_OVERLAP,
    PauseReason, ResumeError, SpeedError, Start, StartPlace, StopOrder, report,
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

/// Default number of readings of a recording per second of the arm's clock, and the largest number
/// per second of wall time.
pub(super) const RATE: f64 = 20.0;
const MOST: f64 = 500.0;

/// Largest program, in steps, that a station can resume after this program: the complete plan is
/// written to disk before the arm moves. A choice.
const MOST_STEPS: usize = 100_000;

/// Job to run, with the options that concern its run.
pub(super) struct Drive<'a> {
    pub(super) made: &'a PreparedJob,
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    /// Length of a resumed burn that is repeated before the place of the interruption, mm.
    pub(super) overlap: f64,
    pub(super) keep: bool,
    /// True if several commands may be in flight.
    pub(super) windowed: bool,
    pub(super) require_homed: bool,
    /// True to accept an arm with unknown homing state.
    pub(super) unhomed: bool,
    pub(super) record: Option<&'a Path>,
    /// Readings of the recording per second of the arm's clock.
    pub(super) rate: f64,
    /// True if the recording gets a line with units.
    pub(super) units: bool,
    pub(super) json: bool,
    /// True if the job repeats until it is stopped, which is its regular end.
    pub(super) repeats: bool,
    /// True if it uses the whole terminal. `verb` is its title there.
    pub(super) tui: bool,
    pub(super) verb: &'static str,
    /// True if the arm is reached through a station.
    pub(super) at_station: bool,
    /// True if the arm exists longer than this program: not a virtual arm in this process.
    pub(super) lasting: bool,
    /// Speed of the arm's clock as a factor of wall time; `None` if unknown.
    pub(super) pace: Option<f64>,
}

/// Result of a run.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) job: Arc<magician_job::JobSummary>,
    /// Reason why the recording is incomplete; `None` if it is complete or was not asked for.
    pub(super) unrecorded: Option<Failure>,
}

/// Successful end of a run.
#[derive(Debug)]
pub(super) enum Ran {
    /// Completed.
    Done(Done),
    /// Stopped, if it was to repeat until then.
    Stopped(StoppedReport),
}

/// Position at which a stopped arm stands, as JSON.
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

/// Line that is reported as ignored if resuming failed.
const RESUME: &str = "{\"do\":\"resume\"}";

/// JSON object about an input line that was ignored.
#[derive(Serialize)]
struct Ignored<'a> {
    event: &'static str,
    line: &'a str,
    /// Reason, if the line was valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<&'a str>,
}

/// JSON object about the step at which an interrupted run resumes.
#[derive(Serialize)]
struct Starts {
    event: &'static str,
    /// Number of the step, from 1.
    step: u64,
    /// True if the run resumes within the step.
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
            .index_may_skip(self.windowed)
            .depends_on_pose(made.prepared.start.is_some())
            .outlives_process(self.lasting)
            .saved(saved.clone())
    }

    /// Returns the journal of the run. If the arm outlives this program, the journal includes the
    /// plan, so that a station can resume the job.
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

    /// Runs the job to its end.
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
            // Pauses the job once it is checked, so that the recording can begin before the arm
            // moves.
            drop(run.job.pause(PauseReason::Person));
        }
        let from = self.checked(&mut run, out).await;
        if let (Some(path), JobState::Paused { .. }) = (self.record, run.job.state()) {
            match self.recorder(arm, path, &run.job).await {
                Ok(begun) => recorder = Some(begun),
                // The file was opened but cannot be written (a full disk): the recording is lost,
                // the job continues.
                Err(failure) if failure.kind == Kind::Driver(ErrorKind::Closed) => {
                    unrecorded = Some(failure);
                }
                Err(failure) => {
                    // Fails before the arm has moved. The outcome is awaited so that the job does
                    // not outlive the failure.
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
            // A terminal that accepts no output is no failure of the job.
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
                let well = self.repeats && !error.stopped_by_line_end;
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

    /// Waits until the job has been checked and starts. Returns the number of steps before its
    /// first one, or `None` if the job ends earlier.
    async fn checked(&self, run: &mut UnderWay<'_>, out: &mut Output) -> Option<u64> {
        let mut from = 0;
        loop {
            match run.next(None).await {
                Next::Event(event) => match event {
                    JobEvent::RecoveredSettings(settled) => out.settled(&settled, self.json),
                    JobEvent::Unfinished {
                        finished,
                        resumable,
                    } => {
                        let note = self.wording().unfinished(finished, resumable);
                        out.note(&note, self.json);
                    }
                    JobEvent::NotStored(cause) => {
                        // Errors of output are ignored: a closed pipe must not stop the job.
                        let _ = out.note_at_once(&report::not_stored_note(&cause), self.json);
                    }
                    JobEvent::Start(starts) => {
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
                    if order == StopOrder::Halt {
                        return None;
                    }
                }
                // The pause for the recording ends by itself, so a request to suspend waits until
                // then.
                Next::Control(control) if self.record.is_some() => {
                    run.suspends = control == Control::Suspend;
                }
                Next::Control(control) => run.hears_early(control),
                Next::Typed(typed) => match run.obeys(typed) {
                    Obeyed::Yes => {}
                    // Errors of output are ignored: a closed pipe must not stop the job.
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

    /// Reports where an interrupted run resumes.
    fn tell_start(&self, starts: StartPlace, out: &mut Output) {
        let step = starts.steps + 1;
        let twice = starts.burnt_twice;
        if self.json && self.resume {
            let starts = Starts {
                event: "starts",
                step,
                within: starts.within,
                burnt_twice_mm: (twice * 100.0).round() / 100.0,
            };
            // Errors of output are ignored: a closed pipe must not stop the job.
            let _ = out.event(&starts).and_then(|()| out.flush());
        }
        let burns = self.made.prepared.program.plan().burns();
        let within = starts.within && self.resume;
        let text = match (starts.again, within, twice >= MIN_REPORTED_OVERLAP) {
            (true, _, false) => {
                format!("step {step} was cut short, or its end is unknown: it is repeated")
            }
            (true, _, true) => format!(
                "step {step} was cut short, or its end is unknown: it is repeated, and up to {twice:.1} mm are burnt twice"
            ),
            (false, _, true) if starts.is_upper_bound => {
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

    /// Handles events and shows progress until the job ends.
    async fn attend(
        &self,
        run: &mut UnderWay<'_>,
        teller: &ProgressReporter<'_>,
        recorder: &mut Option<Recorder>,
    ) -> Attended {
        let mut unrecorded = None;
        // A pause since the check is reported, except the initial pause of a recording.
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
                    let left = progress.remaining.and_then(|left| self.of_wall(left));
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
                Next::Event(JobEvent::NotStored(cause)) => {
                    teller.note(&report::not_stored_note(&cause))
                }
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
                        // The job runs already, so the line had its effect.
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
                    if order == StopOrder::Halt {
                        return Attended {
                            outcome: run.stopped_at_once().await,
                            unrecorded,
                        };
                    }
                }
                // A failing recording ends alone; the job continues.
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

    /// Starts the recorder, whose rate counts in the arm's clock: a virtual arm's may be faster
    /// than wall time.
    async fn recorder(&self, arm: &Arm, path: &Path, job: &JobHandle) -> Result<Recorder, Failure> {
        // At full speed the recorder follows the arm's clock itself.
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

    /// Converts a duration by the arm's clock into wall time; `None` if the arm runs at full speed.
    fn of_wall(&self, time: Duration) -> Option<Duration> {
        match self.pace {
            None => Some(time),
            Some(pace) => pace.is_finite().then(|| time.div_f64(pace.max(1e-3))),
        }
    }
}

/// End of a job whose events were handled.
struct Attended {
    /// Outcome; `None` after a second stop, which does not wait for it.
    outcome: Option<JobOutcome>,
    unrecorded: Option<Failure>,
}

/// Returns the sentence for a change of speed that failed.
fn as_fast_as_before(error: SpeedError) -> String {
    format!("speed unchanged: {error}")
}

/// Returns the warning that the recording ended before the job.
fn says_unrecorded(failure: &Failure) -> String {
    let warning = Paint::for_stderr().note("warning:").to_string();
    format!(
        "{warning} the recording stops here, the work goes on: {}",
        failure.message
    )
}
