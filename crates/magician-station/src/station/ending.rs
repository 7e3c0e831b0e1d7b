//! The end of a station.
//!
//! Clients are notified first. A holder then has a bounded time to end what it runs over its arm,
//! because the station cannot lift a pen that it does not know. After that the station ends the
//! lease, as for a holder that is gone, which stops the arm.

use magician::message;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{SocketId, Station};
use crate::api::{Notice, RpcError};
use crate::control::{ArmId, SessionId};

/// Time in which a holder has to stop its arm. A holder that has not by then hangs, or does not
/// know the notification.
const STOP_DEADLINE: Duration = Duration::from_secs(1);
/// Time without a request after which a holder that has stopped its arm is done.
const SILENCE_DEADLINE: Duration = Duration::from_secs(1);
/// Time for everything: the arm comes to rest, the pen rises (at most 2 s), settings are restored.
const MAX_END_TIME: Duration = Duration::from_secs(5);

/// State of the end, from its announcement on.
#[derive(Debug)]
pub(super) struct Ending {
    began: HostInstant,
    /// True once no more time is given.
    at_once: bool,
    /// Holders that have stopped their arm since the announcement, and the instant of their last
    /// message.
    stopped: BTreeMap<SessionId, HostInstant>,
    /// Names of holders whose lease was ended, by arm.
    evicted: BTreeMap<ArmId, String>,
    /// Sessions whose lease was ended.
    evicted_sessions: BTreeSet<SessionId>,
    /// Arms that were still moving then, with their holders.
    forced_stops: Vec<ForcedStop>,
}

/// Arm that the station had to stop under a client.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ForcedStop {
    /// Name of the arm.
    pub arm: String,
    /// Name of the client that held it and did not stop it in time.
    pub holder: String,
}

/// Result of the end of a station.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct EndReport {
    /// Arms that were stopped under a client.
    pub forced_stops: Vec<ForcedStop>,
    /// Arms that did not confirm that they stand with an empty queue, with the cause.
    pub unconfirmed: Vec<(String, String)>,
}

impl Station {
    /// Starts the end of the station.
    ///
    /// Sessions get the notification `server.ending`; jogs end; nothing new starts. A holder of an
    /// arm has a moment to stop it, and then a few seconds to end its run properly (pen up,
    /// settings restored) and give the lease back. Otherwise its lease ends, which stops the arm.
    /// Programs that cannot be notified lose the lease at once. A second call ends all waits.
    pub fn end(&mut self, now: HostInstant) {
        if let Some(ending) = &mut self.ending {
            ending.at_once = true;
            return self.carry_out_effects(now);
        }
        self.ending = Some(Ending {
            began: now,
            at_once: false,
            stopped: BTreeMap::new(),
            evicted: BTreeMap::new(),
            evicted_sessions: BTreeSet::new(),
            forced_stops: Vec::new(),
        });
        let sockets = self.sessions.values().filter_map(|session| session.socket);
        for socket in sockets.collect::<Vec<_>>() {
            // Before control closes, so that the notice precedes denials that result from it.
            self.notify_end(now, socket);
        }
        self.control.close();
        self.carry_out_effects(now);
    }

    /// True if every session is limited to the role of a viewer.
    pub(crate) fn is_read_only(&self) -> bool {
        self.config.read_only
    }

    /// Returns the names of the arms, by index.
    pub(crate) fn arm_names(&self) -> Vec<String> {
        let arms = self.arm_ids();
        arms.map(|arm| self.arm(arm).entry.name.clone()).collect()
    }

    /// True once the station ends.
    pub(crate) fn is_ending(&self) -> bool {
        self.ending.is_some()
    }

    /// True once the station ends and no session holds an arm.
    #[must_use]
    pub fn is_released(&self) -> bool {
        let mut arms = self.arm_ids();
        self.ending.is_some() && arms.all(|arm| self.control.holder(arm).is_none())
    }

    /// Returns the arms that were stopped under a client that did not stop them in time.
    #[must_use]
    pub fn forced_stops(&self) -> &[ForcedStop] {
        self.ending
            .as_ref()
            .map_or(&[], |ending| &ending.forced_stops)
    }

    /// Notifies a socket that the station ends, if it does.
    pub(super) fn notify_end(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(ending) = &self.ending {
            let left = (ending.began + MAX_END_TIME - now).as_secs_f64();
            let params = json!({"left_s": left});
            self.notify_socket(socket, Notice::ServerEnding.message(&params));
        }
    }

    /// Returns the error that refuses everything new while the station ends. `None` otherwise.
    pub(super) fn ending_error(&self) -> Option<RpcError> {
        let why = RpcError::new(RpcError::STOPPED, message!("the station ends"));
        self.ending.as_ref().map(|_| why.with("by", Value::Null))
    }

    /// Returns the same error for reads of a session whose lease was ended. Otherwise such a client
    /// would take the emptied queue for its own fault.
    pub(super) fn eviction_error(&self, session: SessionId) -> Option<RpcError> {
        let ending = self.ending.as_ref()?;
        ending.evicted_sessions.get(&session)?;
        self.ending_error()
    }

    /// Records a request or an answer of a session. `stops`: the session has stopped its arm.
    pub(super) fn note_message_at_end(
        &mut self,
        now: HostInstant,
        session: SessionId,
        stops: bool,
    ) {
        if let Some(ending) = &mut self.ending {
            match ending.stopped.get_mut(&session) {
                Some(heard) => *heard = now,
                None if stops => drop(ending.stopped.insert(session, now)),
                None => {}
            }
        }
    }

    /// Returns the instant at which the time of the next holder is over.
    pub(super) fn end_due(&self) -> Option<HostInstant> {
        let ending = self.ending.as_ref()?;
        let holders = self.arm_ids().filter_map(|arm| self.control.holder(arm));
        holders.map(|holder| self.deadline_of(ending, holder)).min()
    }

    /// Ends the leases of holders whose time is over.
    pub(super) fn evict_overdue(&mut self, now: HostInstant) {
        for arm in self.arm_ids() {
            let Some(ending) = &self.ending else {
                return;
            };
            let Some(holder) = self.control.holder(arm) else {
                continue;
            };
            if self.deadline_of(ending, holder) > now {
                continue;
            }
            let lasting = self.sessions.get(&holder);
            // A request by POST has no client that could be named.
            let lasting = lasting.filter(|session| !session.one_shot);
            let name = lasting.map(|session| session.name.clone());
            if let Some(ending) = &mut self.ending {
                ending.evicted_sessions.insert(holder);
                if let Some(name) = name {
                    // Before the eviction: `record_forced_stop` looks the holder up when the stop
                    // is ordered.
                    ending.evicted.insert(arm, name);
                }
            }
            self.control.evict(now, arm);
        }
    }

    /// Records that an arm had to be stopped because its lease was ended.
    pub(super) fn record_forced_stop(&mut self, arm: ArmId) {
        let name = self.arm(arm).entry.name.clone();
        if let Some(ending) = &mut self.ending
            && let Some(holder) = ending.evicted.remove(&arm)
        {
            ending.forced_stops.push(ForcedStop { arm: name, holder });
        }
    }

    /// Returns the instant until which a holder has time.
    fn deadline_of(&self, ending: &Ending, holder: SessionId) -> HostInstant {
        let session = self.sessions.get(&holder);
        let socket = session.and_then(|session| session.socket.filter(|_| !session.one_shot));
        // DobotLink has no message for it, and a request by POST receives no notifications.
        let told = socket.filter(|socket| {
            let open = self.sockets.get(socket);
            open.is_some_and(|open| !open.link && !open.outbox.is_closing())
        });
        let Some(socket) = told.filter(|_| !ending.at_once) else {
            return ending.began;
        };
        let last = ending.began + MAX_END_TIME;
        match ending.stopped.get(&holder) {
            None => ending.began + STOP_DEADLINE,
            // A request in flight, such as lifting the pen, may take all the time there is.
            Some(_) if self.waits_for_answer(socket) => last,
            // Never beyond the time for everything.
            Some(heard) => last.min(*heard + SILENCE_DEADLINE),
        }
    }

    /// True if a request of a socket is not answered yet.
    fn waits_for_answer(&self, socket: SocketId) -> bool {
        let mut pending = self.pending.values();
        pending.any(|pending| pending.socket == socket)
    }
}
