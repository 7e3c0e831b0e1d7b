//! Rate limit on messages of a client.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;

/// Time above the limit after which the client is closed.
const OVER: Duration = Duration::from_secs(5);

/// Relation of a message to the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Within the limit.
    Fine,
    /// Above the limit: the message is refused.
    TooMany,
    /// Above the limit for too long: the connection is closed.
    Close,
}

/// Sliding window over the messages of a client within one second.
#[derive(Debug, Default)]
pub struct Throttle {
    /// Instants of the last messages.
    heard: VecDeque<HostInstant>,
    over_since: Option<HostInstant>,
}

impl Throttle {
    /// Counts a message, with at most `rate` of them in any second.
    pub fn hears(&mut self, now: HostInstant, rate: usize) -> Pace {
        let second = Duration::from_secs(1);
        while self.heard.front().is_some_and(|at| now - *at >= second) {
            self.heard.pop_front();
        }
        if self.heard.len() < rate {
            self.heard.push_back(now);
            // A second within the limit forgives earlier excess.
            self.over_since = self.over_since.filter(|since| now - *since < second);
            return Pace::Fine;
        }
        // Refused messages count as well, so a client that keeps sending stays above the limit.
        self.heard.pop_front();
        self.heard.push_back(now);
        let since = *self.over_since.get_or_insert(now);
        if now - since >= OVER {
            Pace::Close
        } else {
            Pace::TooMany
        }
    }
}
