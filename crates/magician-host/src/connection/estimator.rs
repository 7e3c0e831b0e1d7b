//! Retransmission timeout after RFC 6298.

use super::{Micros, Settings};

/// Retransmission timeout of a connection, after RFC 6298.
///
/// The timeout is the smoothed round trip plus four times its deviation, between
/// [`Settings::floor`] and [`Settings::ceiling`]. Each loss doubles it and a reply ends the
/// doubling; retransmitted requests are not sampled (Karn's algorithm). An idempotent request
/// without a reply by then is retransmitted until its deadline, a queued command only once it is
/// certain that the controller has not taken it, and any other request never.
#[derive(Clone, Debug)]
pub(crate) struct Estimator {
    smoothed: Option<Micros>,
    deviation: Micros,
    doublings: u32,
    initial: Micros,
    floor: Micros,
    ceiling: Micros,
}

impl Estimator {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            smoothed: None,
            deviation: 0,
            doublings: 0,
            initial: settings.initial_timeout,
            floor: settings.floor,
            ceiling: settings.ceiling.max(settings.floor),
        }
    }

    /// Adds a round-trip time.
    pub(crate) fn sample(&mut self, time: Micros) {
        // A single reply after a long hold-up must not dominate the average.
        let time = time.min(self.ceiling);
        self.doublings = 0;
        match self.smoothed {
            None => {
                // First sample: RFC 6298, 2.2.
                self.smoothed = Some(time);
                self.deviation = time / 2;
            }
            Some(smoothed) => {
                // Gains 1/4 and 1/8: RFC 6298, 2.3.
                self.deviation = (3 * self.deviation + smoothed.abs_diff(time)) / 4;
                self.smoothed = Some((7 * smoothed + time) / 8);
            }
        }
    }

    /// Doubles the timeout after a loss.
    pub(crate) fn back_off(&mut self) {
        // 2^16 exceeds any ceiling; the bound keeps the shift in range.
        self.doublings = (self.doublings + 1).min(16);
    }

    /// Smoothed round-trip time. `None` before the first sample.
    pub(crate) fn round_trip(&self) -> Option<Micros> {
        self.smoothed
    }

    /// Current retransmission timeout, with backoff.
    pub(crate) fn timeout(&self) -> Micros {
        let timeout = self.first_timeout();
        timeout
            .saturating_mul(1 << self.doublings)
            .min(self.ceiling)
    }

    /// Timeout without the backoff for recent losses.
    pub(crate) fn first_timeout(&self) -> Micros {
        let timeout = match self.smoothed {
            Some(smoothed) => smoothed.saturating_add(4 * self.deviation),
            None => self.initial,
        };
        timeout.clamp(self.floor, self.ceiling)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adapts_to_a_slow_link_and_back_within_its_bounds() {
        let settings = Settings::ORDERED;
        let mut estimator = Estimator::new(&settings);
        assert_eq!(estimator.timeout(), settings.initial_timeout);
        for _ in 0..50 {
            estimator.sample(3_000);
        }
        assert_eq!(estimator.timeout(), settings.floor);
        for _ in 0..50 {
            estimator.sample(400_000);
        }
        let slow = estimator.timeout();
        assert!(slow > 400_000 && slow < 600_000, "{slow}");
        estimator.back_off();
        assert_eq!(estimator.timeout(), 2 * slow);
        assert_eq!(estimator.first_timeout(), slow);
        for _ in 0..100 {
            estimator.back_off();
        }
        assert_eq!(estimator.timeout(), settings.ceiling);
        estimator.sample(Micros::MAX);
        assert!(estimator.timeout() <= settings.ceiling);
    }
}
