//! How much a station holds, for tests that it does not grow.

use super::Station;

/// What a station holds at present.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationSize {
    /// Sockets.
    pub sockets: usize,
    /// Sessions, also those without a socket.
    pub sessions: usize,
    /// Requests that are not answered.
    pub pending: usize,
    /// Jogs that are known by their ids.
    pub jogs: usize,
    /// Subscriptions of all sockets.
    pub subscriptions: usize,
    /// Bytes of answers and notifications that wait to be sent.
    pub unsent: usize,
    /// Events that are kept of all arms.
    pub events: usize,
    /// Orders that the arms have not been given, and what waits for its turn beside them.
    pub orders: usize,
}

impl Station {
    /// What it holds at present.
    #[doc(hidden)]
    #[must_use]
    pub fn size(&self) -> StationSize {
        let sockets = self.sockets.values();
        StationSize {
            sockets: self.sockets.len(),
            sessions: self.sessions.len(),
            pending: self.pending.len(),
            jogs: self.jogs.len(),
            subscriptions: { sockets.clone() }
                .map(|socket| socket.subscriptions.len())
                .sum(),
            unsent: sockets.map(|socket| socket.outbox.unsent()).sum(),
            events: self.arms.iter().map(|arm| arm.events.len()).sum(),
            orders: self.orders.len() + self.library.len() + self.lengthy.len(),
        }
    }
}
