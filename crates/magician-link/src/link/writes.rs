//! Writes to an arm: one after the other, so that none overtakes another.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{Asked, Link, Write, WriteEnd};
use crate::answers::Then;
use crate::error::{ErrorCode, LinkError};
use crate::waits::Wait;

/// Interval of keeping a jog alive while its program lives: several times within [`KEEP_MS`].
pub(crate) const KEEP_INTERVAL: Duration = Duration::from_millis(250);
/// Keep-alive period of a jog at the station, ms: the longest that it accepts, because a link may
/// be delayed.
const KEEP_MS: u64 = 1000;
/// Interval of trying again when the queue is full.
const FULL: Duration = Duration::from_millis(20);

impl Link {
    /// Appends a write.
    pub(crate) fn write(&mut self, now: HostInstant, name: &str, write: Write) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.writes.push_back(write);
        }
        self.pump(now, name);
    }

    /// Starts a jog, which lasts until the program ends it. Before a jog of another axis the
    /// station brings the arm to rest.
    pub(crate) fn start_jog(&mut self, now: HostInstant, asked: &Asked, name: &str, axis: &str) {
        if let Some(arm) = self.arms.get_mut(name) {
            (arm.jogs, arm.jog) = (true, None);
        }
        let params = json!({"arm": name, "axis": axis, "keep_ms": KEEP_MS});
        let write = Write::new(asked, "jog.start", params, WriteEnd::Jog);
        self.write(now, name, write);
    }

    /// Ends the jog before everything that waits. A jog that waits does not start.
    pub(crate) fn stop_jog(&mut self, name: &str, then: Then) {
        let Some(arm) = self.arms.get_mut(name) else {
            return;
        };
        (arm.jogs, arm.jog) = (false, None);
        let begins = |write: &Write| matches!(write.end, WriteEnd::Jog);
        let (dropped, kept): (Vec<_>, Vec<_>) =
            { std::mem::take(&mut arm.writes).into_iter() }.partition(begins);
        arm.writes = kept.into();
        for write in dropped {
            let why = LinkError::cancelled("the jog was stopped before it began");
            self.answer(&write.asked, &Err(why));
        }
        // Sent by the arm and not by the jog, whose id is unknown while `jog.start` is unanswered.
        self.call("jog.stop", json!({"arm": name}), then);
    }

    /// Sends the next write, unless one is in flight. While the queue is full, writes that need no
    /// place in it go first.
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
        // One write is in flight at a time: the station's answers decide which write may follow.
        arm.writing = true;
        let (starts, held) = (arm.starts, arm.lease.is_some());
        if !held {
            // Asked for again with every write, so that a program gets the arm as soon as it is
            // free.
            self.acquire(name);
            if starts {
                self.start(name);
            }
        }
        let (method, params) = (write.method, write.params.clone());
        let arm = name.to_owned();
        self.call(method, params, Then::Written { arm, write });
    }

    /// Starts the queue if it is empty. Programs rely on a queue that another program has started.
    pub(crate) fn start(&mut self, name: &str) {
        self.call("link.start", json!({"arm": name}), Then::Nothing);
    }

    /// Requests the lease, if it is free.
    pub(crate) fn acquire(&mut self, name: &str) {
        let then = Then::Lease(name.to_owned());
        self.call("lease.acquire", json!({"arm": name}), then);
    }

    /// Takes the result of a write.
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
            // Only a queued command can hope for room.
            if full && write.queued {
                let give_up = *write.give_up.get_or_insert(now + write.timeout);
                if now < give_up {
                    arm.blocked = Some(now + FULL);
                    // In front again, so that the order stays.
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
            Err(error) => {
                if let (WriteEnd::Jog, Some(arm)) = (write.end, self.arms.get_mut(name)) {
                    let others = arm.writes.iter();
                    // Another jog may wait behind the failed jog.
                    arm.jogs &= { others }.any(|write| matches!(write.end, WriteEnd::Jog));
                }
                return self.answer(&write.asked, &Err(error));
            }
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
            (WriteEnd::Jog, _) => {
                let jog = value.get("jog").and_then(Value::as_str);
                if let (Some(arm), Some(jog)) = (self.arms.get_mut(name), jog) {
                    // Not stored if the jog was ended meanwhile.
                    arm.jog = arm.jogs.then(|| (jog.to_owned(), now + KEEP_INTERVAL));
                }
                self.answer(&write.asked, &Ok(json!(true)));
            }
            (WriteEnd::Raw(method), _) => {
                let result = crate::answers::raw(method, &value);
                self.answer(&write.asked, &Ok(result));
            }
            // Includes a wait or an index without an index in the answer, which does not happen for
            // queued commands.
            _ => self.answer(&write.asked, &Ok(json!(true))),
        }
    }
}
