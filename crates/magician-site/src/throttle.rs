//! Rate limiting of an arm's state: published on change, at most ten times a second, and at least
//! once a second.
//!
//! A station reports a changed state up to ten times a second. [`StateThrottle`] merges these
//! reports into one complete state and decides when to publish it. The aim is that published states
//! are recent: a report that arrives late must not delay the ones after it, and a report that
//! serves only as the keep-alive must be fresh.

use std::time::Duration;

use serde_json::{Map, Value, json};

/// Shortest interval between two states.
///
/// A state that is published late does not postpone the next one; otherwise every delay would stay
/// and all states would be as late as the worst. The interval is a little shorter than the
/// station's tenth of a second: with an equal one, a report that arrives just after a publication
/// would wait for the next slot, and so would every report after it.
const MIN_INTERVAL: Duration = Duration::from_millis(90);
/// Longest interval between two states. Serves as a keep-alive while nothing changes.
const MAX_INTERVAL: Duration = Duration::from_secs(1);
/// If the last published state is at least this old, the next report is published even without a
/// change. Just below [`MAX_INTERVAL`], so that the keep-alive carries a fresh report instead of
/// one up to 100 ms old.
const KEEP_ALIVE_AGE: Duration = Duration::from_millis(880);

/// Merged state of an arm and the schedule of its publications. All times count from one arbitrary
/// origin.
#[derive(Debug, Default)]
pub struct StateThrottle {
    state: Map<String, Value>,
    has_changed: bool,
    last_published: Option<Duration>,
    /// Earliest time at which a changed state may be published.
    next: Duration,
}

impl StateThrottle {
    /// Merges a report of the station, which contains changed fields or all of them.
    pub fn merge(&mut self, now: Duration, change: Map<String, Value>) {
        self.has_changed |= self
            .last_published
            .is_some_and(|at| now >= at + KEEP_ALIVE_AGE);
        for (name, value) in change {
            // A new time stamp alone is no change: it differs in every report.
            self.has_changed |= name != "t" && self.state.get(&name) != Some(&value);
            self.state.insert(name, value);
        }
    }

    /// Time of the next publication, or `None` while no state is known.
    #[must_use]
    pub fn due(&self) -> Option<Duration> {
        if self.state.is_empty() {
            return None;
        }
        Some(match self.last_published {
            None => Duration::ZERO,
            Some(_) if self.has_changed => self.next,
            Some(at) => at + MAX_INTERVAL,
        })
    }

    /// Returns the state to publish, or `None` if none is due at `now`.
    pub fn take_due(&mut self, now: Duration) -> Option<Value> {
        if self.due()? > now {
            return None;
        }
        self.last_published = Some(now);
        // Count from the planned time, so that a late state does not postpone later ones. After a
        // pause of more than an interval count from `now`, so that no burst follows.
        self.next = self.next.max(now.saturating_sub(MIN_INTERVAL)) + MIN_INTERVAL;
        self.has_changed = false;
        Some(Value::Object(self.state.clone()))
    }

    /// Last known state, or null if no state is known.
    #[must_use]
    pub fn last(&self) -> Value {
        if self.state.is_empty() {
            json!(null)
        } else {
            Value::Object(self.state.clone())
        }
    }

    /// Forgets the last publication, because there is no listener any more. The next state is due
    /// at once.
    pub fn reset_schedule(&mut self) {
        self.last_published = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(fields: Value) -> Map<String, Value> {
        serde_json::from_value(fields).unwrap()
    }

    #[test]
    fn late_publication_does_not_postpone_later_ones() {
        let at = Duration::from_millis;
        let mut throttle = StateThrottle::default();
        let mut published = Vec::new();
        // Ten changes a second, of which the third comes 80 ms late.
        for heard in [1000, 1100, 1280, 1300, 1400, 1500] {
            throttle.merge(at(heard), change(json!({"x": heard})));
            published.push(throttle.due().unwrap().max(at(heard)));
            assert!(throttle.take_due(*published.last().unwrap()).is_some());
        }
        assert_eq!(published, [1000, 1100, 1280, 1300, 1400, 1500].map(at));
        // More frequent changes are held back.
        throttle.merge(at(1501), change(json!({"x": 1501})));
        assert_eq!(throttle.due(), Some(at(1550)));
        assert!(throttle.take_due(at(1550)).is_some());
        throttle.merge(at(1551), change(json!({"x": 1502})));
        assert_eq!(throttle.due(), Some(at(1640)));
    }

    #[test]
    fn report_just_after_a_publication_is_published_soon() {
        let at = Duration::from_millis;
        let mut throttle = StateThrottle::default();
        throttle.merge(at(0), change(json!({"x": 0})));
        assert!(throttle.take_due(at(93)).is_some());
        let mut ages = Vec::new();
        for heard in (100..3000).step_by(100) {
            throttle.merge(at(heard), change(json!({"x": heard})));
            let published = throttle.due().unwrap().max(at(heard));
            // Otherwise the next report replaces this one before it is published.
            if published < at(heard + 100) {
                assert!(throttle.take_due(published).is_some());
                ages.push(published - at(heard));
            }
        }
        assert_eq!(ages.last(), Some(&Duration::ZERO), "{ages:?}");
        assert!(
            ages.iter().filter(|age| **age > at(50)).count() < 6,
            "{ages:?}"
        );
    }

    #[test]
    fn changes_are_published_soon_and_unchanged_states_every_second() {
        let at = Duration::from_millis;
        let mut throttle = StateThrottle::default();
        assert_eq!((throttle.due(), throttle.take_due(at(5))), (None, None));
        assert_eq!(throttle.last(), Value::Null);
        throttle.merge(at(5), change(json!({"t": 1, "x": 1})));
        assert_eq!(throttle.take_due(at(5)), Some(json!({"t": 1, "x": 1})));
        // Time alone is no change.
        throttle.merge(at(105), change(json!({"t": 2, "x": 1})));
        assert_eq!(throttle.due(), Some(at(1005)));
        assert_eq!(throttle.take_due(at(1004)), None);
        throttle.merge(at(108), change(json!({"t": 3, "x": 2})));
        assert_eq!(throttle.due(), Some(at(90)));
        assert_eq!(throttle.take_due(at(89)), None);
        assert_eq!(throttle.take_due(at(108)), Some(json!({"t": 3, "x": 2})));
        assert_eq!(throttle.take_due(at(1107)), None);
        assert_eq!(throttle.take_due(at(1108)), Some(json!({"t": 3, "x": 2})));
        // Just before the keep-alive is due, a report is published even without a change.
        throttle.merge(at(1908), change(json!({"t": 4})));
        assert_eq!(throttle.take_due(at(1908)), None);
        throttle.merge(at(2008), change(json!({"t": 5})));
        assert_eq!(throttle.take_due(at(2008)), Some(json!({"t": 5, "x": 2})));
        throttle.reset_schedule();
        assert!(throttle.take_due(at(1106)).is_some());
    }
}
