//! A connection of a program, without I/O and clock.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::{Alarm, HostInstant};
use serde_json::{Value, json};

use crate::answers::Then;
use crate::error::{ErrorCode, LinkError};
use crate::report::Noted;
use crate::rpc::{self, Request};
use crate::waits::{Wait, Waits};

/// Calls that are not answered yet: more are refused.
const UNANSWERED: usize = 1000;
/// A queue that is full is tried again after so long.
const FULL: Duration = Duration::from_millis(20);
/// A jog ends when its program has given no sign of life for so long.
const SILENCE: Duration = Duration::from_secs(5);
/// The arm is read often for so long after the last call that waited.
const WATCHES_ON: Duration = Duration::from_secs(2);
/// Readings a second while calls wait: they end within 50 ms.
const FAST: u32 = 50;
/// Readings a second otherwise: for what happens meanwhile.
const SLOW: u32 = 2;

/// What a link allows, and how it answers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinkOptions {
    /// Whether parameters that a call does not have are refused.
    pub strict: bool,
    /// Whether dangerous calls are made.
    pub dangerous: bool,
    /// Whether the laser of a real arm may burn.
    pub laser: bool,
    /// Whether connecting answers empty texts, as DobotLink does.
    pub empty_connect: bool,
    /// Version of the program that serves.
    pub version: String,
}

/// A call of the station's API.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationCall {
    /// The message.
    pub text: String,
    /// The program's call for which it is made: `dobotlink.Magician.SetPTPCmd`.
    pub of: Option<String>,
}

/// A call of a program, until it is answered.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    /// Under which it is answered.
    pub(crate) id: Option<Value>,
    /// `Magician.SetPTPCmd`.
    pub(crate) method: String,
    /// Parameters that the call does not have.
    pub(crate) odd: Vec<String>,
}

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

/// How a write is answered.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WriteEnd {
    /// With true.
    True,
    /// With true; what waits will not end.
    Ends,
    /// With true; the arm jogs now, or no longer.
    Jog(bool),
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
    pub(crate) jogs: bool,
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

/// One connection of a program to DobotLink, as sessions of a station.
///
/// What the program sends goes to [`receive`](Self::receive), what the station says to [`hear`](Self::hear);
/// [`poll_station`](Self::poll_station) and [`poll_program`](Self::poll_program) tell what is to be sent. Time is what the calls say;
/// [`poll_timeout`](Self::poll_timeout) tells when [`handle_timeout`](Self::handle_timeout) is due. At the end of the program's
/// socket, [`end`](Self::end).
#[derive(Debug)]
pub struct Link {
    pub(crate) options: LinkOptions,
    /// Arms by their names in the station.
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
    /// A connection that has just been made, by a program of this name or address.
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
        let hello = json!({"client": {"name": name}});
        link.call("session.hello", hello, Then::Hello);
        link
    }

    /// A message of the program.
    pub fn receive(&mut self, now: HostInstant, text: &str) {
        self.heard = now;
        let request = match Request::parse(text) {
            // As DobotLink does.
            None => return,
            Some(Ok(request)) => request,
            Some(Err((id, error))) => {
                let asked = Asked {
                    id,
                    method: "unknown".to_owned(),
                    odd: Vec::new(),
                };
                self.unanswered += 1;
                return self.answer(&asked, &Err(error));
            }
        };
        self.unanswered += 1;
        if self.unanswered > UNANSWERED {
            let asked = Asked {
                id: request.id,
                method: "unknown".to_owned(),
                odd: Vec::new(),
            };
            let why = format!("more than {UNANSWERED} calls wait for their answers");
            return self.answer(&asked, &Err(LinkError::new(ErrorCode::BUSY, why)));
        }
        self.take(now, request);
    }

    /// The program answered a ping: a sign of life.
    pub fn pong(&mut self, now: HostInstant) {
        self.heard = now;
    }

    /// A message of the station.
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
            _ => {}
        }
    }

    /// What is due by now.
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
                // The program hangs: nothing of it goes on.
                arm.jogs = false;
                self.call("arm.stop", json!({"arm": name}), Then::Nothing);
            }
            self.calm_down(now, &name);
            self.pump(now, &name);
        }
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let of_arm = |arm: &ArmLink| {
            let blocked = arm.blocked.filter(|_| !arm.writes.is_empty());
            let jog = arm.jogs.then(|| self.heard + SILENCE);
            let calm = arm.idle.map(|idle| idle + WATCHES_ON);
            [arm.waits.due(), blocked, jog, calm]
                .into_iter()
                .flatten()
                .min()
        };
        self.arms.values().filter_map(of_arm).min()
    }

    /// The program's socket has ended: its jogs stop, and its leases are given back. What it queued goes on, as after DobotLink's end.
    pub fn end(&mut self) {
        let names: Vec<_> = self.arms.keys().cloned().collect();
        for name in names {
            self.leave(&name);
        }
    }

    /// What is to be sent to the station.
    pub fn poll_station(&mut self) -> Option<StationCall> {
        self.to_station.pop_front()
    }

    /// What is to be sent to the program.
    pub fn poll_program(&mut self) -> Option<String> {
        self.to_program.pop_front()
    }

    /// A call that was answered, for the report.
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

    /// Answers a call.
    pub(crate) fn answer(&mut self, asked: &Asked, outcome: &Result<Value, LinkError>) {
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

    /// Writes to an arm when what came before was taken.
    pub(crate) fn write(&mut self, now: HostInstant, name: &str, write: Write) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.writes.push_back(write);
        }
        self.pump(now, name);
    }

    /// Writes the next, if nothing is under way. While the queue is full, what needs no place in it goes before.
    pub(crate) fn pump(&mut self, now: HostInstant, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if arm.writing {
            return;
        }
        let blocked = arm.blocked.is_some_and(|until| now < until);
        let at = if blocked {
            arm.writes.iter().position(|write| !write.queued)
        } else {
            arm.blocked = None;
            Some(0)
        };
        let Some(write) = at.and_then(|at| arm.writes.remove(at)) else {
            return;
        };
        arm.writing = true;
        let (starts, held) = (arm.starts, arm.lease.is_some());
        if !held {
            self.acquire(name);
            if starts {
                self.start(name);
            }
        }
        let (method, params) = (write.method, write.params.clone());
        let arm = name.to_owned();
        self.call(method, params, Then::Written { arm, write });
    }

    /// Starts a queue in which nothing waits: programs were written on arms whose queue somebody had started.
    pub(crate) fn start(&mut self, name: &str) {
        self.call("link.start", json!({"arm": name}), Then::Nothing);
    }

    /// Asks for the lease, if it is free.
    pub(crate) fn acquire(&mut self, name: &str) {
        let then = Then::Lease(name.to_owned());
        self.call("lease.acquire", json!({"arm": name}), then);
    }

    /// What came of a write.
    pub(crate) fn written(
        &mut self,
        now: HostInstant,
        name: &str,
        mut write: Write,
        outcome: Result<Value, LinkError>,
    ) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.writing = false;
            let full =
                { outcome.as_ref().err() }.is_some_and(|error| error.code == ErrorCode::QUEUE_FULL);
            if full && write.queued {
                let give_up = *write.give_up.get_or_insert(now + write.timeout);
                if now < give_up {
                    arm.blocked = Some(now + FULL);
                    arm.writes.push_front(write);
                    return self.pump(now, name);
                }
            }
        }
        self.end_write(now, name, write, outcome);
        self.pump(now, name);
    }

    fn end_write(
        &mut self,
        now: HostInstant,
        name: &str,
        write: Write,
        outcome: Result<Value, LinkError>,
    ) {
        let value = match outcome {
            Ok(value) => value,
            Err(error) => return self.answer(&write.asked, &Err(error)),
        };
        let index = value.get("index").and_then(Value::as_u64);
        match (write.end, index) {
            (WriteEnd::Wait { homing }, Some(index)) => {
                let wait = Wait {
                    id: write.asked.id,
                    method: write.asked.method,
                    odd: write.asked.odd,
                    index,
                    timeout: write.timeout,
                    homing,
                    due: None,
                };
                self.wait(now, name, wait);
            }
            (WriteEnd::Index, Some(index)) => {
                self.answer(&write.asked, &Ok(json!({"queuedCmdIndex": index})));
            }
            (WriteEnd::Ends, _) => {
                self.cancel(name, &LinkError::cancelled("the queue was stopped"));
                self.answer(&write.asked, &Ok(json!(true)));
            }
            (WriteEnd::Jog(on), _) => {
                if let Some(arm) = self.arms.get_mut(name) {
                    arm.jogs = on;
                }
                let result = index.map_or(json!(true), |index| json!({"queuedCmdIndex": index}));
                self.answer(&write.asked, &Ok(result));
            }
            (WriteEnd::Raw(method), _) => {
                let result = crate::answers::raw(method, &value);
                self.answer(&write.asked, &Ok(result));
            }
            _ => self.answer(&write.asked, &Ok(json!(true))),
        }
    }

    /// A call waits until what it queued has ended.
    fn wait(&mut self, now: HostInstant, name: &str, wait: Wait) {
        let Some(arm) = self.arms.get_mut(name) else {
            let why = LinkError::cancelled("the arm was disconnected");
            return self.wait_is_over(wait, Err(why));
        };
        arm.idle = None;
        arm.waits.push(wait);
        if arm.fast.is_none() {
            arm.fast = Some(Fast::Asked);
            self.subscribe(name, FAST);
        }
        self.finished(now, name, None);
    }

    /// The arm has finished what it was at, up to this index.
    fn finished(&mut self, now: HostInstant, name: &str, index: Option<u64>) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        arm.current = index.max(arm.current);
        let Some(current) = arm.current else {
            return;
        };
        let raised = arm.raised;
        for wait in arm.waits.finished(now, current) {
            let outcome = match raised {
                Some(code) if wait.index == current && !wait.homing => Err(held_by(code)),
                _ => Ok(()),
            };
            self.wait_is_over(wait, outcome);
        }
        self.heed_alarm(name);
        self.rest(now, name);
    }

    /// An alarm holds the queue: calls would wait for ever.
    fn heed_alarm(&mut self, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        let Some(code) = arm.alarm else {
            return;
        };
        for wait in arm.waits.held() {
            self.wait_is_over(wait, Err(held_by(code)));
        }
    }

    fn rest(&mut self, now: HostInstant, name: &str) {
        if let Some(arm) = self.arms.get_mut(name)
            && arm.waits.is_empty()
            && arm.fast.is_some()
        {
            arm.idle.get_or_insert(now);
        }
    }

    /// No call has waited for a while: the arm is read seldom again.
    fn calm_down(&mut self, now: HostInstant, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if arm.idle.is_some_and(|idle| idle + WATCHES_ON <= now)
            && let Some(Fast::Id(id)) = arm.fast
        {
            (arm.fast, arm.idle) = (None, None);
            self.unsubscribe(id);
        }
    }

    pub(crate) fn subscribe(&mut self, name: &str, rate: u32) {
        let params = json!({"arm": name, "rate": rate});
        let fast = rate == FAST;
        let arm = name.to_owned();
        self.call("arm.subscribe", params, Then::Subscribed { arm, fast });
    }

    pub(crate) fn watch(&mut self, name: &str) {
        self.subscribe(name, SLOW);
    }

    fn unsubscribe(&mut self, id: u64) {
        self.subscriptions.remove(&id);
        let params = json!({"subscription": id});
        self.call("arm.unsubscribe", params, Then::Nothing);
    }

    pub(crate) fn subscribed(&mut self, name: &str, fast: bool, id: u64) {
        let Some(arm) = self.arms.get_mut(name) else {
            return self.unsubscribe(id);
        };
        if fast {
            arm.fast = Some(Fast::Id(id));
        }
        self.subscriptions.insert(id, name.to_owned());
    }

    pub(crate) fn wait_is_over(&mut self, wait: Wait, outcome: Result<(), LinkError>) {
        let asked = Asked {
            id: wait.id,
            method: wait.method,
            odd: wait.odd,
        };
        self.answer(&asked, &outcome.map(|()| json!(true)));
    }

    /// What waits at an arm, and what was to be queued, will not be done.
    pub(crate) fn cancel(&mut self, name: &str, why: &LinkError) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        let waits = arm.waits.cancel();
        let (queued, kept) = std::mem::take(&mut arm.writes)
            .into_iter()
            .partition(|write| write.queued);
        arm.writes = kept;
        let queued: VecDeque<Write> = queued;
        for wait in waits {
            self.wait_is_over(wait, Err(why.clone()));
        }
        for write in queued {
            self.answer(&write.asked, &Err(why.clone()));
        }
    }

    /// Gives an arm back.
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
            let stop =
                json!({"arm": name, "command": "JOGCmd", "fields": {"is_joint": 0, "cmd": 0}});
            self.call("arm.set", stop, Then::Nothing);
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

    /// A state, or what of it has changed.
    fn state(&mut self, now: HostInstant, params: &Value) {
        let id = params.get("subscription").and_then(Value::as_u64);
        let Some(name) = id.and_then(|id| self.subscriptions.get(&id)).cloned() else {
            return;
        };
        let state = params.get("state").unwrap_or(&Value::Null);
        if let Some(alarms) = state.get("alarms").and_then(Value::as_array)
            && let Some(arm) = self.arms.get_mut(&name)
        {
            let codes = alarms.iter().filter_map(Value::as_u64);
            let mut codes = codes.filter_map(|code| u8::try_from(code).ok());
            let alarm = codes.find(|code| Alarm::blocks(*code));
            arm.raised = alarm.filter(|_| arm.alarm.is_none());
            arm.alarm = alarm;
        }
        // The same reading has index and alarms: what was finished last may have been refused.
        let index = state.get("current_index").and_then(Value::as_u64);
        self.finished(now, &name, index);
        if let Some(arm) = self.arms.get_mut(&name) {
            arm.raised = None;
        }
    }

    /// Something happened at an arm.
    fn event(&mut self, params: &Value) {
        let text = |name: &str| params.get(name).and_then(Value::as_str).unwrap_or_default();
        let name = text("arm").to_owned();
        match text("event") {
            "stop" => {
                if let Some(arm) = self.arms.get_mut(&name) {
                    arm.jogs = false;
                }
                self.cancel(&name, &LinkError::cancelled("the arm was stopped"));
            }
            "reset" => {
                if let Some(arm) = self.arms.get_mut(&name) {
                    arm.current = None;
                }
                self.cancel(&name, &LinkError::cancelled("the arm was switched off"));
            }
            "link-lost" => {
                let why = LinkError::new(ErrorCode::LINE_LOST, "the line to the arm is lost");
                self.cancel(&name, &why);
                if let Some(arm) = self.arms.get(&name) {
                    let told = json!({"portName": arm.port_name});
                    let told = rpc::notification("lostConnection", &told);
                    self.to_program.push_back(told);
                }
            }
            _ => {}
        }
    }

    /// Another session may have the arm now.
    fn lease_changed(&mut self, params: &Value) {
        let name = params
            .get("arm")
            .and_then(Value::as_str)
            .unwrap_or_default();
        let holder = params
            .get("holder")
            .and_then(|holder| holder.get("session"));
        let holder = holder.and_then(Value::as_str);
        let own = holder.is_some() && holder == self.session.as_deref();
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if !own && arm.lease.take().is_some() {
            arm.jogs = false;
            let why = "another session took the arm, or its lease ended";
            self.cancel(name, &LinkError::cancelled(why));
        }
    }
}

fn held_by(code: u8) -> LinkError {
    LinkError::cancelled(match Alarm::with_code(code) {
        Some(alarm) => format!("an alarm holds the queue: {}", alarm.name),
        None => format!("an alarm holds the queue: 0x{code:02X}"),
    })
}
