//! A job that is under way: all that can happen to it next, and what a person wants of it.

use std::pin::Pin;

use magician_job::recording::{RecordError, Recorder};
use magician_job::{
    JobEvent, JobEvents, JobHandle, JobOutcome, JobState, PauseError, PauseReason, ResumeError,
    SpeedError, StopOrder, Waits,
};
use tokio::time::timeout;

use super::input::{Input, Typed};
use super::suspend::{Act, Suspension};
use super::tell::ProgressReporter;
use super::tui::{Screen, Wants};
use crate::context::STAND_BY;
use crate::interrupt::{Control, JobControl, Signal, Signals};
use crate::progress::attended;

/// What comes next.
pub(super) enum Next {
    /// A signal, or a key that stands for one; `None` if it changes nothing.
    Stop(Option<StopOrder>),
    /// A key that stands for a signal, before the rule for stops has heard it.
    Pressed(Signal),
    Control(Control),
    Typed(Typed),
    /// What came of the pause that a suspension begins with.
    Paused(Result<(), PauseError>),
    /// What came of the wish to go on.
    Resumed(Result<(), ResumeError>),
    Event(JobEvent),
    /// The recording cannot go on.
    Unrecorded(RecordError),
    Over,
}

type Resuming = Pin<Box<dyn Future<Output = Result<(), ResumeError>>>>;
type Pausing = Pin<Box<dyn Future<Output = Result<(), PauseError>>>>;

/// Between two speeds that keys choose, percent, and the least and the most of them.
const SPEEDS: u8 = 10;
const SLOWEST: u8 = 10;
const FASTEST: u8 = 100;

/// A job that is under way.
pub(super) struct UnderWay<'a> {
    pub(super) job: JobHandle,
    pub(super) events: JobEvents,
    pub(super) signals: &'a mut Signals,
    pub(super) input: Input,
    control: JobControl,
    pub(super) suspension: Suspension,
    /// Whether it is to be suspended as soon as it is checked.
    pub(super) suspends: bool,
    /// What becomes of the pause that a suspension begins with.
    pub(super) pausing: Option<Pausing>,
    /// What becomes of the wish to go on.
    pub(super) resuming: Option<Resuming>,
    /// Whether nobody can answer a pause any more.
    unanswered: bool,
    /// The whole terminal, if it has it.
    pub(super) screen: Option<Screen>,
    /// What is waited for, if that may take a while.
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
                // After the events: the pause is shown before this program stops.
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

    /// Does what was typed, if it means something.
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

    /// Whether it waits for a person because the program says so.
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

    /// Stops it, if it is not being stopped: keys repeat themselves.
    fn stops_by_request(&mut self) {
        if self.signals.hears(Signal::Request).is_some() {
            self.stop();
        }
    }

    /// Takes the terminal again.
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

    /// Job control wants something.
    pub(super) fn hears_control(&mut self, control: Control, teller: &ProgressReporter<'_>) {
        let act = self.suspension.hears(control, self.is_paused());
        self.acts(act, teller);
    }

    /// The same while it is checked: it is paused before anything is sent, and all else follows when it is.
    pub(super) fn hears_early(&mut self, control: Control) {
        if self.suspension.hears(control, self.is_paused()) == Act::Pause {
            self.pausing = Some(Box::pin(self.job.pause(PauseReason::Person)));
        }
    }

    /// What came of that while it is checked still: it ends before, or its pause is told next.
    pub(super) fn is_paused_early(&mut self, paused: Result<(), PauseError>) {
        self.pausing = None;
        if paused.is_ok() {
            self.pausing = Some(Box::pin(std::future::ready(paused)));
        } else {
            let _ = self.suspension.paused(paused);
        }
    }

    /// Does what a suspension needs next.
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
                // What the program waits for is not done by that.
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
            JobEvent::Waits(Waits::Queue) => {
                self.waits = Some("waiting for the commands left in the arm")
            }
            JobEvent::Waits(Waits::Line) => {
                self.waits = Some(
                    "the line broke: waiting to switch the laser off when it is \
                    back",
                );
            }
            JobEvent::Waits(_) => self.waits = None,
            _ => {}
        }
    }

    /// Stops it; at once if it is being stopped.
    pub(super) fn stop(&mut self) {
        self.waits = Some("stopping");
        self.job.stop();
    }

    /// Waits for the end after a second stop, which the job keeps short; `None` if it does not come.
    pub(super) async fn stopped_at_once(&mut self) -> Option<JobOutcome> {
        timeout(STAND_BY, self.job.outcome()).await.ok()
    }
}

/// What came of what was typed.
pub(super) enum Obeyed {
    Yes,
    /// It is a line that means nothing.
    Ignored(String),
    /// It goes on as fast as before.
    Refused(SpeedError),
}
