//! Events and failures of a stream.

use std::collections::VecDeque;
use std::fmt;

use crate::connection::Failure;
use crate::{Message, message};

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

impl StreamFailure {
    /// Returns the reason as a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        match self {
            Self::Request(failure) => message!(
                "a queued command failed: {failure}",
                failure = format!("{failure:?}")
            ),
            Self::Index { expected, found } => message!(
                "expected index {expected}, the arm gave {found}",
                expected,
                found
            ),
            Self::Reset {
                before,
                now: Some(now),
            } => message!(
                "the current index went back from {before} to {now}: the arm was reset",
                before,
                now
            ),
            Self::Reset { before, now: None } => {
                message!("the arm was reset after index {before}", before)
            }
            Self::Dropped { counted, read } => message!(
                "the queue should hold {counted}, but holds {read}: it was cleared",
                counted,
                read
            ),
            Self::NotDrained { left, places } => message!(
                "the cleared queue shows {left} of {places} places and does not drain",
                left,
                places
            ),
            Self::Tail { found, from, to } => message!(
                "the arm's last index is {found}, this program accounts for {from} to {to}",
                found,
                from,
                to
            ),
            Self::Pose { expected, found } => message!(
                "the arm should stand at {expected}, it stands at {found}",
                expected = format!("{expected:.2?}"),
                found = format!("{found:.2?}")
            ),
            Self::PoseUnknown { found } => message!(
                "the arm stands at {found}, its expected position is unknown",
                found = format!("{found:.2?}")
            ),
            Self::Unclear {
                confirmed: Some(confirmed),
                found,
            } => message!(
                "up to queue index {found}, after {confirmed}, commands that must not be repeated \
                    may be missing",
                found,
                confirmed
            ),
            Self::Unclear {
                confirmed: None,
                found,
            } => message!(
                "up to queue index {found}, commands that must not be repeated may be missing",
                found
            ),
        }
    }
}

impl fmt::Display for StreamFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
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

impl Refused {
    /// Returns the reason as a sentence.
    #[must_use]
    pub fn sentence(self) -> Message {
        match self {
            Self::Full => message!("the stream is full"),
            Self::NotQueueable => message!("the command cannot be queued"),
            Self::TooLong => message!("the command does not fit in a frame"),
            Self::Over => message!("the stream takes no more commands"),
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
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
