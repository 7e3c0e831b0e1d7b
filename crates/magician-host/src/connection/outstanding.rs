//! Frames whose reply may still arrive: the basis of rules 1 to 4 in the head of
//! [`connection`](super).

use std::collections::VecDeque;

use magician_protocol::{Ctrl, Frame, Row};

use super::{Micros, Ticket};

/// Part of a request that its reply repeats: id and Ctrl (errata E06), without the error bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) id: u8,
    pub(crate) ctrl: Ctrl,
}

impl Key {
    pub(crate) fn of(frame: &Frame<'_>) -> Self {
        Self {
            id: frame.id(),
            // The controller sets the error bit in its reply (errata E05), so it is not part of the
            // key.
            ctrl: Ctrl(frame.ctrl().0 & !Ctrl(0).with_error().0),
        }
    }

    /// Key of a read of this row.
    pub(super) fn read(row: &Row) -> Self {
        Self {
            id: row.id,
            ctrl: Ctrl::GET,
        }
    }
}

/// A transmitted frame whose reply may still arrive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SentFrame {
    pub(crate) key: Key,
    pub(crate) ticket: Ticket,
    pub(crate) at: Micros,
    /// Number of queued commands sent up to and including it.
    pub(crate) order: u64,
}

/// All transmitted frames whose reply may still arrive, in the order of sending.
#[derive(Clone, Debug)]
pub(crate) struct Outstanding {
    copies: VecDeque<SentFrame>,
    ordered: bool,
}

/// Outstanding frames above which only stops are sent.
// A choice that bounds memory on a dead line.
const CAPACITY: usize = 256;
/// Outstanding frames above which not even stops are sent: the line has been dead for long.
const STOP_CAPACITY: usize = 4 * CAPACITY;

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
        self.copies.len() >= STOP_CAPACITY
    }

    pub(crate) fn sent(&mut self, copy: SentFrame) {
        self.copies.push_back(copy);
    }

    /// True if a reply with this key could belong to a request outside of `waited_for`.
    pub(crate) fn has_abandoned(&self, key: Key, waited_for: impl Fn(Ticket) -> bool) -> bool {
        let mut copies = self.copies.iter();
        copies.any(|copy| copy.key == key && !waited_for(copy.ticket))
    }

    /// True if a frame with this key is outstanding.
    pub(crate) fn contains(&self, key: Key) -> bool {
        self.copies.iter().any(|copy| copy.key == key)
    }

    /// True if a copy of this request is outstanding.
    pub(crate) fn awaits(&self, ticket: Ticket) -> bool {
        self.copies.iter().any(|copy| copy.ticket == ticket)
    }

    /// Assigns a reply to the oldest outstanding frame of its key. `None` for an unsolicited reply.
    ///
    /// On an ordered link this also drops all older frames, whose replies can no longer arrive.
    pub(crate) fn answered(&mut self, key: Key) -> Option<SentFrame> {
        let at = self.copies.iter().position(|copy| copy.key == key)?;
        let copy = self.copies.remove(at);
        if self.ordered {
            // Rule 3: the controller answers in order, so older frames stay unanswered.
            self.copies.drain(..at);
        }
        copy
    }

    /// Drops frames that were sent more than `lifetime` ago.
    pub(crate) fn expire(&mut self, now: Micros, lifetime: Micros) {
        self.copies
            .retain(|copy| copy.at.saturating_add(lifetime) > now);
    }

    /// Instant at which the oldest frame will be dropped. `None` without outstanding frames.
    pub(crate) fn next_expiry(&self, lifetime: Micros) -> Option<Micros> {
        let oldest = self.copies.iter().map(|copy| copy.at).min()?;
        Some(oldest.saturating_add(lifetime))
    }
}
