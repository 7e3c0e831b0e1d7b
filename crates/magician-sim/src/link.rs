//! The peers of the controller, a decoder and the replies that wait each, and the cable between.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::{Deframer, Frame, FrameBuf, MAX_FRAME};

/// Names a peer: a pseudo-terminal, the sender of datagrams, a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);

/// The cable between the arm and its host, for the code that carries the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineState {
    /// Whether it is plugged in.
    pub plugged: bool,
    /// How often it has been pulled.
    pub pulls: u64,
    /// How much longer than usual answers take.
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

/// One peer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Link {
    pub(crate) deframer: Deframer,
    pub(crate) outbox: Outbox,
}

/// Replies of one peer that wait to be taken, oldest first, as bytes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outbox {
    bytes: VecDeque<u8>,
}

impl Outbox {
    /// Most bytes that wait: the answers to 5000 bytes of the costliest request, GetPose.
    const CAPACITY: usize = 32 * 1024;

    /// Whether the longest reply still fits.
    pub(crate) fn has_room(&self) -> bool {
        self.bytes.len() + MAX_FRAME <= Self::CAPACITY
    }

    pub(crate) fn push(&mut self, reply: &FrameBuf) {
        self.bytes.extend(reply.bytes());
    }

    pub(crate) fn pop(&mut self) -> Option<FrameBuf> {
        let length = usize::from(*self.bytes.get(2)?) + 4;
        let mut whole = [0; MAX_FRAME];
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

/// The peers that have been heard.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links {
    links: Vec<Known>,
    /// Counts what was heard; a peer's count says how long ago it spoke.
    clock: u64,
}

#[derive(Clone, Debug)]
struct Known {
    id: LinkId,
    heard: u64,
    link: Link,
}

impl Links {
    /// Most peers at a time. One more pushes out the one that has been silent longest: senders of
    /// datagrams come and go without a word.
    const CAPACITY: usize = 64;

    /// The peer of this name, as the one heard last.
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
            self.links.swap_remove(at);
        }
    }

    pub(crate) fn clear(&mut self) {
        self.links.clear();
    }

    fn position(&self, id: LinkId) -> Option<usize> {
        self.links.iter().position(|known| known.id == id)
    }

    /// Makes room for a new peer; its position.
    fn admit(&mut self, id: LinkId) -> usize {
        if self.links.len() >= Self::CAPACITY {
            let silent = (self.links.iter().enumerate()).min_by_key(|(_, known)| known.heard);
            if let Some((at, _)) = silent {
                self.links.swap_remove(at);
            }
        }
        self.links.push(Known {
            id,
            heard: self.clock,
            link: Link::default(),
        });
        self.links.len() - 1
    }
}
