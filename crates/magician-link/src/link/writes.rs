//! Writes to an arm: one after the other, so that none overtakes another.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{Link, PendingCall, Write, WriteAnswer};
use crate::answers::Continuation;
use crate::error::{ErrorCode, LinkError};
use crate::waits::Wait;

/// Interval between keep-alives of a jog while its program lives. Several fit into [`JOG_KEEP_MS`].
pub(crate) const JOG_KEEP_INTERVAL: Duration = Duration::from_millis(250);
/// Keep-alive period of a jog at the station, ms: the longest that it accepts, because a link may
/// be delayed.
const JOG_KEEP_MS: u64 = 1000;
/// Interval between retries while the queue is full.
const FULL_QUEUE_RETRY_INTERVAL: Duration = Duration::from_millis(20);

impl Link {
    /// Appends a write.
    pub(crate) fn write(&mut self, now: HostInstant, name: &str, write: Write) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.writes.push_back(write);
        }
        self.send_next_write(now, name);
    }

    /// Starts a jog, which lasts until the program ends it. Before a jog of another axis the
    /// station brings the arm to rest.
    pub(crate) fn start_jog(
        &mut self,
        now: HostInstant,
        pending: &PendingCall,
        name: &str,
        axis: &str,
    ) {
        if let Some(arm) = self.arms.get_mut(name) {
            (arm.is_jogging, arm.jog) = (true, None);
        }
        let params = json!({"arm": name, "axis": axis, "keep_ms": JOG_KEEP_MS});
        let write = Write::new(pending, "jog.start", params, WriteAnswer::Jog);
        self.write(now, name, write);
    }

    /// Ends the jog ahead of all waiting writes, and cancels those of them that would start a jog.
    pub(crate) fn stop_jog(&mut self, name: &str, continuation: Continuation) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        (arm.is_jogging, arm.jog) = (false, None);
        let begins = |write: &Write| matches!(write.answer, WriteAnswer::Jog);
        let (dropped, kept): (Vec<_>, Vec<_>) =
            { std::mem::take(&mut arm.writes).into_iter() }.partition(begins);
        arm.writes = kept.into();
        for write in dropped {
            let why = LinkError::cancelled("the jog was stopped before it began");
            self.answer(&write.pending, &Err(why));
        }
        // Names the arm and not the jog, whose id is unknown while `jog.start` is unanswered.
        self.call("jog.stop", json!({"arm": name}), continuation);
    }

    /// Sends the next write, unless one is in flight. While the queue is full, writes that need no
    /// place in it go first.
    pub(crate) fn send_next_write(&mut self, now: HostInstant, name: &str) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        if arm.is_writing {
            return;
        }
        let blocked = arm.blocked_until.is_some_and(|until| now < until);
        let at = if blocked {
            arm.writes.iter().position(|write| !write.queued)
        } else {
            arm.blocked_until = None;
            Some(0)
        };
        let Some(write) = at.and_then(|at| arm.writes.remove(at)) else {
            return;
        };
        // One write is in flight at a time: the station's answers decide which write may follow.
        arm.is_writing = true;
        let (starts, held) = (arm.starts_queue, arm.lease.is_some());
        if !held {
            // Every write requests the lease, so that a program gets the arm as soon as the arm is
            // free.
            self.acquire(name);
            if starts {
                self.start_queue(name);
            }
        }
        let (method, params) = (write.method, write.params.clone());
        let arm = name.to_owned();
        self.call(method, params, Continuation::Written { arm, write });
    }

    /// Starts the queue if it is empty, because programs rely on another program having started it.
    pub(crate) fn start_queue(&mut self, name: &str) {
        self.call("link.start", json!({"arm": name}), Continuation::Nothing);
    }

    /// Requests the lease, if it is free.
    pub(crate) fn acquire(&mut self, name: &str) {
        let continuation = Continuation::Lease(name.to_owned());
        self.call("lease.acquire", json!({"arm": name}), continuation);
    }

    /// Handles the result of a write. Retries a queued command while the queue is full.
    pub(crate) fn handle_write_result(
        &mut self,
        now: HostInstant,
        name: &str,
        mut write: Write,
        outcome: Result<Value, LinkError>,
    ) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.is_writing = false;
            let full =
                { outcome.as_ref().err() }.is_some_and(|error| error.code == ErrorCode::QUEUE_FULL);
            // Only a queued command needs room in the queue.
            if full && write.queued {
                let give_up_at = *write.give_up_at.get_or_insert(now + write.timeout);
                if now < give_up_at {
                    arm.blocked_until = Some(now + FULL_QUEUE_RETRY_INTERVAL);
                    // Put back in front, so that the order of writes is kept.
                    arm.writes.push_front(write);
                    return self.send_next_write(now, name);
                }
            }
        }
        self.complete_write(now, name, write, outcome);
        self.send_next_write(now, name);
    }

    fn complete_write(
        &mut self,
        now: HostInstant,
        name: &str,
        write: Write,
        outcome: Result<Value, LinkError>,
    ) {
        let value = match outcome {
            Ok(value) => value,
            Err(error) => {
                if let (WriteAnswer::Jog, Some(arm)) = (write.answer, self.arms.get_mut(name)) {
                    let others = arm.writes.iter();
                    // Another jog may wait behind the failed jog.
                    arm.is_jogging &=
                        { others }.any(|write| matches!(write.answer, WriteAnswer::Jog));
                }
                return self.answer(&write.pending, &Err(error));
            }
        };
        let index = value.get("index").and_then(Value::as_u64);
        match (write.answer, index) {
            (WriteAnswer::Wait { homing }, Some(index)) => {
                let wait = Wait {
                    id: write.pending.id,
                    method: write.pending.method,
                    unknown_params: write.pending.unknown_params,
                    index,
                    timeout: write.timeout,
                    homing,
                    due: None,
                };
                self.wait(now, name, wait);
            }
            (WriteAnswer::Index, Some(index)) => {
                self.answer(&write.pending, &Ok(json!({"queuedCmdIndex": index})));
            }
            (WriteAnswer::StopQueue, _) => {
                self.cancel(name, &LinkError::cancelled("the queue was stopped"));
                self.answer(&write.pending, &Ok(json!(true)));
            }
            (WriteAnswer::Jog, _) => {
                let jog = value.get("jog").and_then(Value::as_str);
                if let (Some(arm), Some(jog)) = (self.arms.get_mut(name), jog) {
                    // Not stored if the jog was ended meanwhile.
                    arm.jog = arm
                        .is_jogging
                        .then(|| (jog.to_owned(), now + JOG_KEEP_INTERVAL));
                }
                self.answer(&write.pending, &Ok(json!(true)));
            }
            (WriteAnswer::Raw(method), _) => {
                let result = crate::answers::raw_result(method, &value);
                self.answer(&write.pending, &Ok(result));
            }
            // Also `Wait` and `Index` if the answer has no index, which does not happen for queued
            // commands.
            _ => self.answer(&write.pending, &Ok(json!(true))),
        }
    }
}
