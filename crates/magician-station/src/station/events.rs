//! The last events of an arm, each with its number.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Map, Value, json};

/// Events that are kept, and given at once.
const KEPT: usize = 1000;
/// Stops are obeyed in any number; of those that come within this time one is told. A loop of stops would push all other
/// events out of the log, and its listeners off their sockets.
const STOP_INTERVAL: Duration = Duration::from_millis(50);

#[derive(Debug, Default)]
pub(super) struct EventLog {
    seq: u64,
    events: VecDeque<(u64, Value)>,
    /// When a stop was told last.
    stopped: Option<HostInstant>,
}

impl EventLog {
    /// Numbers an event and keeps it.
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
        if self.events.len() == KEPT {
            self.events.pop_front();
        }
        self.events.push_back((self.seq, event.clone()));
        event
    }

    /// True if a stop is to be told: none was a moment ago.
    pub(super) fn tells_stop(&mut self, now: HostInstant) -> bool {
        let due = self.stopped.is_none_or(|told| now - told >= STOP_INTERVAL);
        if due {
            self.stopped = Some(now);
        }
        due
    }

    /// Those that happened from then on, Unix seconds.
    pub(super) fn after(&self, t: f64) -> impl Iterator<Item = &Value> {
        let events = self.events.iter().map(|(_, event)| event);
        events.filter(move |event| event["t"].as_f64().is_some_and(|at| at >= t))
    }

    pub(super) fn len(&self) -> usize {
        self.events.len()
    }

    /// Those behind a number, and the number of the last.
    pub(super) fn since(&self, seq: u64) -> Value {
        let behind = self.events.iter().filter(|(number, _)| *number > seq);
        let events: Vec<_> = behind.map(|(_, event)| event.clone()).collect();
        json!({"events": events, "seq": self.seq})
    }
}
