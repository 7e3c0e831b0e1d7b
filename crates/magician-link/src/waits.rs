//! Calls that are answered when what they queued has ended.

use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::Value;

/// A call that waits.
#[derive(Debug)]
pub(crate) struct Wait {
    /// Under which it is answered.
    pub(crate) id: Option<Value>,
    /// What was called, for the report.
    pub(crate) method: String,
    /// Parameters that the call does not have.
    pub(crate) odd: Vec<String>,
    /// The index of what it queued.
    pub(crate) index: u64,
    /// How long it may take from the moment at which it is the next.
    pub(crate) timeout: Duration,
    /// Whether it waits for homing, which runs while an alarm holds the queue.
    pub(crate) homing: bool,
    /// When that is over; none while others are before it.
    pub(crate) due: Option<HostInstant>,
}

/// The calls that wait at an arm, in the order of their indices.
#[derive(Debug, Default)]
pub(crate) struct Waits(Vec<Wait>);

impl Waits {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn push(&mut self, wait: Wait) {
        self.0.push(wait);
    }

    /// The arm has finished up to this index: those that are over. The time of the next one begins.
    pub(crate) fn finished(&mut self, now: HostInstant, current: u64) -> Vec<Wait> {
        let over = self
            .0
            .extract_if(.., |wait| wait.index <= current)
            .collect();
        // The first index that an arm gives is 1 or 2 (model section 14).
        let next = match current {
            0 => 1..=2,
            _ => current.saturating_add(1)..=current.saturating_add(1),
        };
        for wait in &mut self.0 {
            if next.contains(&wait.index) && wait.due.is_none() {
                wait.due = Some(now + wait.timeout);
            }
        }
        over
    }

    /// Those whose time is over.
    pub(crate) fn late(&mut self, now: HostInstant) -> Vec<Wait> {
        let is_late = |wait: &mut Wait| wait.due.is_some_and(|due| due <= now);
        self.0.extract_if(.., is_late).collect()
    }

    /// When the next one's time is over.
    pub(crate) fn due(&self) -> Option<HostInstant> {
        self.0.iter().filter_map(|wait| wait.due).min()
    }

    /// Those that an alarm holds.
    pub(crate) fn held(&mut self) -> Vec<Wait> {
        self.0.extract_if(.., |wait| !wait.homing).collect()
    }

    /// All of them: they will not end.
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
                odd: Vec::new(),
                index,
                timeout: Duration::from_secs(1),
                homing: false,
                due: None,
            });
            assert!(waits.finished(now, 0).is_empty());
            assert_eq!(waits.due().is_some(), due, "{index}");
        }
    }
}
