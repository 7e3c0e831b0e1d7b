//! How many messages a client may send.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::HostInstant;

/// A client that sends too much for so long is cut off.
const OVER: Duration = Duration::from_secs(5);

/// How a message stands to the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// It is within.
    Fine,
    /// It is refused.
    TooMany,
    /// Too many came for too long: this is the end of the connection.
    Close,
}

/// Counts the messages of a client in any second.
#[derive(Debug, Default)]
pub struct Throttle {
    /// The last messages.
    heard: VecDeque<HostInstant>,
    over_since: Option<HostInstant>,
}

impl Throttle {
    /// Counts a message of no more than `rate` in any second.
    pub fn hears(&mut self, now: HostInstant, rate: usize) -> Pace {
        let second = Duration::from_secs(1);
        while self.heard.front().is_some_and(|at| now - *at >= second) {
            self.heard.pop_front();
        }
        if self.heard.len() < rate {
            self.heard.push_back(now);
            self.over_since = self.over_since.filter(|since| now - *since < second);
            return Pace::Fine;
        }
        // What is refused counts, too: the second goes on.
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
