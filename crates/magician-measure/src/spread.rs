//! Statistics of repeated times.

use std::time::Duration;

/// Times of a repeated action.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    sorted: Vec<Duration>,
}

impl From<Vec<Duration>> for Timings {
    fn from(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        Self { sorted: times }
    }
}

impl Timings {
    /// Returns the number of times.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// Returns a percentile by nearest rank: `percent` % of the times are at most this long; `None`
    /// without times.
    #[must_use]
    pub fn percentile(&self, percent: u8) -> Option<Duration> {
        // Nearest rank: every result is a time that was really measured.
        let rank = (self.sorted.len() * usize::from(percent.min(100))).div_ceil(100);
        self.sorted.get(rank.saturating_sub(1)).copied()
    }

    /// Returns the median.
    #[must_use]
    pub fn p50(&self) -> Option<Duration> {
        self.percentile(50)
    }

    /// Returns the 99th percentile.
    #[must_use]
    pub fn p99(&self) -> Option<Duration> {
        self.percentile(99)
    }

    /// Returns the times minus `much` each, but not below zero.
    #[must_use]
    pub fn less(&self, much: Duration) -> Self {
        let less = self.sorted.iter().map(|time| time.saturating_sub(much));
        Self {
            sorted: less.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let times = (1..=200).rev().map(Duration::from_millis);
        let spread = Timings::from(times.collect::<Vec<_>>());
        let percentile = |percent| spread.percentile(percent).map(|time| time.as_millis());
        assert_eq!(percentile(0), Some(1));
        assert_eq!(percentile(50), Some(100));
        assert_eq!(percentile(99), Some(198));
        assert_eq!(percentile(100), Some(200));
        let less = spread.less(Duration::from_millis(100));
        assert_eq!(less.p50(), Some(Duration::ZERO));
        assert_eq!(Timings::default().p50(), None);
    }
}
