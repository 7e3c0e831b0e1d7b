//! Counters of events that end, or may change, the motion started over a connection. They only
//! grow, so a caller detects an event by comparing two values.

use std::sync::atomic::{AtomicU64, Ordering};

#[derive(Debug, Default)]
pub(super) struct Disruptions {
    stops: AtomicU64,
    clears: AtomicU64,
    doubts: AtomicU64,
    departures: AtomicU64,
}

impl Disruptions {
    /// Counts a stop, which ends all work begun before it. Returns its number.
    pub(super) fn stop(&self) -> u64 {
        1 + self.stops.fetch_add(1, Ordering::SeqCst)
    }

    /// Returns the number of stops so far.
    pub(super) fn stops(&self) -> u64 {
        self.stops.load(Ordering::SeqCst)
    }

    /// Counts a clear of the queue on a reconnected line, where the laser may have burnt.
    pub(super) fn clear(&self) {
        self.clears.fetch_add(1, Ordering::SeqCst);
    }

    /// Returns the number of clears so far.
    pub(super) fn clears(&self) -> u64 {
        self.clears.load(Ordering::SeqCst)
    }

    /// Counts a queued command that the arm may or may not have accepted.
    pub(super) fn doubt(&self) {
        self.doubts.fetch_add(1, Ordering::SeqCst);
    }

    /// Returns the number of uncertain commands so far.
    pub(super) fn doubts(&self) -> u64 {
        self.doubts.load(Ordering::SeqCst)
    }

    /// Counts an event after which the arm may have left the predicted path of the fence.
    pub(super) fn depart(&self) {
        self.departures.fetch_add(1, Ordering::SeqCst);
    }

    /// Returns the number of events up to now that may have changed the path.
    pub(super) fn total(&self) -> u64 {
        [&self.stops, &self.clears, &self.doubts, &self.departures]
            .into_iter()
            // Only equality matters, so a wrap-around is harmless.
            .fold(0, |sum, count| {
                sum.wrapping_add(count.load(Ordering::SeqCst))
            })
    }
}
