//! Lines that others can cause as fast as they send bytes: a few of a kind are shown, the rest is counted.

use std::collections::HashMap;
use std::hash::Hash;
use std::time::Duration;

/// So many lines of a kind are shown at once.
const SHOWN: u32 = 10;
/// A flood is counted for so long before it is told, and then twice as long each time.
const FIRST: Duration = Duration::from_secs(1);
const LONGEST: Duration = Duration::from_secs(64);

/// Lines by their kind. It reads no clock: instants are told, as time since any beginning.
#[derive(Clone, Debug)]
pub(crate) struct Throttle<K> {
    kinds: HashMap<K, Flood>,
}

#[derive(Clone, Debug)]
struct Flood {
    /// When the period began.
    since: Duration,
    period: Duration,
    /// Lines that may still be shown in it.
    left: u32,
    /// Lines that were not.
    held: u64,
    /// The last of them.
    last: String,
}

/// Lines that were not shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Held {
    pub(crate) count: u64,
    /// The last of them.
    pub(crate) last: String,
    /// The time in which they came, s.
    pub(crate) seconds: u64,
}

impl<K> Default for Throttle<K> {
    fn default() -> Self {
        Self {
            kinds: HashMap::new(),
        }
    }
}

impl<K: Hash + Eq> Throttle<K> {
    /// Whether a line of this kind is to be shown now.
    pub(crate) fn passes(&mut self, now: Duration, kind: K, line: &str) -> bool {
        let flood = self.kinds.entry(kind).or_insert_with(|| Flood::calm(now));
        if flood.left > 0 {
            flood.left -= 1;
            return true;
        }
        flood.held += 1;
        if flood.last != line {
            line.clone_into(&mut flood.last);
        }
        false
    }

    /// What has been held back in the periods that have ended. To be asked before each line, and often enough.
    pub(crate) fn ended(&mut self, now: Duration) -> Vec<Held> {
        let mut told = Vec::new();
        self.kinds.retain(|_, flood| {
            if now.saturating_sub(flood.since) < flood.period {
                return true;
            }
            told.extend(flood.take(now));
            // A kind that was quiet for a period is as new.
            flood.left == 0 && flood.since == now
        });
        told
    }

    /// The end: what has been held back until now.
    pub(crate) fn rest(&mut self, now: Duration) -> Vec<Held> {
        let floods = self.kinds.values_mut();
        floods.filter_map(|flood| flood.take(now)).collect()
    }
}

impl Flood {
    fn calm(now: Duration) -> Self {
        Self {
            since: now,
            period: FIRST,
            left: SHOWN,
            held: 0,
            last: String::new(),
        }
    }

    /// Begins the next period of a flood; what the one before has held back, if anything.
    fn take(&mut self, now: Duration) -> Option<Held> {
        let count = std::mem::take(&mut self.held);
        if count == 0 {
            return None;
        }
        let seconds = now.saturating_sub(self.since).as_secs().max(1);
        (self.since, self.period) = (now, (self.period * 2).min(LONGEST));
        Some(Held {
            count,
            last: std::mem::take(&mut self.last),
            seconds,
        })
    }
}

/// `a damaged frame was ignored; and 4811 more like it in the last 2 s`
impl std::fmt::Display for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            count,
            last,
            seconds,
        } = self;
        match count {
            1 => f.write_str(last),
            _ => {
                let more = count - 1;
                write!(f, "{last}; and {more} more like it in the last {seconds} s")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines that are written if one comes each millisecond for so many seconds.
    fn written(seconds: u64) -> (u64, u64) {
        let mut throttle = Throttle::default();
        let (mut lines, mut told) = (0, 0);
        for at in (0..seconds * 1000).map(Duration::from_millis) {
            for held in throttle.ended(at) {
                (lines, told) = (lines + 1, told + held.count);
            }
            if throttle.passes(at, "damaged", "a damaged frame") {
                (lines, told) = (lines + 1, told + 1);
            }
        }
        let end = Duration::from_secs(seconds);
        let rest = throttle.rest(end).into_iter().map(|held| held.count);
        (lines, told + rest.sum::<u64>())
    }

    #[test]
    fn a_flood_is_a_few_lines_and_every_one_is_counted() {
        assert_eq!(written(10), (10 + 3, 10_000));
        assert_eq!(written(3600).1, 3_600_000);
        assert!(written(3600).0 < 100);
    }

    #[test]
    fn what_comes_now_and_then_is_shown_as_it_comes() {
        let mut throttle = Throttle::default();
        for second in 0..1000 {
            let now = Duration::from_secs(second);
            assert_eq!(throttle.ended(now), []);
            assert!(throttle.passes(now, 1, "line"));
        }
    }

    #[test]
    fn after_a_flood_and_some_quiet_lines_are_shown_again() {
        let mut throttle = Throttle::default();
        let at = Duration::from_millis;
        for nth in 0..12 {
            assert_eq!(throttle.passes(at(nth), 1, "line"), nth < 10);
        }
        let [held] = &throttle.ended(at(1000))[..] else {
            panic!("one kind")
        };
        assert_eq!(held.to_string(), "line; and 1 more like it in the last 1 s");
        assert!(!throttle.passes(at(1500), 1, "line"), "it goes on");
        assert_eq!(throttle.ended(at(3000)).len(), 1);
        assert_eq!(throttle.ended(at(9000)), []);
        assert!(throttle.passes(at(9000), 1, "line"));
        assert_eq!(throttle.rest(at(9001)), []);
    }
}
