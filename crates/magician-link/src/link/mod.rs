//! Connection of a program: a state machine between the program and the station.

mod arm;
mod watching;
mod writes;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use self::arm::Fast;
pub(crate) use self::arm::{ArmLink, Write, WriteEnd};
use self::watching::WATCHES_ON;
use self::writes::KEEP_INTERVAL;
use crate::answers::Then;
use crate::error::{ErrorCode, LinkError};
use crate::report::Noted;
use crate::rpc::{self, Request};

/// Most calls without an answer. Further ones are refused, so that memory is bounded.
const UNANSWERED: usize = 1000;
/// Time without a sign of life from the program after which its jog is stopped.
const SILENCE: Duration = Duration::from_secs(5);

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
    /// Message.
    pub text: String,
    /// Call of the program that caused it: `dobotlink.Magician.SetPTPCmd`.
    pub of: Option<String>,
}

/// Call of a program that has not been answered.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    /// Id for the answer.
    pub(crate) id: Option<Value>,
    /// Name, such as `Magician.SetPTPCmd`.
    pub(crate) method: String,
    /// Parameters that the call does not have.
    pub(crate) odd: Vec<String>,
}

impl Asked {
    /// Creates a call that is counted as unknown.
    fn unknown(id: Option<Value>) -> Self {
        Self {
            id,
            method: "unknown".to_owned(),
            odd: Vec::new(),
        }
    }
}

/// Connection of a program, as a session of a station.
///
/// Messages of the program go to [`receive`](Self::receive), those of the station to
/// [`hear`](Self::hear). Messages to send come from [`poll_station`](Self::poll_station) and
/// [`poll_program`](Self::poll_program). Time comes from the calls;
/// [`poll_timeout`](Self::poll_timeout) returns when [`handle_timeout`](Self::handle_timeout) is
/// due. When the program's socket closes, call [`end`](Self::end).
#[derive(Debug)]
pub struct Link {
    pub(crate) options: LinkOptions,
    /// Connected arms, by their names in the station.
    pub(crate) arms: BTreeMap<String, ArmLink>,
    pub(crate) under_way: BTreeMap<u64, Then>,
    subscriptions: BTreeMap<u64, String>,
    next: u64,
    pub(crate) session: Option<String>,
    heard: HostInstant,
    to_station: VecDeque<StationCall>,
    to_program: VecDeque<String>,
    noted: VecDeque<Noted>,
    unanswered: usize,
}

impl Link {
    /// Creates the connection of a program with this name or address.
    #[must_use]
    pub fn new(now: HostInstant, options: LinkOptions, name: &str) -> Self {
        let mut link = Self {
            options,
            arms: BTreeMap::new(),
            under_way: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
            next: 0,
            session: None,
            heard: now,
            to_station: VecDeque::new(),
            to_program: VecDeque::new(),
            noted: VecDeque::new(),
            unanswered: 0,
        };
        // Sent first, before any call of the program can follow.
        let hello = json!({"client": {"name": name}});
        link.call("session.hello", hello, Then::Hello);
        link
    }

    /// Processes a message of the program.
    pub fn receive(&mut self, now: HostInstant, text: &str) {
        self.heard = now;
        // DobotLink does not answer text other than JSON either.
        let Some(request) = Request::parse(text) else {
            return;
        };
        self.unanswered += 1;
        let request = match request {
            Ok(request) => request,
            Err((id, error)) => return self.answer(&Asked::unknown(id), &Err(error)),
        };
        if self.unanswered > UNANSWERED {
            let why = format!("more than {UNANSWERED} calls wait for their answers");
            let busy = LinkError::new(ErrorCode::BUSY, why);
            return self.answer(&Asked::unknown(request.id), &Err(busy));
        }
        self.take(now, request);
    }

    /// Records the reply to a ping, which is a sign of life.
    pub fn pong(&mut self, now: HostInstant) {
        self.heard = now;
    }

    /// Processes a message of the station.
    pub fn hear(&mut self, now: HostInstant, text: &str) {
        let Ok(Value::Object(message)) = serde_json::from_str(text) else {
            return;
        };
        if let Some(id) = message.get("id").and_then(Value::as_u64) {
            if let Some(then) = self.under_way.remove(&id) {
                let outcome = match (message.get("result"), message.get("error")) {
                    (Some(result), None) => Ok(result.clone()),
                    (_, Some(error)) => Err(LinkError::of_station(error)),
                    (None, None) => Ok(Value::Null),
                };
                self.carry_on(now, then, outcome);
            }
            return;
        }
        let params = message.get("params").unwrap_or(&Value::Null);
        match message.get("method").and_then(Value::as_str) {
            Some("arm.state") => self.state(now, params),
            Some("arm.event") => self.event(params),
            Some("lease.changed") => self.lease_changed(params),
            Some("jog.ended") => self.jog_ended(params),
            // Other notifications do not concern these programs.
            _ => {}
        }
    }

    /// Handles a jog that ended by itself: at a limit, with the lease, or by a stop.
    fn jog_ended(&mut self, params: &Value) {
        let text = |name: &str| params.get(name).and_then(Value::as_str);
        let arm = text("arm").and_then(|name| self.arms.get_mut(name));
        if let Some(arm) = arm
            && arm.jog.as_ref().map(|(jog, _)| jog.as_str()) == text("jog")
        {
            (arm.jogs, arm.jog) = (false, None);
        }
    }

    /// Handles everything that is due.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        let silent = self.heard + SILENCE <= now;
        let names: Vec<_> = self.arms.keys().cloned().collect();
        for name in names {
            let Some(arm) = self.arms.get_mut(&name) else {
                continue;
            };
            for wait in arm.waits.late(now) {
                let why = format!("command {} did not end in time", wait.index);
                self.wait_is_over(wait, Err(LinkError::new(ErrorCode::TIMEOUT, why)));
            }
            let Some(arm) = self.arms.get_mut(&name) else {
                continue;
            };
            if arm.jogs && silent {
                // The program hangs: everything that it started stops.
                (arm.jogs, arm.jog) = (false, None);
                self.call("arm.stop", json!({"arm": name}), Then::Nothing);
            } else if let Some((jog, due)) = &mut arm.jog
                && *due <= now
            {
                *due = now + KEEP_INTERVAL;
                let params = json!({"jog": jog});
                self.call("jog.keep", params, Then::Nothing);
            }
            self.calm_down(now, &name);
            self.pump(now, &name);
        }
    }

    /// Returns the instant at which [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let of_arm = |arm: &ArmLink| {
            let waiting = !(arm.writing || arm.writes.is_empty());
            let blocked = arm.blocked.filter(|_| waiting);
            let jog = arm.jogs.then(|| self.heard + SILENCE);
            let keep = arm.jog.as_ref().map(|(_, due)| *due);
            let watched = matches!(arm.fast, Some(Fast::Id(_)));
            let calm = arm.idle.filter(|_| watched).map(|idle| idle + WATCHES_ON);
            [arm.waits.due(), blocked, jog, keep, calm]
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
            self.leave(&name);
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
    pub fn poll_noted(&mut self) -> Option<Noted> {
        self.noted.pop_front()
    }

    /// Calls a method of the station.
    pub(crate) fn call(&mut self, method: &str, params: Value, then: Then) {
        self.next += 1;
        let of = then
            .asked()
            .map(|asked| format!("dobotlink.{}", asked.method));
        self.under_way.insert(self.next, then);
        let text = rpc::call(self.next, method, &params);
        self.to_station.push_back(StationCall { text, of });
    }

    /// Answers a call of the program.
    pub(crate) fn answer(&mut self, asked: &Asked, outcome: &Result<Value, LinkError>) {
        // Saturating, because calls of the link itself are answered too.
        self.unanswered = self.unanswered.saturating_sub(1);
        self.noted.push_back(Noted {
            method: asked.method.clone(),
            odd: asked.odd.clone(),
            error: outcome.as_ref().err().map(|error| error.code.0),
        });
        if let Some(id) = &asked.id {
            self.to_program.push_back(rpc::answer(id, outcome));
        }
    }

    /// Disconnects an arm.
    pub(crate) fn leave(&mut self, name: &str) {
        self.cancel(name, &LinkError::cancelled("the arm was disconnected"));
        let Some(arm) = self.arms.remove(name) else {
            return;
        };
        for write in arm.writes {
            let why = LinkError::cancelled("the arm was disconnected");
            self.answer(&write.asked, &Err(why));
        }
        if arm.jogs {
            self.call("jog.stop", json!({"arm": name}), Then::Nothing);
        }
        let ids: Vec<_> = { self.subscriptions.iter() }
            .filter(|(_, arm)| *arm == name)
            .map(|(id, _)| *id)
            .collect();
        for id in ids {
            self.unsubscribe(id);
        }
        if let Some(lease) = arm.lease {
            self.call("lease.release", json!({"lease": lease}), Then::Nothing);
        }
    }
}
