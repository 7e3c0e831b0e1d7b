//! State of an arm that a program has connected, and its queue of writes.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::Value;

use super::PendingCall;
use crate::params::CallOptions;
use crate::waits::Waits;

/// Write that waits for its turn at an arm.
#[derive(Debug)]
pub(crate) struct Write {
    pub(crate) pending: PendingCall,
    /// Method of the station.
    pub(crate) method: &'static str,
    pub(crate) params: Value,
    pub(crate) queued: bool,
    /// Timeout, applied twice: to waiting for room in the queue, and then to the command itself.
    pub(crate) timeout: Duration,
    /// Way in which it is answered.
    pub(crate) answer: WriteAnswer,
    /// Instant at which waiting for room in the queue is given up.
    pub(crate) give_up_at: Option<HostInstant>,
}

impl Write {
    /// Creates a write with immediate effect.
    pub(crate) fn new(
        pending: &PendingCall,
        method: &'static str,
        params: Value,
        answer: WriteAnswer,
    ) -> Self {
        Self {
            pending: pending.clone(),
            method,
            params,
            queued: false,
            timeout: Duration::ZERO,
            answer,
            give_up_at: None,
        }
    }

    /// Applies the options of a call: queue and timeout.
    pub(crate) fn with_options(self, options: &CallOptions) -> Self {
        Self {
            queued: options.queued,
            timeout: Duration::from_millis(options.timeout_ms),
            ..self
        }
    }
}

/// Answer to the program once the station has answered a write, and what follows from it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WriteAnswer {
    /// True.
    True,
    /// True, and the calls that wait are cancelled.
    StopQueue,
    /// True; the arm jogs from now on.
    Jog,
    /// Index of the queued command.
    Index,
    /// True when the command has finished. An alarm ends the wait, except for homing.
    Wait { homing: bool },
    /// Reply of the arm, decoded by the result fields of the method.
    Raw(&'static crate::Method),
}

/// Arm that the program has connected.
#[derive(Debug, Default)]
pub(crate) struct ArmLink {
    /// Port, as the program names it.
    pub(crate) port_name: String,
    /// All names by which the program may address the arm.
    pub(crate) names: Vec<String>,
    pub(crate) is_virtual: bool,
    /// True if the link starts the queue of the arm whenever it acquires the lease.
    pub(crate) starts_queue: bool,
    /// Lease. `None` while the session does not hold it.
    pub(crate) lease: Option<String>,
    pub(crate) waits: Waits,
    pub(crate) writes: VecDeque<Write>,
    pub(crate) is_writing: bool,
    pub(crate) blocked_until: Option<HostInstant>,
    /// True from the request for a jog to its end.
    pub(crate) is_jogging: bool,
    /// Id of the jog at the station, and the instant of its next keep-alive.
    pub(crate) jog: Option<(String, HostInstant)>,
    /// Index of the last finished command, if known.
    pub(crate) current: Option<u64>,
    /// Alarm that holds the queue.
    pub(crate) alarm: Option<u8>,
    /// Alarm that first appeared in the current reading.
    pub(crate) raised: Option<u8>,
    pub(crate) fast: Option<FastSubscription>,
    /// Instant since which no call waits.
    pub(crate) idle_since: Option<HostInstant>,
}

/// Fast subscription, used while calls wait.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum FastSubscription {
    Requested,
    Id(u64),
}
