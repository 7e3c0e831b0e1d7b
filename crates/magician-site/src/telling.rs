//! When a state is told: on change, ten times a second at most, and every second.

use std::time::Duration;

use serde_json::{Map, Value, json};

/// Between two states, at least. One that comes late takes nothing from the next: else each delay would stay, and every state would be
/// told as late as the latest. And a little less than the tenth of a second at which the station tells: else what comes just behind a
/// telling would wait for the next one, and so would each behind it.
const LEAST: Duration = Duration::from_millis(90);
/// And at most.
const MOST: Duration = Duration::from_secs(1);
/// From here on the next word of the station is told whatever it says, while it is new.
const SOON: Duration = Duration::from_millis(880);

/// The state of an arm as it is put together of what its station tells, and when it is told on. Times count from anywhere.
#[derive(Debug, Default)]
pub struct StateTelling {
    state: Map<String, Value>,
    has_changed: bool,
    told: Option<Duration>,
    /// A change is told from here on.
    next: Duration,
}

impl StateTelling {
    /// The station tells what has changed, or all of it.
    pub fn hear(&mut self, now: Duration, change: Map<String, Value>) {
        self.has_changed |= self.told.is_some_and(|told| now >= told + SOON);
        for (name, value) in change {
            // The time alone is no change.
            self.has_changed |= name != "t" && self.state.get(&name) != Some(&value);
            self.state.insert(name, value);
        }
    }

    /// When it is to be told next; none while nothing is known.
    #[must_use]
    pub fn due(&self) -> Option<Duration> {
        if self.state.is_empty() {
            return None;
        }
        Some(match self.told {
            None => Duration::ZERO,
            Some(_) if self.has_changed => self.next,
            Some(told) => told + MOST,
        })
    }

    /// The state, if it is to be told by now.
    pub fn tell(&mut self, now: Duration) -> Option<Value> {
        if self.due()? > now {
            return None;
        }
        self.told = Some(now);
        self.next = self.next.max(now.saturating_sub(LEAST)) + LEAST;
        self.has_changed = false;
        Some(Value::Object(self.state.clone()))
    }

    /// The last that is known, null where nothing is.
    #[must_use]
    pub fn last(&self) -> Value {
        if self.state.is_empty() {
            json!(null)
        } else {
            Value::Object(self.state.clone())
        }
    }

    /// Nobody listens any more: what is heard next is told at once.
    pub fn rest(&mut self) {
        self.told = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(fields: Value) -> Map<String, Value> {
        serde_json::from_value(fields).unwrap()
    }

    #[test]
    fn what_is_told_late_delays_nothing_behind_it() {
        let at = Duration::from_millis;
        let mut telling = StateTelling::default();
        let mut told = Vec::new();
        // Ten changes a second, of which the third comes 80 ms late.
        for heard in [1000, 1100, 1280, 1300, 1400, 1500] {
            telling.hear(at(heard), change(json!({"x": heard})));
            told.push(telling.due().unwrap().max(at(heard)));
            assert!(telling.tell(*told.last().unwrap()).is_some());
        }
        assert_eq!(told, [1000, 1100, 1280, 1300, 1400, 1500].map(at));
        // More than that are held.
        telling.hear(at(1501), change(json!({"x": 1501})));
        assert_eq!(telling.due(), Some(at(1550)));
        assert!(telling.tell(at(1550)).is_some());
        telling.hear(at(1551), change(json!({"x": 1502})));
        assert_eq!(telling.due(), Some(at(1640)));
    }

    #[test]
    fn what_comes_just_behind_a_telling_is_soon_told_as_it_comes() {
        let at = Duration::from_millis;
        let mut telling = StateTelling::default();
        telling.hear(at(0), change(json!({"x": 0})));
        assert!(telling.tell(at(93)).is_some());
        let mut ages = Vec::new();
        for heard in (100..3000).step_by(100) {
            telling.hear(at(heard), change(json!({"x": heard})));
            let told = telling.due().unwrap().max(at(heard));
            // Unless a newer one has come.
            if told < at(heard + 100) {
                assert!(telling.tell(told).is_some());
                ages.push(told - at(heard));
            }
        }
        assert_eq!(ages.last(), Some(&Duration::ZERO), "{ages:?}");
        assert!(
            ages.iter().filter(|age| **age > at(50)).count() < 6,
            "{ages:?}"
        );
    }

    #[test]
    fn a_change_is_told_soon_and_the_rest_every_second() {
        let at = Duration::from_millis;
        let mut telling = StateTelling::default();
        assert_eq!((telling.due(), telling.tell(at(5))), (None, None));
        assert_eq!(telling.last(), Value::Null);
        telling.hear(at(5), change(json!({"t": 1, "x": 1})));
        assert_eq!(telling.tell(at(5)), Some(json!({"t": 1, "x": 1})));
        // Time alone is no change.
        telling.hear(at(105), change(json!({"t": 2, "x": 1})));
        assert_eq!(telling.due(), Some(at(1005)));
        assert_eq!(telling.tell(at(1004)), None);
        telling.hear(at(108), change(json!({"t": 3, "x": 2})));
        assert_eq!(telling.due(), Some(at(90)));
        assert_eq!(telling.tell(at(89)), None);
        assert_eq!(telling.tell(at(108)), Some(json!({"t": 3, "x": 2})));
        assert_eq!(telling.tell(at(1107)), None);
        assert_eq!(telling.tell(at(1108)), Some(json!({"t": 3, "x": 2})));
        // Near the end of the second what comes is told as it comes.
        telling.hear(at(1908), change(json!({"t": 4})));
        assert_eq!(telling.tell(at(1908)), None);
        telling.hear(at(2008), change(json!({"t": 5})));
        assert_eq!(telling.tell(at(2008)), Some(json!({"t": 5, "x": 2})));
        telling.rest();
        assert!(telling.tell(at(1106)).is_some());
    }
}
