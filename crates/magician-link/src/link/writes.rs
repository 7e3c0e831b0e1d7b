//! What is written to an arm: one after the other, so that none overtakes another.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{Link, Write, WriteEnd};
use crate::answers::Then;
use crate::error::{ErrorCode, LinkError};
use crate::waits::Wait;

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
}
