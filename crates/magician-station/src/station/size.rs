//! Sizes of a station's state, for tests of bounded memory.

use super::Station;

/// Current sizes of a station's state.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationSize {
    /// Open sockets.
    pub sockets: usize,
    /// Sessions, including those without a socket.
    pub sessions: usize,
    /// Requests without an answer.
    pub pending: usize,
    /// Jogs remembered by id.
    pub jogs: usize,
    /// Subscriptions over all sockets.
    pub subscriptions: usize,
    /// Bytes of unsent answers and notifications.
    pub unsent: usize,
    /// Events in the logs of all arms.
    pub events: usize,
    /// Orders not handed to arms, and requests that wait for their turn.
    pub orders: usize,
}

impl Station {
    /// Returns the current sizes.
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
            orders: self.orders.len() + self.library.len() + self.long_requests.len(),
        }
    }
}
