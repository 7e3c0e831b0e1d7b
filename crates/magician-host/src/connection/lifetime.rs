use super::{Micros, Settings};

/// So many times as long as the longest round trip a datagram may be under way.
const MARGIN: u64 = 8;
/// A long round trip counts for at least so long, and at most for twice that.
const MEMORY: Micros = 30_000_000;

/// How long a frame, or the answer to it, may still come after it went out.
///
/// A network does not tell how long it may hold a datagram back. What it shows are round trips: from the longest of the last
/// minute follows, with a margin, when one that has not come will not come any more. Answers that come later than that, or
/// once more, count as round trips too, so that the first one widens the margin for all that follow.
///
/// On an ordered link nothing comes late, and the lifetime only bounds the wait for a dead line.
#[derive(Clone, Debug)]
pub(super) struct Lifetime {
    measures: bool,
    shortest: Micros,
    longest: Micros,
    /// The longest round trip of this spell and of the one before, and when this one began.
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

    /// An answer came so long after its frame had gone out.
    pub(super) fn saw(&mut self, now: Micros, time: Micros) {
        if now.saturating_sub(self.since) >= MEMORY {
            self.peaks = [None, self.peaks[0]];
            self.since = now;
        }
        self.peaks[0] = self.peaks[0].max(Some(time));
    }

    /// From what was measured; `None` on an ordered link, and before the first answer.
    pub(super) fn measured(&self) -> Option<Micros> {
        let [now, before] = self.peaks;
        let peak = now.max(before).filter(|_| self.measures)?;
        let span = peak.saturating_mul(MARGIN);
        Some(span.max(self.shortest).min(self.longest))
    }

    /// How long a frame may be under way.
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
        lifetime.saw(0, 3 * MS);
        assert_eq!(lifetime.get(), 200 * MS, "the shortest");
        lifetime.saw(MS, 60 * MS);
        lifetime.saw(2 * MS, 3 * MS);
        assert_eq!(lifetime.get(), 480 * MS);
        lifetime.saw(3 * MS, 900 * MS);
        assert_eq!(lifetime.get(), 2_000 * MS, "the longest");
    }

    #[test]
    fn a_long_round_trip_is_forgotten_after_a_while() {
        let mut lifetime = Lifetime::new(&Settings::DATAGRAMS);
        lifetime.saw(0, 100 * MS);
        for second in 1..30 {
            lifetime.saw(second * 1_000 * MS, 3 * MS);
            assert_eq!(lifetime.get(), 800 * MS, "after {second} s");
        }
        lifetime.saw(MEMORY, 3 * MS);
        assert_eq!(lifetime.get(), 800 * MS);
        lifetime.saw(2 * MEMORY, 3 * MS);
        assert_eq!(lifetime.get(), 200 * MS);
    }

    #[test]
    fn an_ordered_link_has_the_one_that_was_set() {
        let mut lifetime = Lifetime::new(&Settings::ORDERED);
        lifetime.saw(0, 3 * MS);
        assert_eq!(lifetime.get(), Settings::ORDERED.lifetime);
    }
}
