//! An arm that a program has connected, and what is to be written to it.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::Value;

use super::Asked;
use crate::params::Manner;
use crate::waits::Waits;

/// Something that is to be written to an arm, one after the other.
#[derive(Debug)]
pub(crate) struct Write {
    pub(crate) asked: Asked,
    /// The station's method.
    pub(crate) method: &'static str,
    pub(crate) params: Value,
    pub(crate) queued: bool,
    /// How long it may take: for room in the queue, and then until it has ended.
    pub(crate) timeout: Duration,
    /// How it is answered.
    pub(crate) end: WriteEnd,
    /// When a queue that stays full is given up.
    pub(crate) give_up: Option<HostInstant>,
}

impl Write {
    /// One that acts at once.
    pub(crate) fn new(asked: &Asked, method: &'static str, params: Value, end: WriteEnd) -> Self {
        Self {
            asked: asked.clone(),
            method,
            params,
            queued: false,
            timeout: Duration::ZERO,
            end,
            give_up: None,
        }
    }

    /// Carried out as the program asks for it.
    pub(crate) fn by(self, manner: &Manner) -> Self {
        Self {
            queued: manner.queued,
            timeout: Duration::from_millis(manner.timeout_ms),
            ..self
        }
    }
}

/// How a write is answered.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WriteEnd {
    /// With true.
    True,
    /// With true; what waits will not end.
    Ends,
    /// With true; the arm jogs now.
    Jog,
    /// With the index of what was queued.
    Index,
    /// When it has ended; an alarm ends the wait, but for homing.
    Wait { homing: bool },
    /// With what the arm answered, by the results of the call.
    Raw(&'static crate::Method),
}

/// An arm that the program has connected.
#[derive(Debug, Default)]
pub(crate) struct ArmLink {
    /// As the program calls it.
    pub(crate) port_name: String,
    /// All its names.
    pub(crate) names: Vec<String>,
    pub(crate) is_virtual: bool,
    /// Whether its queue is to be started.
    pub(crate) starts: bool,
    /// The lease, as long as it has it.
    pub(crate) lease: Option<String>,
    pub(crate) waits: Waits,
    pub(crate) writes: VecDeque<Write>,
    pub(crate) writing: bool,
    pub(crate) blocked: Option<HostInstant>,
    /// True from the moment at which a jog is asked for to its end.
    pub(crate) jogs: bool,
    /// The station's jog, and when to keep it up next.
    pub(crate) jog: Option<(String, HostInstant)>,
    /// The last command that has finished, as far as is known.
    pub(crate) current: Option<u64>,
    /// Alarms that hold the queue.
    pub(crate) alarm: Option<u8>,
    /// One that came with the present reading.
    pub(crate) raised: Option<u8>,
    pub(crate) fast: Option<Fast>,
    /// Since when no call waits.
    pub(crate) idle: Option<HostInstant>,
}

/// A subscription for calls that wait.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Fast {
    Asked,
    Id(u64),
}
