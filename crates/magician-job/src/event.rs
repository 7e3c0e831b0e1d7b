//! What a job tells.

use std::sync::Arc;
use std::time::Duration;

use magician::Ran;
use magician::commands::Pose;
use magician_program::Report;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

use crate::Settled;

/// What a job is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JobState {
    /// It looks at arm and program; nothing has moved.
    Checking,
    /// Its commands go through the arm's queue.
    Running,
    /// The piece under way comes to its end, and the pen goes up.
    Pausing,
    /// Nothing of it waits in the arm, the laser is off, the pen is up. The arm may be moved.
    Paused {
        /// Why.
        reason: PauseReason,
        /// The part that comes next, from 1, where the job pauses between parts.
        part: Option<u64>,
    },
    /// It was stopped: the arm comes to a stand, and the pen goes up.
    Stopping,
    /// All steps are done: the pen goes up, the tool is parked, settings are restored.
    Ending,
    /// It is over: [`JobHandle::outcome`](crate::JobHandle::outcome) tells how.
    Ended,
}

impl JobState {
    /// Its name in interfaces: `checking`, `running`, `pausing`, `paused`, `stopping`, `ending`, `ended`.
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

/// Why a job is paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PauseReason {
    /// A person asked for it.
    Person,
    /// The lease of its starter has ended.
    Lease,
    /// A part of the work is done.
    Part,
    /// The program says so.
    Program,
}

impl PauseReason {
    /// Its name in interfaces: `person` (a lost lease as well), `part`, `program`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Person | Self::Lease => "person",
            Self::Part => "part",
            Self::Program => "program",
        }
    }
}

/// How far a job is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct JobProgress {
    /// Steps that the arm has finished, over all loops, with those that were passed over at the beginning.
    pub step: u64,
    /// All steps; none of a job without end.
    pub steps: Option<u64>,
    /// The loop under way, from 1.
    pub iteration: u64,
    /// How long the rest takes by the arm's clock, if that is known.
    pub left: Option<Duration>,
    /// How long the arm has not answered, while it is waited for.
    pub silent: Duration,
}

/// Where a job that was resumed goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StartsAt {
    /// Steps that are done.
    pub steps: u64,
    /// The next was cut short and goes on where it was stopped.
    pub within: bool,
    /// The next was cut short, or its end is unknown: it is repeated from its beginning.
    pub again: bool,
    /// Length that is burnt twice, mm.
    pub burnt_twice: f64,
    /// True if that is the most: the step is repeated, or it is not known exactly where the light went out.
    pub at_most: bool,
    /// Nothing of the earlier job had come to the arm's queue.
    pub nothing_queued: bool,
}

/// What a job waits for, longer than for an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Waits {
    /// For what an earlier job has left in the arm's queue.
    Queue,
    /// For a line that broke while the laser burnt, to switch it off.
    Line,
    /// For nothing any more.
    Nothing,
}

/// Something that a job tells.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobEvent {
    /// It does something else now.
    State(JobState),
    /// How far it is; at most ten times a second.
    Progress(JobProgress),
    /// What became of settings that ended processes have left changed.
    Settled(Settled),
    /// An earlier run of the same program at this arm was cut off (its process was killed, the computer failed), and this job does
    /// not resume it: the earlier one has finished at least so many steps.
    Unfinished {
        /// Steps that it has finished, at least.
        finished: u64,
        /// True if the arm still tells how far it came: the earlier run can be resumed.
        resumable: bool,
    },
    /// Its progress cannot be kept, with the cause; told once. The job goes on, and cannot be resumed
    /// after its end unless a later write succeeds ([`JobError::unkept`](crate::JobError::unkept)).
    Unkept(Arc<str>),
    /// Where it begins, if that is not the first step, once all is checked.
    Starts(StartsAt),
    /// It waits.
    Waits(Waits),
    /// What is not sent yet has this share of its speed, percent.
    Speed(u8),
}

/// The events of a job, from [`JobHandle::events`](crate::JobHandle::events).
#[derive(Debug)]
pub struct JobEvents {
    receiver: broadcast::Receiver<JobEvent>,
    over: bool,
}

impl JobEvents {
    pub(crate) const fn new(receiver: broadcast::Receiver<JobEvent>, over: bool) -> Self {
        Self { receiver, over }
    }

    /// The next event; `None` when the job is over. A slow reader misses the oldest events:
    /// [`JobHandle::state`](crate::JobHandle::state) and [`JobHandle::progress`](crate::JobHandle::progress) have the present.
    pub async fn next(&mut self) -> Option<JobEvent> {
        while !self.over {
            match self.receiver.recv().await {
                Ok(event) => {
                    self.over = event == JobEvent::State(JobState::Ended);
                    return Some(event);
                }
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => self.over = true,
            }
        }
        None
    }
}

/// What a job has come to.
#[derive(Debug)]
#[non_exhaustive]
pub struct Done {
    /// The steps that were done.
    pub steps: u64,
    /// The first of them, from 0.
    pub from: u64,
    /// The commands that the arm took for them.
    pub ran: Ran,
    /// How long it took by the arm's clock, with its pauses.
    pub seconds: f64,
    /// What was found before anything moved.
    pub report: Report,
    /// How the tool stands, where something is made of that.
    pub end: Option<End>,
}

/// How the tool stands when all is done.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct End {
    /// Where.
    pub pose: Pose,
    /// Whether the pen of a drawing is up; none for other programs.
    pub pen_is_up: Option<bool>,
    /// Whether it was parked.
    pub parked: bool,
}
