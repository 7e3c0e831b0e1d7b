//! Events of an arm and its connection, broadcast to any number of listeners.

use std::fmt;
use std::sync::Arc;

use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

use super::Arm;
use crate::{Alarm, QueueIndex};

/// Events buffered for a slow listener before the oldest are dropped. Choice: room for a listener
/// that pauses for some seconds, at a few kilobytes per connection.
pub(super) const KEPT: usize = 256;

/// Event of the arm or its connection.
///
/// Events come from frames that pass over the line anyway: replies to waits, runs, reads and
/// [state watches](Arm::state). They cause no reads of their own, so without reads there are no
/// events. To learn of an alarm within 100 ms, keep a state watch at 10 Hz.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// An alarm became active since the last reading. [`Alarm::with_code`](crate::Alarm::with_code)
    /// returns its name, cause and remedy.
    AlarmRaised {
        /// Code of the alarm, 0x00 to 0xFF.
        code: u8,
    },
    /// An alarm is no longer active.
    AlarmCleared {
        /// Code of the alarm, 0x00 to 0xFF.
        code: u8,
    },
    /// Queued commands of any program have finished: one, or all from `first` to `last` between two
    /// readings.
    CommandFinished {
        /// Index of the first command.
        first: QueueIndex,
        /// Index of the last command.
        last: QueueIndex,
    },
    /// The line broke.
    LinkLost {
        /// Cause, as a sentence.
        why: Arc<str>,
    },
    /// The line is up again, and the same arm is on it.
    LinkFound {
        /// True if the arm was reset meanwhile, so that the commands in its queue are gone. An
        /// [`Event::Reset`] precedes this event.
        reset: bool,
    },
    /// The arm was power-cycled or reset.
    Reset {
        /// First and last index of the unfinished commands of this connection; `None` if all had
        /// finished.
        gone: Option<(QueueIndex, QueueIndex)>,
    },
    /// The arm took more commands than this connection sent: the network duplicated one, or another
    /// program uses the arm.
    Unaccounted {
        /// First index.
        from: QueueIndex,
        /// Last index.
        to: QueueIndex,
    },
    /// The listener was too slow, and the oldest events were dropped.
    Missed {
        /// Number of dropped events.
        events: u64,
    },
}

/// Describes the event as a sentence.
impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AlarmRaised { code } => match Alarm::with_code(*code) {
                Some(alarm) => write!(f, "alarm {code:#04x} {}: {}", alarm.name, alarm.cause),
                None => write!(f, "alarm {code:#04x}"),
            },
            Self::AlarmCleared { code } => {
                let name = Alarm::with_code(*code).map_or("", |alarm| alarm.name);
                write!(f, "alarm {code:#04x} {name} is gone")
            }
            Self::CommandFinished { first, last } if first == last => {
                write!(f, "command {} finished", first.0)
            }
            Self::CommandFinished { first, last } => {
                write!(f, "commands {} to {} finished", first.0, last.0)
            }
            Self::LinkLost { why } => write!(f, "the line broke: {why}"),
            Self::LinkFound { reset: true } => f.write_str("the line is back; the arm was reset"),
            Self::LinkFound { reset: false } => f.write_str("the line is back"),
            Self::Reset { gone: None } => f.write_str("the arm was reset"),
            Self::Reset {
                gone: Some((first, last)),
            } => write!(
                f,
                "the arm was reset: commands {} to {} are lost",
                first.0, last.0
            ),
            Self::Unaccounted { from, to } => write!(
                f,
                "commands {} to {} were queued by another program",
                from.0, to.0
            ),
            Self::Missed { events } => write!(f, "{events} events were missed"),
        }
    }
}

/// Listener for the events of a connection since [`Arm::events`]. It does not keep the connection
/// open.
#[derive(Debug)]
pub struct Events {
    receiver: Option<broadcast::Receiver<Event>>,
}

impl Events {
    /// Waits for the next event; `None` once the connection has ended.
    pub async fn next(&mut self) -> Option<Event> {
        match self.receiver.as_mut()?.recv().await {
            Ok(event) => Some(event),
            // Reported in place of the lost events, so that a listener can read the state again.
            Err(RecvError::Lagged(events)) => Some(Event::Missed { events }),
            Err(RecvError::Closed) => None,
        }
    }
}

impl Arm {
    /// Returns a listener for the events from now on. There may be any number of listeners. One
    /// that falls more than 256 events behind [misses](Event::Missed) the oldest.
    #[must_use]
    pub fn events(&self) -> Events {
        // Weak: a handle must not keep the channel open after the task has ended.
        let sender = self.inner.shared.events.upgrade();
        Events {
            receiver: sender.map(|sender| sender.subscribe()),
        }
    }
}
