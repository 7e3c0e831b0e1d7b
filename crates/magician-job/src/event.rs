//! States, progress and events of a job.

use std::sync::Arc;
use std::time::Duration;

use magician::RunSummary;
use magician::commands::Pose;
use magician_program::Report;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

use crate::RecoveredSettings;

/// Phase of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JobState {
    /// The engine checks arm and program; nothing has moved.
    Checking,
    /// Commands go through the arm's queue.
    Running,
    /// The command in progress runs to its end, and the pen goes up.
    Pausing,
    /// Laser off, pen up, no commands waiting in the arm. The arm may be moved.
    Paused {
        /// Reason of the pause.
        reason: PauseReason,
        /// Next part, counted from 1, if the job pauses between parts.
        part: Option<u64>,
    },
    /// The job was stopped: the arm comes to rest, and the pen goes up.
    Stopping,
    /// All steps are done: the pen goes up, the tool is parked, settings are restored.
    Ending,
    /// The job is over; [`JobHandle::outcome`](crate::JobHandle::outcome) returns its result.
    Ended,
}

impl JobState {
    /// Name of the state in interfaces: `checking`, `running`, `pausing`, `paused`, `stopping`,
    /// `ending`, `ended`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Checking => "checking",
            Self::Running => "running",
            Self::Pausing => "pausing",
            Self::Paused { .. } => "paused",
            Self::Stopping => "stopping",
            Self::Ending => "ending",
            Self::Ended => "ended",
        }
    }
}

/// Reason of a pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PauseReason {
    /// Requested by a person.
    Person,
    /// The lease of the client that started the job ended.
    Lease,
    /// A part of the work is done.
    Part,
    /// A pause step of the program.
    Program,
}

impl PauseReason {
    /// Name of the reason in interfaces: `person` (also for a lost lease), `part`, `program`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Person | Self::Lease => "person",
            Self::Part => "part",
            Self::Program => "program",
        }
    }
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct JobProgress {
    /// Finished steps over all loops, including those skipped at the start.
    pub step: u64,
    /// Number of all steps; `None` for an endless job.
    pub steps: Option<u64>,
    /// Current loop, counted from 1.
    pub iteration: u64,
    /// Remaining time by the arm's clock, if known.
    pub remaining: Option<Duration>,
    /// Time since the arm's last answer while the driver waits for one.
    pub silent: Duration,
}

/// Place where a resumed job starts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StartPlace {
    /// Number of finished steps.
    pub steps: u64,
    /// True if the next step was cut short and continues where it was stopped.
    pub within: bool,
    /// True if the next step is repeated from its beginning, because it was cut short or its end is
    /// unknown.
    pub again: bool,
    /// Length that is burnt twice, mm.
    pub burnt_twice: f64,
    /// True if that is an upper bound: the step is repeated, or where the laser went out is not
    /// known exactly.
    pub is_upper_bound: bool,
    /// True if no command of the earlier job reached the arm's queue.
    pub nothing_queued: bool,
}

/// Longer waits of a job, beyond a normal reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JobWait {
    /// For commands that an earlier job left in the arm's queue.
    Queue,
    /// For a line that broke while the laser burnt, to switch it off.
    Line,
    /// The wait is over.
    Over,
}

/// Event of a job.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobEvent {
    /// The job entered another state.
    State(JobState),
    /// Progress, at most ten times a second.
    Progress(JobProgress),
    /// Result of restoring settings that dead processes left changed.
    RecoveredSettings(RecoveredSettings),
    /// An earlier run of the same program at this arm was interrupted (its process was killed, the
    /// computer failed), and this job does not resume it.
    Unfinished {
        /// Steps that it has finished at least.
        finished: u64,
        /// True if the arm can still report how far it came, so that the earlier run can be
        /// resumed.
        resumable: bool,
    },
    /// Progress cannot be stored, with the cause; reported once. The job continues, and cannot be
    /// resumed after its end unless a later write succeeds
    /// ([`JobError::storage_error`](crate::JobError::storage_error)).
    NotStored(Arc<str>),
    /// Place where the job starts, if not at the first step; sent once everything is checked.
    Start(StartPlace),
    /// The job waits, or stopped waiting.
    Wait(JobWait),
    /// Speed of the commands not sent yet, percent.
    Speed(u8),
}

/// Stream of a job's events, from [`JobHandle::events`](crate::JobHandle::events).
#[derive(Debug)]
pub struct JobEvents {
    receiver: broadcast::Receiver<JobEvent>,
    over: bool,
}

impl JobEvents {
    pub(crate) const fn new(receiver: broadcast::Receiver<JobEvent>, over: bool) -> Self {
        Self { receiver, over }
    }

    /// Waits for the next event; `None` when the job is over.
    ///
    /// A slow reader misses the oldest events: [`JobHandle::state`](crate::JobHandle::state) and
    /// [`JobHandle::progress`](crate::JobHandle::progress) have the current values.
    pub async fn next(&mut self) -> Option<JobEvent> {
        while !self.over {
            match self.receiver.recv().await {
                Ok(event) => {
                    self.over = event == JobEvent::State(JobState::Ended);
                    return Some(event);
                }
                // Events were missed; the next receive returns the oldest one left.
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => self.over = true,
            }
        }
        None
    }
}

/// Result of a job that ran to its end.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobSummary {
    /// Number of steps done.
    pub steps: u64,
    /// First of them, counted from 0.
    pub from: u64,
    /// Commands that the arm took for them.
    pub ran: RunSummary,
    /// Duration by the arm's clock, pauses included, s.
    pub seconds: f64,
    /// Report of the check before anything moved.
    pub report: Report,
    /// Final state of the tool; `None` if the job neither draws nor parks.
    pub end: Option<FinalState>,
}

/// State of the tool after the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FinalState {
    /// Pose of the arm.
    pub pose: Pose,
    /// True if the pen of a drawing is up; `None` for other programs.
    pub pen_is_up: Option<bool>,
    /// True if the tool was parked.
    pub parked: bool,
}
