//! A job that is run, as a person at a terminal and who reads its output sees it.

use std::path::Path;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use magician::{Arm, ErrorKind};
use magician_job::{
    FileJournal, Job, JobEvent, JobEvents, JobHandle, JobOutcome, JobSpec, JobState, PauseError,
    PauseReason, ResumeError, SpeedError, Start, StartsAt, Waits,
};
use serde::Serialize;
use tokio::time::timeout;

use super::Made;
use super::input::{Input, Typed};
use super::suspend::{Act, Suspension};
use super::tell::Teller;
use super::wording::Wording;
use crate::context::{Ended, FAREWELL};
use crate::failure::{Failure, Kind};
use crate::interrupt::{Control, JobControl, Signal, Signals};
use crate::output::{Output, Paint};
use crate::progress::attended;
use crate::recording::{Clock, Options, Recorder};
use crate::saved::SavedSettings;

/// Readings of a recording for a second of the arm's clock, and the most for one of ours.
const RATE: f64 = 20.0;
const MOST: f64 = 500.0;

/// What is to run, and how.
pub(super) struct Drive<'a> {
    pub(super) made: &'a Made,
    pub(super) from: Option<u64>,
    pub(super) resume: bool,
    pub(super) keep: bool,
    /// Whether several commands may be under way on the line at a time.
    pub(super) windowed: bool,
    pub(super) require_homed: bool,
    /// Whether an arm that was not homed is refused, because of what the program is.
    pub(super) refuses_unhomed: bool,
    pub(super) record: Option<&'a Path>,
    pub(super) json: bool,
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

/// What a person has asked for.
#[derive(Debug, Default)]
struct Stops {
    /// Whether a first stop was said.
    asked: bool,
    /// Whether the system wants this program to end.
    terminates: bool,
}

/// What comes next.
enum Next {
    Signal(Signal),
    Control(Control),
    Typed(Typed),
    /// What came of the pause that a suspension begins with.
    Paused(Result<(), PauseError>),
    /// What came of the wish to go on.
    Resumed(Result<(), ResumeError>),
    Event(JobEvent),
    /// The recording cannot go on.
    Unrecorded(Failure),
    Over,
}

type Resuming = Pin<Box<dyn Future<Output = Result<(), ResumeError>>>>;
type Pausing = Pin<Box<dyn Future<Output = Result<(), PauseError>>>>;

/// Between two speeds that keys choose, percent, and the least and the most of them.
const SPEEDS: u8 = 10;
const SLOWEST: u8 = 10;
const FASTEST: u8 = 100;

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

impl<'a> Ignored<'a> {
    const fn of(line: &'a str) -> Self {
        Self {
            event: "ignored",
            line,
            message: None,
        }
    }
}

/// A job that is under way.
struct UnderWay<'a> {
    job: JobHandle,
    events: JobEvents,
    signals: &'a mut Signals,
    input: Input,
    control: JobControl,
    suspension: Suspension,
    /// Whether it is to be suspended as soon as it is checked.
    suspends: bool,
    /// What becomes of the pause that a suspension begins with.
    pausing: Option<Pausing>,
    /// What becomes of the wish to go on.
    resuming: Option<Resuming>,
    stops: Stops,
    /// What is waited for, if that may take a while.
    waits: Option<&'static str>,
    json: bool,
}

impl Drive<'_> {
    fn spec(&self, saved: &SavedSettings) -> JobSpec {
        let made = self.made;
        JobSpec::new(made.program.clone())
            .ending(made.ending)
            .start(match (self.resume, self.from) {
                (true, _) => Start::Resume,
                (false, from) => Start::Step(from.map_or(0, |step| step - 1)),
            })
            .origin(made.source.name.clone())
            .keep(self.keep)
            .require_homed(self.require_homed)
            .refuse_unhomed(self.refuses_unhomed)
            .passes_over(self.windowed)
            .begins_here(made.start.is_some())
            .lasting(self.lasting)
            .saved(saved.clone())
    }

    /// Runs it to its end.
    pub(super) async fn run(
        &self,
        arm: &Arm,
        out: &mut Output,
        saved: &SavedSettings,
        signals: &mut Signals,
        mut input: Input,
    ) -> Result<Done, Ended> {
        let control = JobControl::listen()?;
        input.listen();
        let job = Job::start(arm, self.spec(saved), FileJournal::new());
        let mut run = UnderWay {
            events: job.events(),
            signals,
            input,
            control,
            suspension: Suspension::new(job.burns()),
            suspends: false,
            pausing: None,
            resuming: None,
            stops: Stops::default(),
            waits: None,
            json: self.json,
            job,
        };
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
        let teller = Teller::new(out, self.json, self.made.program.steps());
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
        if let Some(recorder) = recorder {
            unrecorded = unrecorded.or(recorder.finish().await.err());
        }
        let unrecorded = unrecorded.or(ended.unrecorded);
        match ended.outcome {
            Some(Ok(job)) => Ok(Done { job, unrecorded }),
            Some(Err(error)) if error.is_stop() => {
                let (failure, stands) = self.wording().stopped(&error);
                Err(Ended::Interrupted {
                    failure,
                    stands,
                    terminates: run.stops.terminates,
                })
            }
            Some(Err(error)) => Err(self.wording().failure(&error).into()),
            None => Err(Ended::Interrupted {
                failure: Failure::new(Kind::Interrupted, super::wording::UNKNOWN),
                stands: false,
                terminates: run.stops.terminates,
            }),
        }
    }

    fn wording(&self) -> Wording<'_> {
        Wording { made: self.made }
    }

    /// Waits until it has been checked, and begins; the steps before its first. Nothing where it ends before that.
    async fn checked(&self, run: &mut UnderWay<'_>, out: &mut Output) -> Option<u64> {
        let mut from = 0;
        loop {
            match run.next(None).await {
                Next::Event(event) => match event {
                    JobEvent::Settled(settled) => out.settled(&settled, self.json),
                    JobEvent::Starts(starts) => {
                        from = starts.steps;
                        self.tell_start(starts);
                    }
                    JobEvent::State(JobState::Running | JobState::Paused { .. }) => {
                        return Some(from);
                    }
                    JobEvent::State(JobState::Ended) => return None,
                    other => run.hears(&other),
                },
                Next::Signal(signal) => {
                    if run.stop(signal) {
                        return None;
                    }
                }
                Next::Control(control) => run.suspends = control == Control::Suspend,
                Next::Typed(typed) => match run.obeys(typed) {
                    Obeyed::Yes => {}
                    // Nobody who reads is no reason to stop.
                    Obeyed::Ignored(line) => {
                        let _ = out.event(&Ignored::of(&line)).and_then(|()| out.flush());
                    }
                    Obeyed::Refused(error) => super::say(&as_fast_as_before(error)),
                },
                Next::Resumed(_) => run.resuming = None,
                Next::Paused(_) => run.pausing = None,
                Next::Unrecorded(_) | Next::Over => return None,
            }
        }
    }

    /// Where a run goes on that was interrupted.
    fn tell_start(&self, starts: StartsAt) {
        let step = starts.steps + 1;
        let text = if starts.within && self.resume {
            format!("step {step} was cut short: it goes on where it stopped")
        } else if starts.again {
            format!("step {step} was cut short, or nobody knows how it ended: it is done again")
        } else {
            return;
        };
        if !self.json {
            super::say(&text);
        }
    }

    /// Shows how far it is, to its end.
    async fn attend(
        &self,
        run: &mut UnderWay<'_>,
        teller: &Teller<'_>,
        recorder: &mut Option<Recorder>,
    ) -> Attended {
        let mut unrecorded = None;
        // A pause from the time of the check; the one that begins a recording is not told.
        let state = run.job.state();
        let mut paused = recorder.is_none() && matches!(state, JobState::Paused { .. });
        if let (true, JobState::Paused { reason, part }) = (paused, state) {
            teller.paused(reason, part);
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
                        teller.paused(reason, part);
                    }
                    JobState::Running if std::mem::take(&mut paused) => teller.resumed(),
                    _ => {}
                },
                Next::Event(JobEvent::Speed(percent)) => teller.speed(percent),
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
                        // Who wants a job to go on that runs has what he wants.
                        Ok(()) | Err(ResumeError::NotPaused) => {}
                        Err(error) => {
                            let failure = self.wording().resume(&error);
                            teller.say(&format!("it stays paused: {}", failure.message));
                            teller.object(&Ignored {
                                message: Some(&failure.message),
                                ..Ignored::of(RESUME)
                            });
                        }
                    }
                }
                Next::Event(event) => run.hears(&event),
                Next::Signal(signal) => {
                    if run.stop(signal) {
                        return Attended {
                            outcome: run.stopped_again().await,
                            unrecorded,
                        };
                    }
                }
                // A recording that cannot go on costs itself, and never the work.
                Next::Unrecorded(failure) => {
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
        let options = Options {
            clock: Clock::Arm,
            steps: Some(job.finished()),
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
}

/// How a job ended that was attended.
struct Attended {
    /// None if unknown: the second stop does not wait for it.
    outcome: Option<JobOutcome>,
    unrecorded: Option<Failure>,
}

impl UnderWay<'_> {
    async fn next(&mut self, recorder: Option<&mut Recorder>) -> Next {
        let Self {
            events,
            signals,
            input,
            control,
            pausing,
            resuming,
            ..
        } = self;
        let paused = async {
            match pausing {
                Some(wish) => wish.await,
                None => std::future::pending().await,
            }
        };
        let resumed = async {
            match resuming {
                Some(wish) => wish.await,
                None => std::future::pending().await,
            }
        };
        let unrecorded = async {
            match recorder {
                Some(recorder) => recorder.failed().await,
                None => std::future::pending().await,
            }
        };
        let next = async {
            tokio::select! {
                biased;
                signal = signals.next() => Next::Signal(signal),
                control = control.next() => Next::Control(control),
                typed = input.next() => Next::Typed(typed),
                resumed = resumed => Next::Resumed(resumed),
                event = events.next() => event.map_or(Next::Over, Next::Event),
                // Behind the events: what is told of the pause is told before this program stops.
                paused = paused => Next::Paused(paused),
                failure = unrecorded => Next::Unrecorded(failure),
            }
        };
        match self.waits {
            Some(what) => attended(self.json, what, next).await,
            None => next.await,
        }
    }

    fn is_paused(&self) -> bool {
        let state = self.job.state();
        matches!(state, JobState::Paused { .. } | JobState::Pausing)
    }

    /// Does what was typed, if it means something.
    fn obeys(&mut self, typed: Typed) -> Obeyed {
        match typed {
            Typed::Line(line) => return Obeyed::Ignored(line),
            Typed::Toggle if !self.is_paused() => self.pauses(),
            Typed::Pause => self.pauses(),
            Typed::Toggle | Typed::Resume => self.resumes(),
            // Keys repeat themselves: only a signal stops what a stop has begun to do.
            Typed::Stop if self.stops.asked => {}
            Typed::Stop => {
                self.stop(Signal::Interrupt);
            }
            Typed::Faster | Typed::Slower => {
                let now = self.job.speed();
                let next = if typed == Typed::Faster {
                    now.saturating_add(SPEEDS).min(FASTEST)
                } else {
                    now.saturating_sub(SPEEDS).max(SLOWEST)
                };
                if let Err(error) = self.job.set_speed(next) {
                    return Obeyed::Refused(error);
                }
            }
        }
        Obeyed::Yes
    }

    fn pauses(&mut self) {
        self.suspension.holds(true);
        drop(self.job.pause(PauseReason::Person));
    }

    fn resumes(&mut self) {
        self.suspension.holds(false);
        self.resuming = Some(Box::pin(self.job.resume()));
    }

    /// Job control wants something.
    fn hears_control(&mut self, control: Control, teller: &Teller<'_>) {
        let act = self.suspension.hears(control, self.is_paused());
        self.acts(act, teller);
    }

    /// Does what a suspension needs next.
    fn acts(&mut self, act: Act, teller: &Teller<'_>) {
        match act {
            Act::Nothing => {}
            Act::Pause => self.pausing = Some(Box::pin(self.job.pause(PauseReason::Person))),
            Act::Stop => {
                let mut goes_on = false;
                teller.suspended(|| {
                    self.input.release();
                    goes_on = self.control.take() == Some(Control::Continue);
                    if !goes_on {
                        JobControl::stop_process();
                    }
                });
                if goes_on {
                    self.hears_control(Control::Continue, teller);
                }
            }
            Act::GoOn => {
                self.input.listen();
                self.resumes();
            }
            Act::Stay { dark } => {
                self.input.listen();
                if dark {
                    teller.say(
                        "the job burns: it stays paused, with the laser off, until you press p",
                    );
                }
            }
            Act::Ends => {
                if self.job.state() != JobState::Ended {
                    teller.say("the job is ending: it is not suspended any more");
                }
            }
        }
    }

    fn hears(&mut self, event: &JobEvent) {
        match event {
            JobEvent::Waits(Waits::Queue) => {
                self.waits = Some("waiting for what the arm still has")
            }
            JobEvent::Waits(Waits::Line) => {
                self.waits = Some("the line broke: waiting for it, to switch the laser off");
            }
            JobEvent::Waits(_) => self.waits = None,
            _ => {}
        }
    }

    /// Stops it; whether that was asked for before.
    fn stop(&mut self, signal: Signal) -> bool {
        self.stops.terminates |= signal == Signal::Terminate;
        self.waits = Some("stopping");
        self.job.stop();
        std::mem::replace(&mut self.stops.asked, true)
    }

    /// After the second stop nothing more is moved. A further signal does not wait for that.
    async fn stopped_again(&mut self) -> Option<JobOutcome> {
        tokio::select! {
            biased;
            _ = self.signals.next() => None,
            outcome = timeout(FAREWELL, self.job.outcome()) => outcome.ok(),
        }
    }
}

/// What came of what was typed.
enum Obeyed {
    Yes,
    /// It is a line that means nothing.
    Ignored(String),
    /// It goes on as fast as before.
    Refused(SpeedError),
}

/// Why a job is no faster and no slower.
fn as_fast_as_before(error: SpeedError) -> String {
    format!("the speed stays as it is: {error}")
}

/// A recording has ended before the work.
fn says_unrecorded(failure: &Failure) -> String {
    let warning = Paint::for_stderr().note("warning:").to_string();
    format!(
        "{warning} the recording ends here, the work goes on: {}",
        failure.message
    )
}
