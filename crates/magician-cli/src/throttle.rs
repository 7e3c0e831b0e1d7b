//! Rate limit for log lines that remote peers can cause: a few of each kind are shown, the rest is
//! counted.
//!
//! A peer that sends garbage could otherwise fill the log of a station at the speed of its line.
//! Each kind of line has a budget for a period. When the period ends, one summary replaces the
//! suppressed lines, and the next period is twice as long; a period without lines resets the kind.

use std::collections::HashMap;
use std::hash::Hash;
use std::time::Duration;

/// Lines of a kind shown at once. A choice.
const LINES_PER_PERIOD: u32 = 10;
/// First period after which suppressed lines are summarized. Each further period is twice as long,
/// up to `MAX_PERIOD`, so that the summaries of a lasting flood stay few.
const FIRST_PERIOD: Duration = Duration::from_secs(1);
const MAX_PERIOD: Duration = Duration::from_secs(64);

/// Lines counted by kind. Reads no clock: the caller passes the time since any origin.
#[derive(Clone, Debug)]
pub(crate) struct Throttle<K> {
    kinds: HashMap<K, Flood>,
}

#[derive(Clone, Debug)]
struct Flood {
    /// Start of the period.
    since: Duration,
    period: Duration,
    /// Lines that may still be shown in the period.
    left: u32,
    /// Lines suppressed in the period.
    suppressed: u64,
    /// Last suppressed line of the period.
    last: String,
}

/// Summary of suppressed lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Suppressed {
    pub(crate) count: u64,
    /// Last suppressed line.
    pub(crate) last: String,
    /// Time in which they came, s.
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
    /// True if a line of this kind may be shown now.
    pub(crate) fn allows(&mut self, now: Duration, kind: K, line: &str) -> bool {
        let flood = self
            .kinds
            .entry(kind)
            .or_insert_with(|| Flood::starting_at(now));
        if flood.left > 0 {
            flood.left -= 1;
            return true;
        }
        flood.suppressed += 1;
        if flood.last != line {
            line.clone_into(&mut flood.last);
        }
        false
    }

    /// Returns summaries of all periods that have ended. To be called before each line and at
    /// regular intervals.
    pub(crate) fn take_ended(&mut self, now: Duration) -> Vec<Suppressed> {
        let mut summaries = Vec::new();
        self.kinds.retain(|_, flood| {
            if now.saturating_sub(flood.since) < flood.period {
                return true;
            }
            summaries.extend(flood.take(now));
            // A kind without lines for a whole period starts anew.
            flood.left == 0 && flood.since == now
        });
        summaries
    }

    /// Returns summaries of everything suppressed so far, for the end of the program.
    pub(crate) fn take_all(&mut self, now: Duration) -> Vec<Suppressed> {
        let floods = self.kinds.values_mut();
        floods.filter_map(|flood| flood.take(now)).collect()
    }
}

impl Flood {
    fn starting_at(now: Duration) -> Self {
        Self {
            since: now,
            period: FIRST_PERIOD,
            left: LINES_PER_PERIOD,
            suppressed: 0,
            last: String::new(),
        }
    }

    /// Begins the next period. Returns the summary of the last one, or `None` if nothing was
    /// suppressed.
    fn take(&mut self, now: Duration) -> Option<Suppressed> {
        let count = std::mem::take(&mut self.suppressed);
        if count == 0 {
            return None;
        }
        let seconds = now.saturating_sub(self.since).as_secs().max(1);
        (self.since, self.period) = (now, (self.period * 2).min(MAX_PERIOD));
        Some(Suppressed {
            count,
            last: std::mem::take(&mut self.last),
            seconds,
        })
    }
}

/// Formats as `a damaged frame was ignored; and 4811 more like it in the last 2 s`.
impl std::fmt::Display for Suppressed {
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

    /// Returns the lines written if one comes each millisecond for this many seconds.
    fn written(seconds: u64) -> (u64, u64) {
        let mut throttle = Throttle::default();
        let (mut lines, mut summaries) = (0, 0);
        for at in (0..seconds * 1000).map(Duration::from_millis) {
            for held in throttle.take_ended(at) {
                (lines, summaries) = (lines + 1, summaries + held.count);
            }
            if throttle.allows(at, "damaged", "a damaged frame") {
                (lines, summaries) = (lines + 1, summaries + 1);
            }
        }
        let end = Duration::from_secs(seconds);
        let rest = throttle.take_all(end).into_iter().map(|held| held.count);
        (lines, summaries + rest.sum::<u64>())
    }

    #[test]
    fn flood_is_summarised_and_counted() {
        assert_eq!(written(10), (10 + 3, 10_000));
        assert_eq!(written(3600).1, 3_600_000);
        assert!(written(3600).0 < 100);
    }

    #[test]
    fn occasional_lines_are_shown_at_once() {
        let mut throttle = Throttle::default();
        for second in 0..1000 {
            let now = Duration::from_secs(second);
            assert_eq!(throttle.take_ended(now), []);
            assert!(throttle.allows(now, 1, "line"));
        }
    }

    #[test]
    fn after_a_flood_and_some_quiet_lines_are_shown_again() {
        let mut throttle = Throttle::default();
        let at = Duration::from_millis;
        for nth in 0..12 {
            assert_eq!(throttle.allows(at(nth), 1, "line"), nth < 10);
        }
        let [held] = &throttle.take_ended(at(1000))[..] else {
            panic!("one kind")
        };
        assert_eq!(held.to_string(), "line; and 1 more like it in the last 1 s");
        assert!(!throttle.allows(at(1500), 1, "line"), "it goes on");
        assert_eq!(throttle.take_ended(at(3000)).len(), 1);
        assert_eq!(throttle.take_ended(at(9000)), []);
        assert!(throttle.allows(at(9000), 1, "line"));
        assert_eq!(throttle.take_all(at(9001)), []);
    }
}
