use std::collections::VecDeque;
use std::fmt;

use crate::connection::Failure;

/// What a [`Stream`](super::Stream) has to tell. Of each kind at most one waits to be polled, the newest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum StreamEvent {
    /// How far it has come.
    Sent {
        /// Commands of the caller that the controller has taken.
        accepted: u64,
        /// Index of the first.
        first: u64,
        /// Index of the last.
        last: u64,
        /// Index of the command that the arm finished last, as read last.
        current: u64,
    },
    /// The queue ran dry while there was work: so often by now.
    Starved {
        /// How often.
        times: u64,
    },
    /// The controller shows another number of places than was counted with; what it shows is used from here on.
    Places {
        /// As was counted with.
        counted: u32,
        /// As the controller shows.
        read: u32,
    },
    /// Commands were lost between others. The queue was stopped and cleared, and what does not lead to where the arm stands
    /// goes again.
    Recovered {
        /// So many commands go again.
        again: usize,
        /// The window from here on.
        window: usize,
    },
    /// An interrupted stream goes on.
    Resumed {
        /// So many commands had been taken of which that was not known.
        found: usize,
        /// So many of those that were offered before the interruption are still to be sent.
        waiting: usize,
    },
    /// The arm has finished the last command.
    Finished {
        /// Its index; `None` when there was none.
        last: Option<u64>,
    },
    /// It is over, and nothing goes out any more. [`Stream::leftover`](super::Stream::leftover) has what was not done.
    Failed(StreamFailure),
}

/// Why a [`Stream`](super::Stream) ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StreamFailure {
    /// A request of the stream failed.
    Request(Failure),
    /// The controller gave an index out of order.
    Index {
        /// What would have followed.
        expected: u64,
        /// What came.
        found: u64,
    },
    /// The controller was reset, and what it had queued is gone.
    Reset {
        /// Current index before.
        before: u64,
        /// Current index now, when that is what went back.
        now: Option<u64>,
    },
    /// The queue holds less than was put in: it was cleared.
    Dropped {
        /// Commands that should be in it.
        counted: u32,
        /// Commands that are.
        read: u32,
    },
    /// The queue did not drain after it was cleared.
    NotDrained {
        /// Free places that it shows.
        left: u32,
        /// Places in all.
        places: u32,
    },
    /// On resuming: the last index that the controller gave is none that this program can have led to.
    Tail {
        /// The controller's last index.
        found: u64,
        /// Least that fits.
        from: u64,
        /// Most that fits.
        to: u64,
    },
    /// On resuming: the arm is not where its last finished command leaves it; x, y, z in mm, r in degrees.
    Pose {
        /// Where that is.
        expected: [f64; 4],
        /// Where the arm stands.
        found: [f64; 4],
    },
    /// On resuming: the position after the last finished command is unknown.
    PoseUnknown {
        /// Where the arm stands.
        found: [f64; 4],
    },
    /// On resuming: commands that must not be done twice may have been lost among others in flight.
    Unclear {
        /// Last index beyond doubt.
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

/// Why an [`Item`](super::Item) was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// There is no [`room`](super::Stream::room).
    Full,
    /// The command cannot be queued.
    NotQueueable,
    /// The command does not fit in a frame.
    TooLong,
    /// The stream was told that no more comes, or it has failed.
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

/// Events that wait: of each kind the newest, in the order in which the kinds came.
#[derive(Clone, Debug)]
pub(super) struct Events(VecDeque<StreamEvent>);

impl Events {
    pub(super) fn new() -> Self {
        Self(VecDeque::with_capacity(8))
    }

    pub(super) fn push(&mut self, event: StreamEvent) {
        let kind = std::mem::discriminant(&event);
        match (self.0.iter_mut()).find(|old| std::mem::discriminant(*old) == kind) {
            Some(old) => *old = event,
            None => self.0.push_back(event),
        }
    }

    pub(super) fn pop(&mut self) -> Option<StreamEvent> {
        self.0.pop_front()
    }
}
