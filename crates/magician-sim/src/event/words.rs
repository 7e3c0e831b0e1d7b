//! Events in words.

use std::fmt;

use magician_protocol::{Alarm, Row};

use super::{Event, Refusal};

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Accepted { index, id } => write!(f, "{index} {} accepted", Name(id)),
            Self::Started { index, id } => write!(f, "{index} {} started", Name(id)),
            Self::Finished { index, id } => write!(f, "{index} {} finished", Name(id)),
            Self::Dropped { count } => write!(f, "{count} waiting commands dropped"),
            Self::QueueFull { id } => write!(f, "{} not taken: the queue is full", Name(id)),
            Self::Refused { id, reason } => write!(f, "{} not carried out: {reason}", Name(id)),
            Self::AlarmRaised { code } => write!(f, "alarm {} raised", Code(code)),
            Self::AlarmCleared { code } => write!(f, "alarm {} cleared", Code(code)),
            Self::NotSimulated { row } => write!(
                f,
                "{} is answered, but the virtual arm does not act on it yet",
                row.name
            ),
            Self::BadFrame { .. } => f.write_str("a damaged frame was ignored"),
            Self::UnknownId { id, .. } => write!(f, "unknown command id {id}: no answer"),
            Self::Overrun { .. } => f.write_str("a request was dropped: its replies are not read"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Parameters => "its parameter count fits no accepted form",
            Self::Unplannable => "its motion cannot be planned",
            Self::UnknownMode => "its mode has no meaning",
            Self::Pin => "there is no such pin, or it does not do that",
            Self::Pose => "the pose cannot be set now, or not to this",
        })
    }
}

/// A command by its id.
struct Name(u8);

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Row::with_id(self.0) {
            Some(row) => f.write_str(row.name),
            None => self.0.fmt(f),
        }
    }
}

/// An alarm by its code.
struct Code(u8);

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#04x}", self.0)?;
        match Alarm::with_code(self.0) {
            Some(alarm) => write!(f, " {}", alarm.name),
            None => Ok(()),
        }
    }
}
