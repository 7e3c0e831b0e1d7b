//! Clients of the proxy, with their pending requests.

use std::collections::VecDeque;

use magician_protocol::FrameBuf;

use super::cut::Cutter;
use super::event::Chunk;
use crate::connection::Ticket;

/// Largest number of pending requests per client. A stop is accepted up to twice this number.
pub(super) const MAX_PENDING_REQUESTS: usize = 64;
/// Size of the shortest frame, bytes.
const MIN_FRAME_SIZE: usize = 6;

/// A client: its byte stream and its requests in order.
#[derive(Debug, Default)]
pub(super) struct ClientQueue {
    pub(super) cutter: Cutter,
    pub(super) slots: VecDeque<PendingRequest>,
}

/// Something that a client sent, until it is answered or dropped.
#[derive(Debug)]
pub(super) struct PendingRequest {
    pub(super) ticket: Ticket,
    pub(super) what: RequestKind,
    pub(super) state: State,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant)]
pub(super) enum RequestKind {
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

impl PendingRequest {
    pub(super) fn waits(&self) -> bool {
        matches!(self.state, State::Waiting)
    }

    pub(super) fn is_stop(&self) -> bool {
        matches!(self.what, RequestKind::Request { stop: true, .. })
    }
}

impl ClientQueue {
    /// Number of bytes that the client may send.
    pub(super) fn room(&self) -> usize {
        // In the worst case each entry is a frame of the shortest size.
        MAX_PENDING_REQUESTS.saturating_sub(self.slots.len()) * MIN_FRAME_SIZE
    }

    /// First request that was not sent to the arm yet.
    pub(super) fn next(&self) -> Option<&PendingRequest> {
        self.slots.iter().find(|slot| slot.waits())
    }

    pub(super) fn slot(&mut self, ticket: Ticket) -> Option<&mut PendingRequest> {
        self.slots.iter_mut().find(|slot| slot.ticket == ticket)
    }

    pub(super) fn remove(&mut self, ticket: Ticket) -> Option<PendingRequest> {
        // Not always the first: a stop overtakes earlier requests.
        let at = self.slots.iter().position(|slot| slot.ticket == ticket)?;
        self.slots.remove(at)
    }

    /// Latest answered request.
    pub(super) fn answered_last(&self) -> Option<Ticket> {
        let answered = |slot: &&PendingRequest| matches!(slot.state, State::Answered { .. });
        self.slots.iter().rfind(answered).map(|slot| slot.ticket)
    }

    pub(super) fn has_reply(&self) -> bool {
        let first = self.slots.front();
        first.is_some_and(|slot| matches!(slot.state, State::Answered { .. }))
    }

    /// Removes the first request and returns its reply. `None` if it has no reply yet.
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
