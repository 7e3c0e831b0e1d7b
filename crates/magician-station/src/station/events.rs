//! Log of the last events of an arm, numbered.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Map, Value, json};

/// Number of events that are kept, and returned at once. A choice that bounds memory and the size
/// of an answer.
const MAX_EVENTS: usize = 1000;
/// Shortest interval between two events of a stop. Every stop is obeyed, but a loop of stops would
/// push all other events out of the log and overflow the outboxes of its subscribers.
const STOP_INTERVAL: Duration = Duration::from_millis(50);

#[derive(Debug, Default)]
pub(super) struct EventLog {
    seq: u64,
    events: VecDeque<(u64, Value)>,
    /// Instant of the last event of a stop.
    stopped: Option<HostInstant>,
}

impl EventLog {
    /// Appends an event. Returns it with its number.
    pub(super) fn push(
        &mut self,
        arm: &str,
        t: f64,
        name: &str,
        fields: Vec<(&'static str, Value)>,
    ) -> Value {
        self.seq += 1;
        let mut event = Map::new();
        for (name, value) in [
            ("arm", json!(arm)),
            ("seq", json!(self.seq)),
            ("t", json!(t)),
            ("event", json!(name)),
        ]
        .into_iter()
        .chain(fields)
        {
            event.insert(name.to_owned(), value);
        }
        let event = Value::Object(event);
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back((self.seq, event.clone()));
        event
    }

    /// Returns true if a stop is to be recorded, because the last record is old enough.
    pub(super) fn should_record_stop(&mut self, now: HostInstant) -> bool {
        let due = self.stopped.is_none_or(|told| now - told >= STOP_INTERVAL);
        if due {
            self.stopped = Some(now);
        }
        due
    }

    /// Returns the events from `t` on, Unix seconds.
    pub(super) fn after(&self, t: f64) -> impl Iterator<Item = &Value> {
        let events = self.events.iter().map(|(_, event)| event);
        events.filter(move |event| event["t"].as_f64().is_some_and(|at| at >= t))
    }

    pub(super) fn len(&self) -> usize {
        self.events.len()
    }

    /// Returns the events after a number, and the last number.
    pub(super) fn since(&self, seq: u64) -> Value {
        let behind = self.events.iter().filter(|(number, _)| *number > seq);
        let events: Vec<_> = behind.map(|(_, event)| event.clone()).collect();
        json!({"events": events, "seq": self.seq})
    }
}
