//! Clients of the proxy, with their pending requests.

use std::collections::VecDeque;

use magician_protocol::FrameBuf;

use super::cut::Cutter;
use super::event::Chunk;
use crate::connection::Ticket;

/// Largest number of waiting requests per client.
pub(super) const MOST: usize = 64;
/// Size of the shortest frame, bytes.
const SHORTEST: usize = 6;

/// A client: its byte stream and its requests in order.
#[derive(Debug, Default)]
pub(super) struct Member {
    pub(super) cutter: Cutter,
    pub(super) slots: VecDeque<Slot>,
}

/// Something that a client sent, until it is answered or dropped.
#[derive(Debug)]
pub(super) struct Slot {
    pub(super) ticket: Ticket,
    pub(super) what: What,
    pub(super) state: State,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant)]
pub(super) enum What {
    Request {
        frame: FrameBuf,
        /// True if it overtakes waiting requests.
        stop: bool,
    },
    /// Passed on unchanged, and never answered.
    Foreign(Chunk),
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant)]
pub(super) enum State {
    Waiting,
    /// In flight, or joined to an equal request in flight.
    Asked,
    Answered {
        frame: FrameBuf,
        shared: bool,
    },
}

impl Slot {
    pub(super) fn waits(&self) -> bool {
        matches!(self.state, State::Waiting)
    }

    pub(super) fn is_stop(&self) -> bool {
        matches!(self.what, What::Request { stop: true, .. })
    }
}

impl Member {
    /// Number of bytes that the client may send.
    pub(super) fn room(&self) -> usize {
        // In the worst case each entry is a frame of the shortest size.
        MOST.saturating_sub(self.slots.len()) * SHORTEST
    }

    /// First request that was not sent to the arm yet.
    pub(super) fn next(&self) -> Option<&Slot> {
        self.slots.iter().find(|slot| slot.waits())
    }

    pub(super) fn slot(&mut self, ticket: Ticket) -> Option<&mut Slot> {
        self.slots.iter_mut().find(|slot| slot.ticket == ticket)
    }

    pub(super) fn remove(&mut self, ticket: Ticket) -> Option<Slot> {
        // Not always the first: a stop overtakes earlier requests.
        let at = self.slots.iter().position(|slot| slot.ticket == ticket)?;
        self.slots.remove(at)
    }

    /// Latest answered request.
    pub(super) fn answered_last(&self) -> Option<Ticket> {
        let answered = |slot: &&Slot| matches!(slot.state, State::Answered { .. });
        self.slots.iter().rfind(answered).map(|slot| slot.ticket)
    }

    pub(super) fn has_reply(&self) -> bool {
        let first = self.slots.front();
        first.is_some_and(|slot| matches!(slot.state, State::Answered { .. }))
    }

    /// Removes the first reply, if it is next in the client's order.
    pub(super) fn reply(&mut self) -> Option<(FrameBuf, bool)> {
        match self.slots.front()?.state {
            State::Answered { frame, shared } => {
                self.slots.pop_front();
                Some((frame, shared))
            }
            _ => None,
        }
    }
}
