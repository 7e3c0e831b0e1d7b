//! Detection of resets by the controller's clock.

use super::Micros;

/// Smallest share of the expected progress that shows no reset, per mille. The error of crystals is
/// far below the remaining 5 %.
const MIN_PROGRESS_PER_MILLE: u64 = 950;
/// Additional tolerance for delays of requests and replies, us.
const PROGRESS_TOLERANCE: Micros = 50_000;
/// Least distance between readings from which the clock's rate is measured, us.
const MIN_BASELINE: Micros = 1_000_000;
/// Slowest rate assumed before it was measured, per mille: a virtual arm may be slowed down.
const MIN_RATE_PER_MILLE: u64 = 60;

/// Observes the controller's clock, which starts at 0 at power-up (document 1.3.5).
///
/// It counts milliseconds in 32 bits and wraps after 49.7 days. A reset shows as a value too low
/// for the time that has passed.
#[derive(Clone, Debug, Default)]
pub(super) struct Uptime {
    reading: Option<Reading>,
    /// Slowest rate seen, per mille of the host's time.
    rate: Option<u64>,
    /// True if a single reading was behind and not yet believed.
    suspect: bool,
    /// True if the clock does not follow the host's time.
    independent: bool,
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    asked: Micros,
    heard: Micros,
    value: u32,
}

impl Uptime {
    /// Creates an observer. `independent` is true if the clock does not keep pace with the host's.
    pub(super) fn new(independent: bool) -> Self {
        Self {
            independent,
            ..Self::default()
        }
    }

    /// Processes a reading requested at `asked` and received at `heard`. True if it shows a reset.
    ///
    /// On an unordered link a single reading may have been delayed and proves nothing.
    pub(super) fn read(&mut self, value: u32, asked: Micros, heard: Micros, ordered: bool) -> bool {
        let new = Reading {
            asked,
            heard,
            value,
        };
        let Some(before) = self.reading else {
            self.reading = Some(new);
            return false;
        };
        let behind = self.is_behind(before, new);
        if behind && !ordered && !self.suspect {
            self.suspect = true;
            return false;
        }
        if !behind {
            self.learn(before, new);
        }
        self.suspect = false;
        self.reading = Some(new);
        behind
    }

    /// True if the next reading can show a reset.
    pub(super) fn is_known(&self) -> bool {
        self.reading.is_some()
    }

    /// Discards the readings after a known reset.
    pub(super) fn forget(&mut self) {
        self.reading = None;
    }

    fn is_behind(&self, before: Reading, new: Reading) -> bool {
        let least = new.asked.saturating_sub(before.heard);
        let most = new.heard.saturating_sub(before.asked);
        // After half a wrap a lower value no longer means anything.
        if most / 1000 >= u64::from(u32::MAX / 2) {
            return false;
        }
        let passed = new.value.wrapping_sub(before.value);
        // More than half of the range is a step back.
        if passed > u32::MAX / 2 || self.independent {
            return passed > u32::MAX / 2;
        }
        let expected = (least / 1000).saturating_mul(self.rate.unwrap_or(MIN_RATE_PER_MILLE))
            * MIN_PROGRESS_PER_MILLE
            / 1000;
        u64::from(passed) * 1000 + PROGRESS_TOLERANCE < expected
    }

    fn learn(&mut self, before: Reading, new: Reading) {
        let span = new.heard.saturating_sub(before.asked);
        // Over a short span the delay of the readings would dominate the rate.
        if span < MIN_BASELINE {
            return;
        }
        let passed = u64::from(new.value.wrapping_sub(before.value));
        // At most the host's rate: a clock that runs fast must not make a normal one look slow.
        let rate = (passed * 1_000_000 / span).min(1000);
        // The slowest rate counts, because the speed of a virtual arm may change.
        self.rate = Some(self.rate.map_or(rate, |slowest| slowest.min(rate)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: Micros = 86_400_000_000;

    fn after(readings: &[(Micros, u32)], ordered: bool) -> Vec<bool> {
        let mut uptime = Uptime::default();
        (readings.iter())
            .map(|(at, value)| uptime.read(*value, *at, at + 3_000, ordered))
            .collect()
    }

    #[test]
    fn clock_that_goes_back_or_falls_behind_shows_a_reset() {
        let back = [(0, 90_000), (2_000_000, 1_500)];
        assert_eq!(after(&back, true), [false, true]);
        let behind = [(0, 1_000), (5_000_000, 6_000), (3_600_000_000, 20_000)];
        assert_eq!(after(&behind, true), [false, false, true]);
        let twice = [(0, 1_000), (3_600_000_000, 20_000)];
        assert_eq!(after(&twice, true), [false, true], "with no rate measured");
    }

    #[test]
    fn clock_that_wraps_is_no_reset() {
        let end = u32::MAX - 900;
        let over = [(0, end), (2_000_000, end.wrapping_add(2_000))];
        assert_eq!(after(&over, true), [false, false]);
        let days = 30 * DAY;
        let long = [(0, end), (days, end.wrapping_add((days / 1000) as u32))];
        assert_eq!(after(&long, true), [false, false]);
    }

    #[test]
    fn a_clock_that_runs_slower_or_faster_or_drifts_is_no_reset() {
        for per_mille in [100, 500, 990, 1_000, 1_010, 20_000] {
            let readings: Vec<_> = (0..100)
                .map(|second: u64| (second * 2_000_000, (second * 2 * per_mille) as u32))
                .collect();
            assert!(!after(&readings, true).contains(&true), "{per_mille}");
        }
    }

    #[test]
    fn independent_clock_shows_a_reset_only_by_going_back() {
        let mut uptime = Uptime::new(true);
        let mut reads = |at, value| uptime.read(value, at, at, true);
        assert!(!reads(0, 1_000));
        assert!(!reads(DAY, 1_000));
        assert!(!reads(DAY, 900_000));
        assert!(!reads(2 * DAY, 900_001));
        assert!(reads(2 * DAY, 10));
    }

    #[test]
    fn a_reading_held_up_by_an_unordered_link_is_no_reset() {
        let held = [(0, 9_000), (1_000_000, 8_000), (2_000_000, 11_000)];
        assert_eq!(after(&held, false), [false, false, false]);
        let reset = [(0, 9_000), (1_000_000, 100), (2_000_000, 1_100)];
        assert_eq!(after(&reset, false), [false, false, true]);
    }
}
