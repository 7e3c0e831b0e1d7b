//! Lifetime of datagrams, measured from round trips.

use super::{Micros, Settings};

/// Lifetime as a multiple of the longest round trip.
// A choice between safety and the wait after a loss.
const MARGIN: u64 = 8;
/// Memory of long round trips, us: each counts for one to two times this long.
// A choice: remembers a bad spell of the network, and forgets it once it is over.
const MEMORY: Micros = 30_000_000;

/// Longest time after the sending of a frame at which it or its reply may still arrive.
///
/// A network does not say how long it may delay a datagram, but it shows round trips. The longest
/// of the last minute, times a margin, is taken as the time after which nothing arrives. Replies
/// later than that, and duplicates, count as round trips as well, so the first one widens the
/// margin for all that follow.
///
/// On an ordered link nothing arrives late, and the lifetime only bounds the wait for a dead line.
#[derive(Clone, Debug)]
pub(super) struct Lifetime {
    measures: bool,
    shortest: Micros,
    longest: Micros,
    /// Longest round trips of the current and the previous interval of [`MEMORY`].
    peaks: [Option<Micros>; 2],
    since: Micros,
}

impl Lifetime {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            measures: !settings.ordered,
            shortest: settings.shortest.min(settings.lifetime),
            longest: settings.lifetime,
            peaks: [None; 2],
            since: 0,
        }
    }

    /// Adds the time between a frame and its reply.
    pub(super) fn add_round_trip(&mut self, now: Micros, time: Micros) {
        if now.saturating_sub(self.since) >= MEMORY {
            // Two intervals, so that each peak is remembered for at least one.
            self.peaks = [None, self.peaks[0]];
            self.since = now;
        }
        self.peaks[0] = self.peaks[0].max(Some(time));
    }

    /// Lifetime from measured round trips. `None` on an ordered link, and before the first reply.
    pub(super) fn measured(&self) -> Option<Micros> {
        let [now, before] = self.peaks;
        let peak = now.max(before).filter(|_| self.measures)?;
        let span = peak.saturating_mul(MARGIN);
        Some(span.max(self.shortest).min(self.longest))
    }

    /// Lifetime in force.
    pub(super) fn get(&self) -> Micros {
        self.measured().unwrap_or(self.longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Micros = 1_000;

    #[test]
    fn it_follows_the_longest_round_trip_between_its_bounds() {
        let mut lifetime = Lifetime::new(&Settings::DATAGRAMS);
        assert_eq!(lifetime.measured(), None);
        assert_eq!(lifetime.get(), 2_000 * MS, "nothing is known");
        lifetime.add_round_trip(0, 3 * MS);
        assert_eq!(lifetime.get(), 200 * MS, "the shortest");
        lifetime.add_round_trip(MS, 60 * MS);
        lifetime.add_round_trip(2 * MS, 3 * MS);
        assert_eq!(lifetime.get(), 480 * MS);
        lifetime.add_round_trip(3 * MS, 900 * MS);
        assert_eq!(lifetime.get(), 2_000 * MS, "the longest");
    }

    #[test]
    fn a_long_round_trip_is_forgotten_after_a_while() {
        let mut lifetime = Lifetime::new(&Settings::DATAGRAMS);
        lifetime.add_round_trip(0, 100 * MS);
        for second in 1..30 {
            lifetime.add_round_trip(second * 1_000 * MS, 3 * MS);
            assert_eq!(lifetime.get(), 800 * MS, "after {second} s");
        }
        lifetime.add_round_trip(MEMORY, 3 * MS);
        assert_eq!(lifetime.get(), 800 * MS);
        lifetime.add_round_trip(2 * MEMORY, 3 * MS);
        assert_eq!(lifetime.get(), 200 * MS);
    }

    #[test]
    fn an_ordered_link_has_the_one_that_was_set() {
        let mut lifetime = Lifetime::new(&Settings::ORDERED);
        lifetime.add_round_trip(0, 3 * MS);
        assert_eq!(lifetime.get(), Settings::ORDERED.lifetime);
    }
}
