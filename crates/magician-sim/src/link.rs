//! Peers of the controller, each with a decoder and pending replies, and the state of the cable.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::{Deframer, Frame, FrameBuf, MAX_FRAME};

/// Identifies a peer: a pseudo-terminal, a sender of datagrams, or a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);

/// The cable between arm and host, as seen by the code that carries the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineState {
    /// True if it is plugged in.
    pub plugged: bool,
    /// Number of times that it was pulled.
    pub pulls: u64,
    /// Additional delay of answers.
    pub delay: Duration,
}

impl Default for LineState {
    fn default() -> Self {
        Self {
            plugged: true,
            pulls: 0,
            delay: Duration::ZERO,
        }
    }
}

/// Decoder and pending replies of one peer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Link {
    pub(crate) deframer: Deframer,
    pub(crate) outbox: Outbox,
}

/// Pending replies of one peer, oldest first, as bytes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outbox {
    bytes: VecDeque<u8>,
}

impl Outbox {
    /// Most pending bytes: the replies to 5000 bytes of GetPose requests. A serial driver buffers
    /// only 4096 bytes, so a host that polls poses over a serial line cannot overrun it. Many reads
    /// of a long text (name, SSID) at once can.
    const CAPACITY: usize = 32 * 1024;

    /// True if the longest reply still fits.
    pub(crate) fn has_room(&self) -> bool {
        self.bytes.len() + MAX_FRAME <= Self::CAPACITY
    }

    pub(crate) fn push(&mut self, reply: &FrameBuf) {
        self.bytes.extend(reply.bytes());
    }

    pub(crate) fn pop(&mut self) -> Option<FrameBuf> {
        // Len counts id, Ctrl and parameters; header, Len and checksum add 4 bytes (E01).
        let length = usize::from(*self.bytes.get(2)?) + 4;
        let mut whole = [0; MAX_FRAME];
        // A reply may wrap around the end of the ring buffer.
        let (front, back) = self.bytes.as_slices();
        let (head, tail) = whole
            .get_mut(..length)?
            .split_at_mut(length.min(front.len()));
        head.copy_from_slice(front.get(..head.len())?);
        tail.copy_from_slice(back.get(..tail.len())?);
        self.bytes.drain(..length);
        Frame::new(whole.get(..length)?).map(FrameBuf::from)
    }
}

/// Known peers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links {
    links: Vec<LinkEntry>,
    /// Counter of received chunks; the value stored with a peer is that of its last chunk.
    clock: u64,
}

#[derive(Clone, Debug)]
struct LinkEntry {
    id: LinkId,
    heard: u64,
    link: Link,
}

impl Links {
    /// Most peers at a time. A further peer evicts the one that was silent for longest, because
    /// senders of datagrams never close.
    const CAPACITY: usize = 64;

    /// Returns the peer, admitted if necessary, and marks it as heard last.
    pub(crate) fn heard(&mut self, id: LinkId) -> &mut Link {
        self.clock += 1;
        let at = match self.position(id) {
            Some(at) => at,
            None => self.admit(id),
        };
        let known = &mut self.links[at];
        known.heard = self.clock;
        &mut known.link
    }

    pub(crate) fn known(&mut self, id: LinkId) -> Option<&mut Link> {
        let at = self.position(id)?;
        self.links.get_mut(at).map(|known| &mut known.link)
    }

    pub(crate) fn close(&mut self, id: LinkId) {
        if let Some(at) = self.position(id) {
            // The order is irrelevant: links are found by their id.
            self.links.swap_remove(at);
        }
    }

    pub(crate) fn clear(&mut self) {
        self.links.clear();
    }

    fn position(&self, id: LinkId) -> Option<usize> {
        self.links.iter().position(|known| known.id == id)
    }

    /// Admits a new peer and returns its position.
    fn admit(&mut self, id: LinkId) -> usize {
        if self.links.len() >= Self::CAPACITY {
            let silent = (self.links.iter().enumerate()).min_by_key(|(_, known)| known.heard);
            if let Some((at, _)) = silent {
                self.links.swap_remove(at);
            }
        }
        self.links.push(LinkEntry {
            id,
            heard: self.clock,
            link: Link::default(),
        });
        self.links.len() - 1
    }
}
