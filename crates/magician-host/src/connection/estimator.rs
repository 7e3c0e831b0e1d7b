use super::{Micros, Settings};

/// Retransmission timeout of a connection, after RFC 6298: the smoothed round trip plus four times its
/// deviation, at least [`Settings::floor`] and at most [`Settings::ceiling`]. Each loss doubles it, an
/// answer ends the doubling; a request that was retransmitted is no sample. A request whose answer did
/// not come in this time is retransmitted until its deadline; a queued command only once it is certain
/// that the controller has not taken it.
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

    /// An answer took `time`.
    pub(crate) fn sample(&mut self, time: Micros) {
        let time = time.min(self.ceiling);
        self.doublings = 0;
        match self.smoothed {
            None => {
                self.smoothed = Some(time);
                self.deviation = time / 2;
            }
            Some(smoothed) => {
                self.deviation = (3 * self.deviation + smoothed.abs_diff(time)) / 4;
                self.smoothed = Some((7 * smoothed + time) / 8);
            }
        }
    }

    /// An answer did not come in time.
    pub(crate) fn back_off(&mut self) {
        self.doublings = (self.doublings + 1).min(16);
    }

    /// The smoothed round trip.
    pub(crate) fn round_trip(&self) -> Option<Micros> {
        self.smoothed
    }

    /// From when on an answer counts as lost.
    pub(crate) fn timeout(&self) -> Micros {
        let timeout = self.first_timeout();
        timeout
            .saturating_mul(1 << self.doublings)
            .min(self.ceiling)
    }

    /// The same without regard to what was lost lately.
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
