//! Counts of what ends, or may change, what was set going over a connection. Each of them only grows.

use std::sync::atomic::{AtomicU64, Ordering};

#[derive(Debug, Default)]
pub(super) struct Disruptions {
    stops: AtomicU64,
    clears: AtomicU64,
    doubts: AtomicU64,
    departures: AtomicU64,
}

impl Disruptions {
    /// A stop ends what was begun before it. Returns the number of the stop.
    pub(super) fn stop(&self) -> u64 {
        1 + self.stops.fetch_add(1, Ordering::SeqCst)
    }

    /// Stops so far.
    pub(super) fn stops(&self) -> u64 {
        self.stops.load(Ordering::SeqCst)
    }

    /// The queue was emptied on a line that was found again, because the laser may have burnt.
    pub(super) fn clear(&self) {
        self.clears.fetch_add(1, Ordering::SeqCst);
    }

    /// Such clears so far.
    pub(super) fn clears(&self) -> u64 {
        self.clears.load(Ordering::SeqCst)
    }

    /// The arm may or may not have taken a queued command.
    pub(super) fn doubt(&self) {
        self.doubts.fetch_add(1, Ordering::SeqCst);
    }

    /// Such commands so far.
    pub(super) fn doubts(&self) -> u64 {
        self.doubts.load(Ordering::SeqCst)
    }

    /// The arm departs from what the fence has followed.
    pub(super) fn depart(&self) {
        self.departures.fetch_add(1, Ordering::SeqCst);
    }

    /// Number of times that what was followed may have gone another way.
    pub(super) fn total(&self) -> u64 {
        [&self.stops, &self.clears, &self.doubts, &self.departures]
            .into_iter()
            .fold(0, |sum, count| {
                sum.wrapping_add(count.load(Ordering::SeqCst))
            })
    }
}
