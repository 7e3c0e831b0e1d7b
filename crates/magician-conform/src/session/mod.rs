//! Execution of the steps of a case on an arm.

mod state;
mod wire;

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::{ArmInstant, Deframer, FrameBuf};

use crate::report::Mismatch;
use crate::step::{Action, Observation, Step};
use crate::target::Target;

/// Time without a frame that counts as silence. Choice.
pub(crate) const QUIET: Duration = Duration::from_millis(200);
/// Tolerance for reading the time over a line and for polling. Choice.
const SLACK: Duration = Duration::from_millis(100);
/// Longest duration of anything: homing, and a jog through the whole range. Choice.
const LONGEST: Duration = Duration::from_secs(120);
/// Longest time that passes without a poll. Choice.
const MAX_UNPOLLED_TIME: Duration = Duration::from_secs(1);
/// Time with an equal pose after which the arm counts as at rest. Choice.
const REST_TIME: Duration = Duration::from_millis(100);

/// Reason for the end of a case.
#[derive(Debug)]
pub(crate) enum CaseStop {
    /// The arm deviated.
    Mismatch(Box<Mismatch>),
    /// The line is lost.
    Line(magician::Error),
}

impl From<magician::Error> for CaseStop {
    fn from(error: magician::Error) -> Self {
        Self::Line(error)
    }
}

/// Deviation in a step, before the step is known.
struct Difference {
    expected: String,
    got: String,
    received: Vec<u8>,
}

enum StepError {
    Difference(Difference),
    Line(magician::Error),
}

impl From<magician::Error> for StepError {
    fn from(error: magician::Error) -> Self {
        Self::Line(error)
    }
}

type StepResult = Result<(), StepError>;

fn differs<T>(
    expected: impl Into<String>,
    got: impl Into<String>,
    received: &[u8],
) -> Result<T, StepError> {
    Err(StepError::Difference(Difference {
        expected: expected.into(),
        got: got.into(),
        received: received.to_vec(),
    }))
}

/// Conversation with an arm, and the state known from it.
pub(crate) struct Session<T> {
    pub(crate) target: T,
    /// Longest time for an answer.
    patience: Duration,
    deframer: Deframer,
    inbox: VecDeque<FrameBuf>,
    sent: Vec<u8>,
    /// Last finished index when the case began.
    before: u64,
    /// Index of the last queued command.
    last: Option<u64>,
    /// Time of the last set or queued command on the arm's clock; not read over a line unless a
    /// step needs it.
    command_time: ArmInstant,
    timed: bool,
}

impl<T: Target> Session<T> {
    pub(crate) fn new(target: T, patience: Duration) -> Self {
        Self {
            target,
            patience,
            deframer: Deframer::new(),
            inbox: VecDeque::new(),
            sent: Vec::new(),
            before: 0,
            last: None,
            command_time: ArmInstant::ZERO,
            timed: false,
        }
    }

    /// Forgets the previous case, including bytes in flight.
    pub(crate) async fn begin(&mut self) -> magician::Result<()> {
        while !self.target.receive(Duration::ZERO).await?.is_empty() {}
        self.deframer = Deframer::new();
        self.inbox.clear();
        self.sent.clear();
        self.last = None;
        Ok(())
    }

    /// Executes the steps of a case.
    pub(crate) async fn run(&mut self, steps: &[Step]) -> Result<(), CaseStop> {
        let clocked = |step: &Step| matches!(step.action, Action::At(_) | Action::Done(Some(_)));
        // Each reading of the clock costs an exchange, which would blur untimed cases too.
        self.timed = self.target.stepped().is_some() || steps.iter().any(clocked);
        let started = self.start().await;
        self.in_step(started, 0, "the case begins")?;
        for step in steps {
            for _ in 0..step.times {
                let done = self.step(&step.action).await;
                self.in_step(done, step.line, &step.text)?;
            }
        }
        // An unexpected second answer to the last step would otherwise spoil the next case.
        let quiet = self.nothing(Duration::from_millis(60)).await;
        self.in_step(quiet, 0, "the case ends")
    }

    /// Executes the steps that lead to the initial state.
    pub(crate) async fn prepare(&mut self, steps: &[Step]) -> Result<(), CaseStop> {
        // The steps to the initial state have no times.
        self.timed = false;
        for step in steps {
            let done = self.step(&step.action).await;
            self.in_step(done, 0, &format!("before the case: {}", step.text))?;
        }
        Ok(())
    }

    fn in_step(&self, done: StepResult, line: usize, step: &str) -> Result<(), CaseStop> {
        done.map_err(|trouble| match trouble {
            StepError::Line(error) => CaseStop::Line(error),
            StepError::Difference(Difference {
                expected,
                got,
                received,
            }) => CaseStop::Mismatch(Box::new(Mismatch {
                line,
                step: step.to_owned(),
                sent: self.sent.clone(),
                expected,
                got,
                received,
            })),
        })
    }

    async fn start(&mut self) -> StepResult {
        self.last = None;
        // Earlier cases may have used the queue, so `finished nothing` means this index.
        self.before = self.current().await?;
        self.mark_command_time().await
    }

    fn sees(&mut self, observation: Observation) -> StepResult {
        match self.target.sees(observation.observable) {
            Some(found) if (found - observation.wanted).abs() <= observation.tolerance => Ok(()),
            found => differs(
                format!("{:?} at {}", observation.observable, observation.wanted),
                found.map_or("nothing observes it".to_owned(), |found| found.to_string()),
                &[],
            ),
        }
    }

    async fn step(&mut self, action: &Action) -> StepResult {
        match action {
            Action::Send(bytes) => {
                self.send(bytes).await?;
                // On a line the answer to a reading of the clock could mix with the one under test.
                if self.target.stepped().is_some() {
                    self.mark_command_time().await?;
                }
                Ok(())
            }
            Action::Ask(frame, answer) => {
                self.send(frame.bytes()).await?;
                self.answered(answer).await
            }
            Action::Answered(answer) => self.answered(answer).await,
            Action::Reply(bytes) => self.reply(bytes).await,
            Action::Silence => self.nothing(QUIET).await,
            Action::Wait(span) => Ok(self.target.pass(*span).await?),
            Action::At(span) => self.at(*span).await,
            Action::Done(when) => self.done(*when).await,
            Action::Rest => self.rest().await,
            Action::Finished(finished) => self.finished(*finished).await,
            Action::Alarms(alarms) => self.alarms(alarms).await,
            Action::Happens(event) => {
                if self.target.happens(*event) {
                    self.mark_command_time().await
                } else {
                    differs(
                        "that this can be made to happen",
                        "only a virtual arm inside this program can",
                        &[],
                    )
                }
            }
            Action::Sees(observations) => observations
                .iter()
                .try_for_each(|observation| self.sees(*observation)),
            Action::Link(link) => {
                if self.target.select(*link) {
                    Ok(())
                } else {
                    differs("a second link", "this arm has one", &[])
                }
            }
        }
    }
}
