//! The end of a station: its clients are told first, and who holds an arm gets a bounded time to end
//! what it runs over it. What a client does not end the station ends, as for a holder that is gone.

use magician::message;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{SocketId, Station};
use crate::api::{Notice, RpcError};
use crate::control::{ArmId, SessionId};

/// Time in which a holder has to stop its arm. One that has not by then does not know the
/// notification, or hangs.
const REACTS: Duration = Duration::from_secs(1);
/// Time without a request after which a holder that has stopped its arm has no more to end.
const SILENT: Duration = Duration::from_secs(1);
/// Time for everything: the arm comes to rest, the pen goes up by at most 2 s, settings are restored.
const LONGEST: Duration = Duration::from_secs(5);

/// The end of a station, from its announcement on.
#[derive(Debug)]
pub(super) struct Ending {
    began: HostInstant,
    /// True once no more time is given.
    at_once: bool,
    /// Holders that have stopped their arm since, and when each of them was heard last.
    stopped: BTreeMap<SessionId, HostInstant>,
    /// Holders whose lease was ended, by arm.
    evicted: BTreeMap<ArmId, String>,
    /// Sessions whose lease was ended: the arm is the station's alone.
    put_out: BTreeSet<SessionId>,
    /// Arms that were moving then, and whose they were.
    cut_off: Vec<CutOff>,
}

/// An arm that the station had to stop itself as it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CutOff {
    /// Name of the arm.
    pub arm: String,
    /// Name of the client that held it, and did not stop it in time.
    pub holder: String,
}

/// Outcome of the end of a station.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RunsEnd {
    /// Arms that were stopped under a client.
    pub cut_off: Vec<CutOff>,
    /// Arms that did not confirm that they stand with an empty queue, with the cause.
    pub unconfirmed: Vec<(String, String)>,
}

impl Station {
    /// The station begins to end. Sessions are told by `server.ending`; jogs end; nothing new begins.
    /// Who holds an arm has a moment to stop it and then a few seconds to end its run well (pen up,
    /// settings restored), until it gives the lease back; then its lease ends, which stops the arm.
    /// Programs that cannot be told lose it at once. A second call gives nobody any more time.
    pub fn end(&mut self, now: HostInstant) {
        if let Some(ending) = &mut self.ending {
            ending.at_once = true;
            return self.settle(now);
        }
        self.ending = Some(Ending {
            began: now,
            at_once: false,
            stopped: BTreeMap::new(),
            evicted: BTreeMap::new(),
            put_out: BTreeSet::new(),
            cut_off: Vec::new(),
        });
        let sockets = self.sessions.values().filter_map(|session| session.socket);
        for socket in sockets.collect::<Vec<_>>() {
            self.tell_of_end(now, socket);
        }
        self.control.close();
        self.settle(now);
    }

    /// True if nobody is more than a viewer.
    pub(crate) fn is_read_only(&self) -> bool {
        self.config.read_only
    }

    /// Names of the arms, in their order.
    pub(crate) fn arm_names(&self) -> Vec<String> {
        let arms = self.arm_ids();
        arms.map(|arm| self.arm(arm).entry.name.clone()).collect()
    }

    /// True once it ends.
    pub(crate) fn is_ending(&self) -> bool {
        self.ending.is_some()
    }

    /// True once it ends and no session holds an arm any more.
    #[must_use]
    pub fn has_let_go(&self) -> bool {
        let mut arms = self.arm_ids();
        self.ending.is_some() && arms.all(|arm| self.control.holder(arm).is_none())
    }

    /// The arms that were stopped under clients which did not stop them in time.
    #[must_use]
    pub fn cut_off(&self) -> &[CutOff] {
        self.ending.as_ref().map_or(&[], |ending| &ending.cut_off)
    }

    /// Tells a session that the station ends, if it does.
    pub(super) fn tell_of_end(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(ending) = &self.ending {
            let left = (ending.began + LONGEST - now).as_secs_f64();
            let params = json!({"left_s": left});
            self.notify_socket(socket, Notice::ServerEnding.message(&params));
        }
    }

    /// Why nothing begins any more, if the station ends.
    pub(super) fn refuses_at_end(&self) -> Option<RpcError> {
        let why = RpcError::new(RpcError::STOPPED, message!("the station ends"));
        self.ending.as_ref().map(|_| why.with("by", Value::Null))
    }

    /// The same for the reads of a session whose lease was ended: it would take the queue that the
    /// station empties for a fault of its own.
    pub(super) fn refuses_put_out(&self, session: SessionId) -> Option<RpcError> {
        let ending = self.ending.as_ref()?;
        ending.put_out.get(&session)?;
        self.refuses_at_end()
    }

    /// A session asks for something, or was answered. `stops`: it has stopped its arm.
    pub(super) fn heard_at_end(&mut self, now: HostInstant, session: SessionId, stops: bool) {
        if let Some(ending) = &mut self.ending {
            match ending.stopped.get_mut(&session) {
                Some(heard) => *heard = now,
                None if stops => drop(ending.stopped.insert(session, now)),
                None => {}
            }
        }
    }

    /// When the next holder has had its time.
    pub(super) fn end_due(&self) -> Option<HostInstant> {
        let ending = self.ending.as_ref()?;
        let holders = self.arm_ids().filter_map(|arm| self.control.holder(arm));
        holders.map(|holder| self.time_of(ending, holder)).min()
    }

    /// Ends the leases of those who have had their time.
    pub(super) fn evict_overdue(&mut self, now: HostInstant) {
        for arm in self.arm_ids() {
            let Some(ending) = &self.ending else {
                return;
            };
            let Some(holder) = self.control.holder(arm) else {
                continue;
            };
            if self.time_of(ending, holder) > now {
                continue;
            }
            let lasting = self.sessions.get(&holder);
            let lasting = lasting.filter(|session| !session.one_shot);
            let name = lasting.map(|session| session.name.clone());
            if let Some(ending) = &mut self.ending {
                ending.put_out.insert(holder);
                if let Some(name) = name {
                    ending.evicted.insert(arm, name);
                }
            }
            self.control.evict(now, arm);
        }
    }

    /// The arm has to be stopped because its lease has ended.
    pub(super) fn note_cut_off(&mut self, arm: ArmId) {
        let name = self.arm(arm).entry.name.clone();
        if let Some(ending) = &mut self.ending
            && let Some(holder) = ending.evicted.remove(&arm)
        {
            ending.cut_off.push(CutOff { arm: name, holder });
        }
    }

    /// Until when a holder has time.
    fn time_of(&self, ending: &Ending, holder: SessionId) -> HostInstant {
        let session = self.sessions.get(&holder);
        let socket = session.and_then(|session| session.socket.filter(|_| !session.one_shot));
        // The protocol of a link has no word for it, and a request by POST hears nothing.
        let told = socket.filter(|socket| {
            let open = self.sockets.get(socket);
            open.is_some_and(|open| !open.link && !open.outbox.is_closing())
        });
        let Some(socket) = told.filter(|_| !ending.at_once) else {
            return ending.began;
        };
        let last = ending.began + LONGEST;
        match ending.stopped.get(&holder) {
            None => ending.began + REACTS,
            Some(_) if self.waits_for_answer(socket) => last,
            Some(heard) => last.min(*heard + SILENT),
        }
    }

    /// True if a request of a socket is not answered yet.
    fn waits_for_answer(&self, socket: SocketId) -> bool {
        let mut pending = self.pending.values();
        pending.any(|pending| pending.socket == socket)
    }
}
