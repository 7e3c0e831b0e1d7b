//! What is written to an arm: one after the other, so that none overtakes another.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{Asked, Link, Write, WriteEnd};
use crate::answers::Then;
use crate::error::{ErrorCode, LinkError};
use crate::waits::Wait;

/// How often a jog is kept up while its program lives: several times within [`KEEP_MS`].
pub(crate) const KEEP_INTERVAL: Duration = Duration::from_millis(250);
/// How long the station lets a jog go on without being kept up: the longest that it takes, for a link that is held up.
const KEEP_MS: u64 = 1000;
/// A queue that is full is tried again after so long.
const FULL: Duration = Duration::from_millis(20);

impl Link {
    /// Writes to an arm when what came before was taken.
    pub(crate) fn write(&mut self, now: HostInstant, name: &str, write: Write) {
        if let Some(arm) = self.arms.get_mut(name) {
            arm.writes.push_back(write);
        }
        self.pump(now, name);
    }

    /// Jogs until the program says otherwise. The station brings the arm to rest before a jog of another axis.
    pub(crate) fn start_jog(&mut self, now: HostInstant, asked: &Asked, name: &str, axis: &str) {
        if let Some(arm) = self.arms.get_mut(name) {
            (arm.jogs, arm.jog) = (true, None);
        }
        let params = json!({"arm": name, "axis": axis, "keep_ms": KEEP_MS});
        let write = Write::new(asked, "jog.start", params, WriteEnd::Jog);
        self.write(now, name, write);
    }

    /// Ends the jog, before everything that waits. One that has not begun does not begin.
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
        self.call("jog.stop", json!({"arm": name}), then);
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
            Err(error) => {
                if let (WriteEnd::Jog, Some(arm)) = (write.end, self.arms.get_mut(name)) {
                    let others = arm.writes.iter();
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
                    // One that was ended meanwhile is over.
                    arm.jog = arm.jogs.then(|| (jog.to_owned(), now + KEEP_INTERVAL));
                }
                self.answer(&write.asked, &Ok(json!(true)));
            }
            (WriteEnd::Raw(method), _) => {
                let result = crate::answers::raw(method, &value);
                self.answer(&write.asked, &Ok(result));
            }
            _ => self.answer(&write.asked, &Ok(json!(true))),
        }
    }
}
