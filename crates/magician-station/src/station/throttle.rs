//! Rate limit on messages of a client.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;

/// Time above the limit after which the client is closed.
const CLOSE_AFTER: Duration = Duration::from_secs(5);

/// Relation of a message to the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RateVerdict {
    /// Within the limit.
    Accept,
    /// Above the limit: the message is refused.
    Refuse,
    /// Above the limit for too long: the connection is closed.
    Close,
}

/// Sliding window over the messages of a client within one second.
#[derive(Debug, Default)]
pub struct Throttle {
    /// Instants of the last messages.
    messages: VecDeque<HostInstant>,
    over_since: Option<HostInstant>,
}

impl Throttle {
    /// Counts a message, with at most `rate` of them in any second.
    pub fn check(&mut self, now: HostInstant, rate: usize) -> RateVerdict {
        let second = Duration::from_secs(1);
        while self.messages.front().is_some_and(|at| now - *at >= second) {
            self.messages.pop_front();
        }
        if self.messages.len() < rate {
            self.messages.push_back(now);
            // A second within the limit forgives earlier excess.
            self.over_since = self.over_since.filter(|since| now - *since < second);
            return RateVerdict::Accept;
        }
        // Refused messages count as well, so a client that keeps sending stays above the limit.
        self.messages.pop_front();
        self.messages.push_back(now);
        let since = *self.over_since.get_or_insert(now);
        if now - since >= CLOSE_AFTER {
            RateVerdict::Close
        } else {
            RateVerdict::Refuse
        }
    }
}
