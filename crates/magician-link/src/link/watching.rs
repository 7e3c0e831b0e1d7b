//! Waiting calls, and the states and events of the station that end them.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::{Alarm, HostInstant};
use serde_json::{Value, json};

use super::arm::FastSubscription;
use super::{Link, PendingCall, Write};
use crate::answers::Continuation;
use crate::error::{ErrorCode, LinkError};
use crate::rpc;
use crate::waits::Wait;

/// Time for which the fast subscription is kept after the last wait has ended.
pub(super) const FAST_LINGER: Duration = Duration::from_secs(2);
/// Readings per second while calls wait, so that they are answered within 50 ms.
const FAST_RATE: u32 = 50;
/// Readings per second otherwise, to notice alarms and a lost line.
const SLOW_RATE: u32 = 2;

impl Link {
    /// Adds a call that waits until its command has finished.
    pub(super) fn wait(&mut self, now: HostInstant, name: &str, wait: Wait) {
        let Some(arm) = self.arms.get_mut(name) else {
            let why = LinkError::cancelled("the arm was disconnected");
            return self.complete_wait(wait, Err(why));
        };
        arm.idle_since = None;
        arm.waits.push(wait);
        if arm.fast.is_none() {
            arm.fast = Some(FastSubscription::Requested);
            self.subscribe(name, FAST_RATE);
        }
        // The command may have finished before this call.
        self.finished(now, name, None);
    }

    /// Records that the arm has finished commands up to this index.
    fn finished(&mut self, now: HostInstant, name: &str, index: Option<u64>) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        // The index never decreases, because an older reading may arrive late.
        arm.current = index.max(arm.current);
        let Some(current) = arm.current else {
            return;
        };
        let raised = arm.raised;
        for wait in arm.waits.finished(now, current) {
            let outcome = match raised {
                // An alarm of the same reading belongs to the command that was finished last.
                Some(code) if wait.index == current && !wait.homing => Err(alarm_error(code)),
                _ => Ok(()),
            };
            self.complete_wait(wait, outcome);
        }
        self.fail_held_waits(name);
        self.note_idle(now, name);
    }

    /// Ends the calls that an alarm holds: they would wait for ever.
    fn fail_held_waits(&mut self, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        let Some(code) = arm.alarm else {
            return;
        };
        for wait in arm.waits.take_held_by_alarm() {
            self.complete_wait(wait, Err(alarm_error(code)));
        }
    }

    fn note_idle(&mut self, now: HostInstant, name: &str) {
        if let Some(arm) = self.arms.get_mut(name)
            && arm.waits.is_empty()
            && arm.fast.is_some()
        {
            // The fast subscription stays for a while, because programs often send the next call at
            // once.
            arm.idle_since.get_or_insert(now);
        }
    }

    /// Ends the fast subscription when no call has waited for a while.
    pub(super) fn end_fast_subscription(&mut self, now: HostInstant, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if arm.idle_since.is_some_and(|idle| idle + FAST_LINGER <= now)
            && let Some(FastSubscription::Id(id)) = arm.fast
        {
            (arm.fast, arm.idle_since) = (None, None);
            self.unsubscribe(id);
        }
    }

    pub(crate) fn subscribe(&mut self, name: &str, rate: u32) {
        let params = json!({"arm": name, "rate": rate});
        let fast = rate == FAST_RATE;
        let arm = name.to_owned();
        self.call(
            "arm.subscribe",
            params,
            Continuation::Subscribed { arm, fast },
        );
    }

    pub(crate) fn subscribe_slow(&mut self, name: &str) {
        self.subscribe(name, SLOW_RATE);
    }

    pub(super) fn unsubscribe(&mut self, id: u64) {
        self.subscriptions.remove(&id);
        let params = json!({"subscription": id});
        self.call("arm.unsubscribe", params, Continuation::Nothing);
    }

    pub(crate) fn subscribed(&mut self, name: &str, fast: bool, id: u64) {
        let Some(arm) = self.arms.get_mut(name) else {
            // Disconnected before the answer came.
            return self.unsubscribe(id);
        };
        if fast {
            arm.fast = Some(FastSubscription::Id(id));
        }
        self.subscriptions.insert(id, name.to_owned());
    }

    pub(crate) fn complete_wait(&mut self, wait: Wait, outcome: Result<(), LinkError>) {
        let pending = PendingCall {
            id: wait.id,
            method: wait.method,
            unknown_params: wait.unknown_params,
        };
        self.answer(&pending, &outcome.map(|()| json!(true)));
    }

    /// Cancels the waiting calls of an arm and its queued writes, because their commands will not
    /// be executed.
    pub(crate) fn cancel(&mut self, name: &str, why: &LinkError) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        let waits = arm.waits.cancel();
        let (queued, kept) = std::mem::take(&mut arm.writes)
            .into_iter()
            // Writes with immediate effect still make sense after a stop.
            .partition(|write| write.queued);
        arm.writes = kept;
        let queued: VecDeque<Write> = queued;
        for wait in waits {
            self.complete_wait(wait, Err(why.clone()));
        }
        for write in queued {
            self.answer(&write.pending, &Err(why.clone()));
        }
    }

    /// Processes a state, or a change of state.
    pub(super) fn handle_state(&mut self, now: HostInstant, params: &Value) {
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
        // Index and alarms come from the same reading, so a new alarm may belong to the command
        // that finished last.
        let index = state.get("current_index").and_then(Value::as_u64);
        self.finished(now, &name, index);
        if let Some(arm) = self.arms.get_mut(&name) {
            arm.raised = None;
        }
    }

    /// Processes an event of an arm.
    pub(super) fn handle_event(&mut self, params: &Value) {
        let text = |name: &str| params.get(name).and_then(Value::as_str).unwrap_or_default();
        let name = text("arm").to_owned();
        match text("event") {
            "stop" => {
                if let Some(arm) = self.arms.get_mut(&name) {
                    arm.is_jogging = false;
                }
                self.cancel(&name, &LinkError::cancelled("the arm was stopped"));
            }
            "reset" => {
                if let Some(arm) = self.arms.get_mut(&name) {
                    // After a reset indices start anew.
                    arm.current = None;
                }
                self.cancel(&name, &LinkError::cancelled("the arm was switched off"));
            }
            "link-lost" => {
                let why = LinkError::new(ErrorCode::LINE_LOST, "the line to the arm is lost");
                self.cancel(&name, &why);
                if let Some(arm) = self.arms.get(&name) {
                    let params = json!({"portName": arm.port_name});
                    let notification = rpc::notification("lostConnection", &params);
                    self.to_program.push_back(notification);
                }
            }
            // Other events do not end a wait.
            _ => {}
        }
    }

    /// Processes a change of the lease's holder.
    pub(super) fn handle_lease_change(&mut self, params: &Value) {
        let name = params
            .get("arm")
            .and_then(Value::as_str)
            .unwrap_or_default();
        let holder = params
            .get("holder")
            .and_then(|holder| holder.get("session"));
        let holder = holder.and_then(Value::as_str);
        let is_own = holder.is_some() && holder == self.session.as_deref();
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if !is_own && arm.lease.take().is_some() {
            arm.is_jogging = false;
            let why = "another session took the arm, or its lease ended";
            self.cancel(name, &LinkError::cancelled(why));
        }
    }
}

fn alarm_error(code: u8) -> LinkError {
    LinkError::cancelled(match Alarm::with_code(code) {
        Some(alarm) => format!("an alarm holds the queue: {}", alarm.name),
        None => format!("an alarm holds the queue: 0x{code:02X}"),
    })
}
