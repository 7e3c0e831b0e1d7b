//! Events and failures of a stream.

use std::collections::VecDeque;
use std::fmt;

use crate::connection::Failure;

/// An event of a [`Stream`](super::Stream). At most one of each kind is pending, the newest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum StreamEvent {
    /// Progress.
    Sent {
        /// Number of commands of the caller that the controller has accepted.
        accepted: u64,
        /// Index of the first of them.
        first: u64,
        /// Index of the last of them.
        last: u64,
        /// Index of the command finished last, according to the latest reading.
        current: u64,
    },
    /// The queue ran dry although there was work.
    Starved {
        /// Number of times so far.
        times: u64,
    },
    /// The controller's queue has another number of places than assumed; the number read is used
    /// from here on.
    Places {
        /// Number assumed.
        counted: u32,
        /// Number read.
        read: u32,
    },
    /// Commands were lost between others. The queue was stopped and cleared, and all commands
    /// beyond the arm's position are sent again.
    Recovered {
        /// Number of commands sent again.
        again: usize,
        /// Window from here on.
        window: usize,
    },
    /// An interrupted stream continues.
    Resumed {
        /// Number of commands that turned out to have been taken.
        found: usize,
        /// Number of commands offered before the interruption that are still to be sent.
        waiting: usize,
    },
    /// The arm has finished the last command.
    Finished {
        /// Index of that command. `None` if there was no command.
        last: Option<u64>,
    },
    /// The stream has failed, and nothing is sent any more.
    /// [`Stream::leftover`](super::Stream::leftover) returns what was not done.
    Failed(StreamFailure),
}

/// Reason why a [`Stream`](super::Stream) ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StreamFailure {
    /// A request of the stream failed.
    Request(Failure),
    /// The controller gave an index out of order.
    Index {
        /// Index that should have come.
        expected: u64,
        /// Index that came.
        found: u64,
    },
    /// The controller was reset, and its queue is lost.
    Reset {
        /// Current index before.
        before: u64,
        /// Current index now. `None` if the reset was noticed otherwise.
        now: Option<u64>,
    },
    /// The queue holds fewer commands than were put in: it was cleared.
    Dropped {
        /// Number of commands that should be in the queue.
        counted: u32,
        /// Number of commands in the queue.
        read: u32,
    },
    /// The queue did not drain after it was cleared.
    NotDrained {
        /// Free places.
        left: u32,
        /// All places.
        places: u32,
    },
    /// On resuming: this program cannot have led to the last index that the controller gave.
    Tail {
        /// The controller's last index.
        found: u64,
        /// Lowest possible index.
        from: u64,
        /// Highest possible index.
        to: u64,
    },
    /// On resuming: the arm is not at the end of its last finished command; x, y, z in mm, r in
    /// degrees.
    Pose {
        /// Expected pose.
        expected: [f64; 4],
        /// Pose of the arm.
        found: [f64; 4],
    },
    /// On resuming: the pose after the last finished command is unknown.
    PoseUnknown {
        /// Pose of the arm.
        found: [f64; 4],
    },
    /// On resuming: commands that must not run twice may have been lost between others in flight.
    Unclear {
        /// Last confirmed index.
        confirmed: Option<u64>,
        /// The controller's last index.
        found: u64,
    },
}

impl fmt::Display for StreamFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(failure) => write!(f, "a queued command failed: {failure:?}"),
            Self::Index { expected, found } => {
                write!(f, "expected index {expected}, the arm gave {found}")
            }
            Self::Reset {
                before,
                now: Some(now),
            } => write!(
                f,
                "the current index went back from {before} to {now}: the arm was reset"
            ),
            Self::Reset { before, now: None } => {
                write!(f, "the arm was reset after index {before}")
            }
            Self::Dropped { counted, read } => write!(
                f,
                "the queue should hold {counted}, but holds {read}: it was cleared"
            ),
            Self::NotDrained { left, places } => write!(
                f,
                "the cleared queue shows {left} of {places} places and does not drain"
            ),
            Self::Tail { found, from, to } => write!(
                f,
                "the arm's last index is {found}, this program accounts for {from} to {to}"
            ),
            Self::Pose { expected, found } => write!(
                f,
                "the arm should stand at {expected:.2?}, it stands at {found:.2?}"
            ),
            Self::PoseUnknown { found } => write!(
                f,
                "the arm stands at {found:.2?}, its expected position is unknown"
            ),
            Self::Unclear { confirmed, found } => {
                write!(f, "up to queue index {found}")?;
                if let Some(confirmed) = confirmed {
                    write!(f, ", after {confirmed}")?;
                }
                f.write_str(", commands that must not be repeated may be missing")
            }
        }
    }
}

impl std::error::Error for StreamFailure {}

/// Reason why an [`Item`](super::Item) was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// The stream has no [`room`](super::Stream::room).
    Full,
    /// The command cannot be queued.
    NotQueueable,
    /// The command does not fit in a frame.
    TooLong,
    /// The stream was declared finished, or it has failed.
    Over,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the stream is full",
            Self::NotQueueable => "the command cannot be queued",
            Self::TooLong => "the command does not fit in a frame",
            Self::Over => "the stream takes no more commands",
        })
    }
}

impl std::error::Error for Refused {}

/// Pending events: the newest of each kind, in the order in which the kinds first occurred.
#[derive(Clone, Debug)]
pub(super) struct Events(VecDeque<StreamEvent>);

impl Events {
    pub(super) fn new() -> Self {
        Self(VecDeque::with_capacity(8))
    }

    pub(super) fn push(&mut self, event: StreamEvent) {
        let kind = std::mem::discriminant(&event);
        match (self.0.iter_mut()).find(|old| std::mem::discriminant(*old) == kind) {
            // The newest of a kind replaces the older one, so that a slow reader costs no memory.
            Some(old) => *old = event,
            None => self.0.push_back(event),
        }
    }

    pub(super) fn pop(&mut self) -> Option<StreamEvent> {
        self.0.pop_front()
    }
}
