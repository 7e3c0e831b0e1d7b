use std::collections::VecDeque;

use magician_protocol::FrameBuf;

use super::cut::Cutter;
use super::event::Chunk;
use crate::connection::Ticket;

/// Most requests of one client that wait at a time.
pub(super) const MOST: usize = 64;
/// Bytes of the shortest frame.
const SHORTEST: usize = 6;

/// A client: what it says, and what it has asked in its order.
#[derive(Debug, Default)]
pub(super) struct Member {
    pub(super) cutter: Cutter,
    pub(super) slots: VecDeque<Slot>,
}

/// Something a client sent, until it is answered or will not be.
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
        /// It overtakes what waits.
        stop: bool,
    },
    /// Passed on as it is, and never answered.
    Foreign(Chunk),
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant)]
pub(super) enum State {
    Waiting,
    /// It is in flight, or one like it is.
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
    /// Bytes it may send.
    pub(super) fn room(&self) -> usize {
        MOST.saturating_sub(self.slots.len()) * SHORTEST
    }

    /// What it waits for that the arm has not been asked yet.
    pub(super) fn next(&self) -> Option<&Slot> {
        self.slots.iter().find(|slot| slot.waits())
    }

    pub(super) fn slot(&mut self, ticket: Ticket) -> Option<&mut Slot> {
        self.slots.iter_mut().find(|slot| slot.ticket == ticket)
    }

    pub(super) fn remove(&mut self, ticket: Ticket) -> Option<Slot> {
        let at = self.slots.iter().position(|slot| slot.ticket == ticket)?;
        self.slots.remove(at)
    }

    /// The latest of its requests that is answered.
    pub(super) fn answered_last(&self) -> Option<Ticket> {
        let answered = |slot: &&Slot| matches!(slot.state, State::Answered { .. });
        self.slots.iter().rfind(answered).map(|slot| slot.ticket)
    }

    pub(super) fn has_reply(&self) -> bool {
        let first = self.slots.front();
        first.is_some_and(|slot| matches!(slot.state, State::Answered { .. }))
    }

    /// The first answer, when nothing that was asked before it is unanswered.
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
