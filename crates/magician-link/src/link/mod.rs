//! Connection of a program: a state machine between the program and the station.

mod arm;
mod watching;
mod writes;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use self::arm::FastSubscription;
pub(crate) use self::arm::{ArmLink, Write, WriteAnswer};
use self::watching::FAST_LINGER;
use self::writes::JOG_KEEP_INTERVAL;
use crate::answers::Continuation;
use crate::error::{ErrorCode, LinkError};
use crate::report::AnsweredCall;
use crate::rpc::{self, Request};

/// Most calls without an answer. Further ones are refused, so that memory is bounded.
const MAX_UNANSWERED: usize = 1000;
/// Time without a sign of life from the program after which its jog is stopped.
const PROGRAM_TIMEOUT: Duration = Duration::from_secs(5);

/// Permissions and behaviour of a link.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinkOptions {
    /// True to refuse parameters that a call does not have. Otherwise they are counted.
    pub strict: bool,
    /// True to permit dangerous calls.
    pub dangerous: bool,
    /// True to permit burning with the laser of a real arm.
    pub laser: bool,
    /// True to answer `ConnectDobot` with empty texts, as DobotLink does.
    pub empty_connect: bool,
    /// Version of the serving program.
    pub version: String,
}

/// Call of the station's API.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationCall {
    /// JSON-RPC message.
    pub text: String,
    /// Call of the program that caused it: `dobotlink.Magician.SetPTPCmd`.
    pub origin: Option<String>,
}

/// Call of a program that has not been answered.
#[derive(Clone, Debug)]
pub(crate) struct PendingCall {
    /// Id for the answer.
    pub(crate) id: Option<Value>,
    /// Name, such as `Magician.SetPTPCmd`.
    pub(crate) method: String,
    /// Parameters that the call does not have.
    pub(crate) unknown_params: Vec<String>,
}

impl PendingCall {
    /// Creates a call that is counted as unknown.
    fn unknown(id: Option<Value>) -> Self {
        Self {
            id,
            method: "unknown".to_owned(),
            unknown_params: Vec::new(),
        }
    }
}

/// Connection of a program, as a session of a station.
///
/// Messages of the program go to [`receive`](Self::receive), those of the station to
/// [`receive_from_station`](Self::receive_from_station). Messages to send come from
/// [`poll_station`](Self::poll_station) and [`poll_program`](Self::poll_program). The link has no
/// clock: the caller passes the time. [`poll_timeout`](Self::poll_timeout) returns when
/// [`handle_timeout`](Self::handle_timeout) is due. When the program's socket closes, call
/// [`end`](Self::end).
#[derive(Debug)]
pub struct Link {
    pub(crate) options: LinkOptions,
    /// Connected arms, by their names in the station.
    pub(crate) arms: BTreeMap<String, ArmLink>,
    pub(crate) pending_calls: BTreeMap<u64, Continuation>,
    subscriptions: BTreeMap<u64, String>,
    last_id: u64,
    pub(crate) session: Option<String>,
    last_received: HostInstant,
    to_station: VecDeque<StationCall>,
    to_program: VecDeque<String>,
    answered: VecDeque<AnsweredCall>,
    unanswered: usize,
}

impl Link {
    /// Creates the connection of a program with this name or address.
    #[must_use]
    pub fn new(now: HostInstant, options: LinkOptions, name: &str) -> Self {
        let mut link = Self {
            options,
            arms: BTreeMap::new(),
            pending_calls: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
            last_id: 0,
            session: None,
            last_received: now,
            to_station: VecDeque::new(),
            to_program: VecDeque::new(),
            answered: VecDeque::new(),
            unanswered: 0,
        };
        // Sent first, before any call of the program can follow.
        let hello = json!({"client": {"name": name}});
        link.call("session.hello", hello, Continuation::Hello);
        link
    }

    /// Processes a message of the program.
    pub fn receive(&mut self, now: HostInstant, text: &str) {
        self.last_received = now;
        // DobotLink does not answer text other than JSON either.
        let Some(request) = Request::parse(text) else {
            return;
        };
        self.unanswered += 1;
        let request = match request {
            Ok(request) => request,
            Err((id, error)) => return self.answer(&PendingCall::unknown(id), &Err(error)),
        };
        if self.unanswered > MAX_UNANSWERED {
            let why = format!("more than {MAX_UNANSWERED} calls wait for their answers");
            let busy = LinkError::new(ErrorCode::BUSY, why);
            return self.answer(&PendingCall::unknown(request.id), &Err(busy));
        }
        self.handle_request(now, request);
    }

    /// Records the reply to a ping, which is a sign of life.
    pub fn pong(&mut self, now: HostInstant) {
        self.last_received = now;
    }

    /// Processes a message of the station.
    pub fn receive_from_station(&mut self, now: HostInstant, text: &str) {
        let Ok(Value::Object(message)) = serde_json::from_str(text) else {
            return;
        };
        if let Some(id) = message.get("id").and_then(Value::as_u64) {
            if let Some(continuation) = self.pending_calls.remove(&id) {
                let outcome = match (message.get("result"), message.get("error")) {
                    (Some(result), None) => Ok(result.clone()),
                    (_, Some(error)) => Err(LinkError::of_station(error)),
                    (None, None) => Ok(Value::Null),
                };
                self.resume_call(now, continuation, outcome);
            }
            return;
        }
        let params = message.get("params").unwrap_or(&Value::Null);
        match message.get("method").and_then(Value::as_str) {
            Some("arm.state") => self.handle_state(now, params),
            Some("arm.event") => self.handle_event(params),
            Some("lease.changed") => self.handle_lease_change(params),
            Some("jog.ended") => self.handle_jog_end(params),
            // Other notifications do not concern these programs.
            _ => {}
        }
    }

    /// Handles a jog that ended by itself: at a limit, with the lease, or by a stop.
    fn handle_jog_end(&mut self, params: &Value) {
        let text = |name: &str| params.get(name).and_then(Value::as_str);
        let arm = text("arm").and_then(|name| self.arms.get_mut(name));
        if let Some(arm) = arm
            && arm.jog.as_ref().map(|(jog, _)| jog.as_str()) == text("jog")
        {
            (arm.is_jogging, arm.jog) = (false, None);
        }
    }

    /// Handles everything that is due.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        let is_silent = self.last_received + PROGRAM_TIMEOUT <= now;
        let names: Vec<_> = self.arms.keys().cloned().collect();
        for name in names {
            let Some(arm) = self.arms.get_mut(&name) else {
                continue;
            };
            for wait in arm.waits.take_expired(now) {
                let why = format!("command {} did not end in time", wait.index);
                self.complete_wait(wait, Err(LinkError::new(ErrorCode::TIMEOUT, why)));
            }
            let Some(arm) = self.arms.get_mut(&name) else {
                continue;
            };
            if arm.is_jogging && is_silent {
                // The program hangs: everything that it started stops.
                (arm.is_jogging, arm.jog) = (false, None);
                self.call("arm.stop", json!({"arm": name}), Continuation::Nothing);
            } else if let Some((jog, due)) = &mut arm.jog
                && *due <= now
            {
                *due = now + JOG_KEEP_INTERVAL;
                let params = json!({"jog": jog});
                self.call("jog.keep", params, Continuation::Nothing);
            }
            self.end_fast_subscription(now, &name);
            self.send_next_write(now, &name);
        }
    }

    /// Returns the instant at which [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let of_arm = |arm: &ArmLink| {
            let waiting = !(arm.is_writing || arm.writes.is_empty());
            let blocked = arm.blocked_until.filter(|_| waiting);
            let jog = arm.is_jogging.then(|| self.last_received + PROGRAM_TIMEOUT);
            let keep = arm.jog.as_ref().map(|(_, due)| *due);
            let watched = matches!(arm.fast, Some(FastSubscription::Id(_)));
            let fast_end = arm
                .idle_since
                .filter(|_| watched)
                .map(|idle| idle + FAST_LINGER);
            [arm.waits.next_deadline(), blocked, jog, keep, fast_end]
                .into_iter()
                .flatten()
                .min()
        };
        self.arms.values().filter_map(of_arm).min()
    }

    /// Handles the end of the program's socket: jogs stop and leases are given back. Queued
    /// commands continue, as they do when DobotLink ends.
    pub fn end(&mut self) {
        let names: Vec<_> = self.arms.keys().cloned().collect();
        for name in names {
            self.disconnect_arm(&name);
        }
    }

    /// Returns the next call of the station's API.
    pub fn poll_station(&mut self) -> Option<StationCall> {
        self.to_station.pop_front()
    }

    /// Returns the next message to the program.
    pub fn poll_program(&mut self) -> Option<String> {
        self.to_program.pop_front()
    }

    /// Returns the next answered call, for the report.
    pub fn poll_answered(&mut self) -> Option<AnsweredCall> {
        self.answered.pop_front()
    }

    /// Calls a method of the station.
    pub(crate) fn call(&mut self, method: &str, params: Value, continuation: Continuation) {
        self.last_id += 1;
        let origin = continuation
            .pending()
            .map(|pending| format!("dobotlink.{}", pending.method));
        self.pending_calls.insert(self.last_id, continuation);
        let text = rpc::call(self.last_id, method, &params);
        self.to_station.push_back(StationCall { text, origin });
    }

    /// Answers a call of the program.
    pub(crate) fn answer(&mut self, pending: &PendingCall, outcome: &Result<Value, LinkError>) {
        // Saturating, because after an underflow all further calls would be refused as too many.
        self.unanswered = self.unanswered.saturating_sub(1);
        self.answered.push_back(AnsweredCall {
            method: pending.method.clone(),
            unknown_params: pending.unknown_params.clone(),
            error: outcome.as_ref().err().map(|error| error.code.0),
        });
        if let Some(id) = &pending.id {
            self.to_program.push_back(rpc::answer(id, outcome));
        }
    }

    /// Disconnects an arm.
    pub(crate) fn disconnect_arm(&mut self, name: &str) {
        self.cancel(name, &LinkError::cancelled("the arm was disconnected"));
        let Some(arm) = self.arms.remove(name) else {
            return;
        };
        for write in arm.writes {
            let why = LinkError::cancelled("the arm was disconnected");
            self.answer(&write.pending, &Err(why));
        }
        if arm.is_jogging {
            self.call("jog.stop", json!({"arm": name}), Continuation::Nothing);
        }
        let ids: Vec<_> = { self.subscriptions.iter() }
            .filter(|(_, arm)| *arm == name)
            .map(|(id, _)| *id)
            .collect();
        for id in ids {
            self.unsubscribe(id);
        }
        if let Some(lease) = arm.lease {
            self.call(
                "lease.release",
                json!({"lease": lease}),
                Continuation::Nothing,
            );
        }
    }
}
