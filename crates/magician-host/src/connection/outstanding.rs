use std::collections::VecDeque;

use magician_protocol::{Ctrl, Frame, Row};

use super::{Micros, Ticket};

/// What a reply repeats of its request: id and Ctrl (errata E06), the error bit aside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) id: u8,
    pub(crate) ctrl: Ctrl,
}

impl Key {
    pub(crate) fn of(frame: &Frame<'_>) -> Self {
        Self {
            id: frame.id(),
            ctrl: Ctrl(frame.ctrl().0 & !Ctrl(0).with_error().0),
        }
    }

    /// Of a read of this row.
    pub(super) fn read(row: &Row) -> Self {
        Self {
            id: row.id,
            ctrl: Ctrl::GET,
        }
    }
}

/// A frame that went out and whose reply may still come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Copy {
    pub(crate) key: Key,
    pub(crate) ticket: Ticket,
    pub(crate) at: Micros,
    /// How many queued commands had gone out by then, itself among them.
    pub(crate) order: u64,
}

/// Every frame that went out and whose reply may still come, in the order of sending.
#[derive(Clone, Debug)]
pub(crate) struct Outstanding {
    copies: VecDeque<Copy>,
    ordered: bool,
}

/// More unanswered frames than this and nothing but a stop is sent until some are given up.
const CAPACITY: usize = 256;
/// More than this and no stop either: the line has been dead for a long time.
const STOPS: usize = 4 * CAPACITY;

impl Outstanding {
    pub(crate) fn new(ordered: bool) -> Self {
        Self {
            copies: VecDeque::with_capacity(CAPACITY),
            ordered,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.copies.is_empty()
    }

    pub(crate) fn is_full(&self) -> bool {
        self.copies.len() >= CAPACITY
    }

    pub(crate) fn is_choked(&self) -> bool {
        self.copies.len() >= STOPS
    }

    pub(crate) fn sent(&mut self, copy: Copy) {
        self.copies.push_back(copy);
    }

    /// Whether a reply with this key could belong to a request that is not `waited_for`.
    pub(crate) fn haunted(&self, key: Key, waited_for: impl Fn(Ticket) -> bool) -> bool {
        let mut copies = self.copies.iter();
        copies.any(|copy| copy.key == key && !waited_for(copy.ticket))
    }

    /// Whether a frame with this key is unanswered.
    pub(crate) fn contains(&self, key: Key) -> bool {
        self.copies.iter().any(|copy| copy.key == key)
    }

    /// Whether a copy of this request is unanswered.
    pub(crate) fn awaits(&self, ticket: Ticket) -> bool {
        self.copies.iter().any(|copy| copy.ticket == ticket)
    }

    /// A reply has come: it belongs to the oldest unanswered frame of its key. On an ordered link
    /// no reply to an older frame can come any more. `None` for an unsolicited reply.
    pub(crate) fn answered(&mut self, key: Key) -> Option<Copy> {
        let at = self.copies.iter().position(|copy| copy.key == key)?;
        let copy = self.copies.remove(at);
        if self.ordered {
            self.copies.drain(..at);
        }
        copy
    }

    /// Gives up frames that went out more than `lifetime` ago.
    pub(crate) fn expire(&mut self, now: Micros, lifetime: Micros) {
        self.copies
            .retain(|copy| copy.at.saturating_add(lifetime) > now);
    }

    /// When the oldest frame will be given up.
    pub(crate) fn next_expiry(&self, lifetime: Micros) -> Option<Micros> {
        let oldest = self.copies.iter().map(|copy| copy.at).min()?;
        Some(oldest.saturating_add(lifetime))
    }
}
