//! Calls that are answered when their queued command has finished.
//!
//! The arm reports only the index of the last finished command, so a call waits for an index. Its
//! timeout starts when the command becomes the next one; until then other commands are running.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::Value;

/// Call that waits.
#[derive(Debug)]
pub(crate) struct Wait {
    /// Id for the answer.
    pub(crate) id: Option<Value>,
    /// Name of the call, for the report.
    pub(crate) method: String,
    /// Parameters that the call does not have.
    pub(crate) unknown_params: Vec<String>,
    /// Index of the queued command.
    pub(crate) index: u64,
    /// Timeout, counted from the instant at which the command is the next one in the queue.
    pub(crate) timeout: Duration,
    /// True for homing, which runs although an alarm holds the queue.
    pub(crate) homing: bool,
    /// Deadline from `timeout`. `None` while other commands are ahead in the queue.
    pub(crate) due: Option<HostInstant>,
}

/// Calls that wait at an arm, in the order of their indices.
#[derive(Debug, Default)]
pub(crate) struct Waits(Vec<Wait>);

impl Waits {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn push(&mut self, wait: Wait) {
        self.0.push(wait);
    }

    /// Records that the arm has finished commands up to this index. Returns the calls whose
    /// commands have finished, and starts the timeout of the next one.
    pub(crate) fn finished(&mut self, now: HostInstant, current: u64) -> Vec<Wait> {
        let finished = self
            .0
            .extract_if(.., |wait| wait.index <= current)
            .collect();
        // The first index of an arm is 1 or 2 (model section 14).
        let next = match current {
            0 => 1..=2,
            _ => current.saturating_add(1)..=current.saturating_add(1),
        };
        for wait in &mut self.0 {
            // The time starts once, however often the same index is reported.
            if next.contains(&wait.index) && wait.due.is_none() {
                wait.due = Some(now + wait.timeout);
            }
        }
        finished
    }

    /// Removes and returns the calls whose time is over.
    pub(crate) fn take_expired(&mut self, now: HostInstant) -> Vec<Wait> {
        let is_expired = |wait: &mut Wait| wait.due.is_some_and(|due| due <= now);
        self.0.extract_if(.., is_expired).collect()
    }

    /// Returns the earliest instant at which the time of a call is over.
    pub(crate) fn next_deadline(&self) -> Option<HostInstant> {
        self.0.iter().filter_map(|wait| wait.due).min()
    }

    /// Removes and returns the calls that an alarm holds.
    pub(crate) fn take_held_by_alarm(&mut self) -> Vec<Wait> {
        self.0.extract_if(.., |wait| !wait.homing).collect()
    }

    /// Removes and returns all calls, because they will not finish.
    pub(crate) fn cancel(&mut self) -> Vec<Wait> {
        std::mem::take(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_of_first_command_begins_at_index_1_or_2() {
        let now = HostInstant::ZERO;
        for (index, due) in [(1, true), (2, true), (3, false)] {
            let mut waits = Waits::default();
            waits.push(Wait {
                id: None,
                method: String::new(),
                unknown_params: Vec::new(),
                index,
                timeout: Duration::from_secs(1),
                homing: false,
                due: None,
            });
            assert!(waits.finished(now, 0).is_empty());
            assert_eq!(waits.next_deadline().is_some(), due, "{index}");
        }
    }
}
