//! Rate limit for log lines that remote peers can cause: a few of each kind are shown, the rest is
//! counted.
//!
//! A peer that sends garbage could otherwise fill the log of a station at the speed of its line.
//! Each kind of line has a budget. Once that is used up, further lines are suppressed, and a
//! summary replaces them at the end of each period. Each period is twice as long as the one before.
//! A period without suppressed lines renews the budget.

use std::collections::HashMap;
use std::hash::Hash;
use std::time::Duration;

/// Budget of each kind: lines shown before suppression starts. A choice.
const LINE_BUDGET: u32 = 10;
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
    period_start: Duration,
    period: Duration,
    /// Lines that may still be shown before suppression starts.
    budget: u32,
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
    /// Time from the start of the period to the summary, s; at least 1.
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
        if flood.budget > 0 {
            flood.budget -= 1;
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
            if now.saturating_sub(flood.period_start) < flood.period {
                return true;
            }
            summaries.extend(flood.end_period(now));
            // A kind without suppressed lines in a whole period is forgotten: it gets a new budget.
            flood.budget == 0 && flood.period_start == now
        });
        summaries
    }

    /// Returns summaries of everything suppressed so far, for the end of the program.
    pub(crate) fn take_all(&mut self, now: Duration) -> Vec<Suppressed> {
        let floods = self.kinds.values_mut();
        floods.filter_map(|flood| flood.end_period(now)).collect()
    }
}

impl Flood {
    fn starting_at(now: Duration) -> Self {
        Self {
            period_start: now,
            period: FIRST_PERIOD,
            budget: LINE_BUDGET,
            suppressed: 0,
            last: String::new(),
        }
    }

    /// Returns the summary of this period and begins the next one. Returns `None`, without a new
    /// period, if nothing was suppressed.
    fn end_period(&mut self, now: Duration) -> Option<Suppressed> {
        let count = std::mem::take(&mut self.suppressed);
        if count == 0 {
            return None;
        }
        let seconds = now.saturating_sub(self.period_start).as_secs().max(1);
        (self.period_start, self.period) = (now, (self.period * 2).min(MAX_PERIOD));
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

    /// Sends one line each millisecond for this many seconds. Returns the number of lines written
    /// to the log, summaries included, and the number of sent lines that these account for.
    fn run_flood(seconds: u64) -> (u64, u64) {
        let mut throttle = Throttle::default();
        let (mut lines, mut accounted) = (0, 0);
        for at in (0..seconds * 1000).map(Duration::from_millis) {
            for summary in throttle.take_ended(at) {
                (lines, accounted) = (lines + 1, accounted + summary.count);
            }
            if throttle.allows(at, "damaged", "a damaged frame") {
                (lines, accounted) = (lines + 1, accounted + 1);
            }
        }
        let end = Duration::from_secs(seconds);
        let rest = throttle
            .take_all(end)
            .into_iter()
            .map(|summary| summary.count);
        (lines, accounted + rest.sum::<u64>())
    }

    #[test]
    fn flood_is_summarised_and_counted() {
        assert_eq!(run_flood(10), (10 + 3, 10_000));
        assert_eq!(run_flood(3600).1, 3_600_000);
        assert!(run_flood(3600).0 < 100);
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
    fn lines_are_shown_again_after_a_flood_and_a_quiet_period() {
        let mut throttle = Throttle::default();
        let at = Duration::from_millis;
        for nth in 0..12 {
            assert_eq!(throttle.allows(at(nth), 1, "line"), nth < 10);
        }
        let [summary] = &throttle.take_ended(at(1000))[..] else {
            panic!("one kind")
        };
        assert_eq!(
            summary.to_string(),
            "line; and 1 more like it in the last 1 s"
        );
        assert!(!throttle.allows(at(1500), 1, "line"), "it goes on");
        assert_eq!(throttle.take_ended(at(3000)).len(), 1);
        assert_eq!(throttle.take_ended(at(9000)), []);
        assert!(throttle.allows(at(9000), 1, "line"));
        assert_eq!(throttle.take_all(at(9001)), []);
    }
}
