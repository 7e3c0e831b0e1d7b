//! Event loop of a running job: everything that can happen next, and the user's orders.

use std::pin::Pin;

use magician_job::recording::{RecordError, Recorder};
use magician_job::{
    JobEvent, JobEvents, JobHandle, JobOutcome, JobState, JobWait, PauseError, PauseReason,
    ResumeError, SpeedError, StopOrder,
};
use tokio::time::timeout;

use super::input::{Input, Typed};
use super::suspend::{Act, Suspension};
use super::tell::ProgressReporter;
use super::tui::{Screen, Wants};
use crate::context::STAND_BY;
use crate::interrupt::{Control, JobControl, Signal, Signals};
use crate::progress::attended;

/// Next event.
pub(super) enum Next {
    /// Signal or key that stands for one; `None` inside if the stop rule ignores it.
    Stop(Option<StopOrder>),
    /// Key that stands for a signal, before the stop rule has been applied.
    Pressed(Signal),
    Control(Control),
    Typed(Typed),
    /// Result of the pause that begins a suspension.
    Paused(Result<(), PauseError>),
    /// Result of resuming.
    Resumed(Result<(), ResumeError>),
    Event(JobEvent),
    /// The recording has failed.
    Unrecorded(RecordError),
    Over,
}

type Resuming = Pin<Box<dyn Future<Output = Result<(), ResumeError>>>>;
type Pausing = Pin<Box<dyn Future<Output = Result<(), PauseError>>>>;

/// Step between the speeds that keys select, percent; then the lowest and the highest speed.
const SPEEDS: u8 = 10;
const SLOWEST: u8 = 10;
const FASTEST: u8 = 100;

/// Running job with all sources of its events.
pub(super) struct UnderWay<'a> {
    pub(super) job: JobHandle,
    pub(super) events: JobEvents,
    pub(super) signals: &'a mut Signals,
    pub(super) input: Input,
    control: JobControl,
    pub(super) suspension: Suspension,
    /// True if it shall be suspended as soon as it is checked.
    pub(super) suspends: bool,
    /// Pending pause of a suspension.
    pub(super) pausing: Option<Pausing>,
    /// Pending resumption.
    pub(super) resuming: Option<Resuming>,
    /// True if no input is left that could answer a pause.
    unanswered: bool,
    /// Full-screen picture, if there is one.
    pub(super) screen: Option<Screen>,
    /// Reason of a wait that may be long, for the user.
    waits: Option<&'static str>,
    json: bool,
}

impl<'a> UnderWay<'a> {
    pub(super) fn of(
        job: JobHandle,
        signals: &'a mut Signals,
        control: JobControl,
        input: Input,
        json: bool,
    ) -> Self {
        Self {
            events: job.events(),
            signals,
            input,
            control,
            suspension: Suspension::new(job.burns()),
            suspends: false,
            pausing: None,
            resuming: None,
            unanswered: false,
            screen: None,
            waits: None,
            json,
            job,
        }
    }
}

impl UnderWay<'_> {
    pub(super) async fn next(&mut self, recorder: Option<&mut Recorder>) -> Next {
        let whole = self.screen.is_some();
        let Self {
            events,
            signals,
            input,
            control,
            screen,
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
        let wants = async {
            match screen {
                Some(screen) => screen.next().await,
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
                // Stops come first, so that a stream of other events cannot delay them.
                biased;
                (_, order) = signals.next_order() => Next::Stop(Some(order)),
                control = control.next() => Next::Control(control),
                typed = input.next() => Next::Typed(typed),
                wants = wants => match wants {
                    Wants::Typed(typed) => Next::Typed(typed),
                    Wants::Stop(signal) => Next::Pressed(signal),
                    Wants::Control(control) => Next::Control(control),
                },
                resumed = resumed => Next::Resumed(resumed),
                event = events.next() => event.map_or(Next::Over, Next::Event),
                // After the job's events, so that the pause is shown before this process stops.
                paused = paused => Next::Paused(paused),
                error = unrecorded => Next::Unrecorded(error),
            }
        };
        let next = match self.waits {
            Some(what) if !whole => attended(self.json, what, next).await,
            _ => next.await,
        };
        match next {
            Next::Pressed(signal) => Next::Stop(self.signals.hears(signal)),
            next => next,
        }
    }

    fn is_paused(&self) -> bool {
        let state = self.job.state();
        matches!(state, JobState::Paused { .. } | JobState::Pausing)
    }

    /// Carries out a typed order.
    pub(super) fn obeys(&mut self, typed: Typed) -> Obeyed {
        match typed {
            Typed::Line(line) => return Obeyed::Ignored(line),
            Typed::Toggle if !self.is_paused() => self.pauses(),
            Typed::Pause => self.pauses(),
            Typed::End => {
                self.unanswered = true;
                self.stops_unanswered();
            }
            Typed::Toggle | Typed::Resume => self.resumes(),
            Typed::Stop => self.stops_by_request(),
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

    /// True if the program itself has paused for the user.
    fn waits_for_person(&self) -> bool {
        let JobState::Paused { reason, .. } = self.job.state() else {
            return false;
        };
        matches!(reason, PauseReason::Part | PauseReason::Program)
    }

    /// Stops a job that waits for an answer which cannot come.
    pub(super) fn stops_unanswered(&mut self) {
        if self.unanswered && self.resuming.is_none() && self.waits_for_person() {
            self.stops_by_request();
        }
    }

    /// Stops the job unless it is stopping already: a held key repeats.
    fn stops_by_request(&mut self) {
        if self.signals.hears(Signal::Request).is_some() {
            self.stop();
        }
    }

    /// Takes terminal and keyboard again.
    fn listens(&mut self) {
        self.input.listen();
        if let Some(screen) = &mut self.screen {
            screen.take();
        }
    }

    fn pauses(&mut self) {
        self.suspension.holds(true);
        drop(self.job.pause(PauseReason::Person));
    }

    fn resumes(&mut self) {
        self.suspension.holds(false);
        self.resuming = Some(Box::pin(self.job.resume()));
    }

    /// Handles an event of job control.
    pub(super) fn hears_control(&mut self, control: Control, teller: &ProgressReporter<'_>) {
        let act = self.suspension.hears(control, self.is_paused());
        self.acts(act, teller);
    }

    /// Handles an event of job control during the check: the job is paused before it sends
    /// anything, and the rest of the suspension follows after the pause.
    pub(super) fn hears_early(&mut self, control: Control) {
        if self.suspension.hears(control, self.is_paused()) == Act::Pause {
            self.pausing = Some(Box::pin(self.job.pause(PauseReason::Person)));
        }
    }

    /// Handles the result of the pause during the check: either the job has ended, or the pause is
    /// reported as the next event.
    pub(super) fn is_paused_early(&mut self, paused: Result<(), PauseError>) {
        self.pausing = None;
        if paused.is_ok() {
            self.pausing = Some(Box::pin(std::future::ready(paused)));
        } else {
            let _ = self.suspension.paused(paused);
        }
    }

    /// Carries out the next action of a suspension.
    pub(super) fn acts(&mut self, act: Act, teller: &ProgressReporter<'_>) {
        match act {
            Act::Nothing => {}
            Act::Pause => self.pausing = Some(Box::pin(self.job.pause(PauseReason::Person))),
            Act::Stop => {
                let mut goes_on = false;
                teller.suspended(|| {
                    self.input.release();
                    if let Some(screen) = &mut self.screen {
                        screen.release();
                    }
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
                self.listens();
                // The program waits for the user, so continuing the process is not an answer.
                if !self.waits_for_person() {
                    self.resumes();
                }
            }
            Act::Stay { dark } => {
                self.listens();
                if dark {
                    teller.say("the job burns: it stays paused, laser off, until you press p");
                }
            }
            Act::Ends => {
                if self.job.state() != JobState::Ended {
                    teller.say("the job is ending: it cannot be suspended");
                }
            }
        }
    }

    pub(super) fn hears(&mut self, event: &JobEvent) {
        match event {
            JobEvent::Wait(JobWait::Queue) => {
                self.waits = Some("waiting for the commands left in the arm")
            }
            JobEvent::Wait(JobWait::Line) => {
                self.waits = Some(
                    "the line broke: waiting to switch the laser off when it is \
                    back",
                );
            }
            JobEvent::Wait(_) => self.waits = None,
            _ => {}
        }
    }

    /// Stops the job; a second call stops it at once.
    pub(super) fn stop(&mut self) {
        self.waits = Some("stopping");
        self.job.stop();
    }

    /// Waits for the end after a second stop, which the job keeps short; `None` after a timeout.
    pub(super) async fn stopped_at_once(&mut self) -> Option<JobOutcome> {
        timeout(STAND_BY, self.job.outcome()).await.ok()
    }
}

/// Result of a typed order.
pub(super) enum Obeyed {
    Yes,
    /// The line is not a valid order.
    Ignored(String),
    /// The speed could not be changed.
    Refused(SpeedError),
}
