use std::fmt;
use std::sync::Arc;

use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

use super::Arm;
use crate::{Alarm, QueueIndex};

/// How many events are kept for a slow reader.
pub(super) const KEPT: usize = 256;

/// An event of the arm or its connection. Events come from frames that pass over the line anyway, the answers to waits,
/// runs, reads and [state watches](Arm::state): they cause no reads of their own, and without reads no events arise. To
/// learn of an alarm within 100 ms, keep a state watch at 10 Hz.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// An alarm stands that did not at the last reading. [`Alarm::with_code`](crate::Alarm::with_code) tells its name,
    /// cause and remedy.
    AlarmRaised {
        /// Its code, 0x00 to 0xFF.
        code: u8,
    },
    /// An alarm stands no more.
    AlarmCleared {
        /// Its code, 0x00 to 0xFF.
        code: u8,
    },
    /// Queued commands have finished, from any program: one, or all from `first` to `last` between two readings.
    CommandFinished {
        /// Index of the first.
        first: QueueIndex,
        /// Index of the last.
        last: QueueIndex,
    },
    /// The line broke.
    LinkLost {
        /// How, in a sentence.
        why: Arc<str>,
    },
    /// The line is back, and the same arm is at it.
    LinkFound {
        /// The arm was reset meanwhile: what was in its queue is gone. An [`Event::Reset`] went before.
        reset: bool,
    },
    /// The arm was switched off and on, or reset.
    Reset {
        /// Indices, first and last, that this connection had queued and that had not finished.
        gone: Option<(QueueIndex, QueueIndex)>,
    },
    /// The arm has taken more commands than this connection sent: the network doubled one, or another program uses it.
    Unaccounted {
        /// First index.
        from: QueueIndex,
        /// Last index.
        to: QueueIndex,
    },
    /// Events were not read for so long that the oldest were dropped.
    Missed {
        /// How many.
        events: u64,
    },
}

/// What happened, in words.
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

/// The events of a connection from [`Arm::events`] on. It does not keep the connection.
#[derive(Debug)]
pub struct Events {
    receiver: Option<broadcast::Receiver<Event>>,
}

impl Events {
    /// The next event, waited for; `None` when the connection has ended.
    pub async fn next(&mut self) -> Option<Event> {
        match self.receiver.as_mut()?.recv().await {
            Ok(event) => Some(event),
            Err(RecvError::Lagged(events)) => Some(Event::Missed { events }),
            Err(RecvError::Closed) => None,
        }
    }
}

impl Arm {
    /// What happens from now on, for any number of listeners. Each may fall 256 events behind; then it
    /// [misses](Event::Missed) the oldest.
    #[must_use]
    pub fn events(&self) -> Events {
        let sender = self.inner.shared.events.upgrade();
        Events {
            receiver: sender.map(|sender| sender.subscribe()),
        }
    }
}
