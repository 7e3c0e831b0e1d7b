//! Events of a proxy, for logs and traces.

use std::fmt;

use magician_protocol::{FrameBuf, MAX_FRAME};

/// Identifies a client of a [`Proxy`](super::Proxy) by a number of the caller's choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Client(pub u32);

/// An event of a [`Proxy`](super::Proxy).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::large_enum_variant)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Event {
    /// A client sent a request.
    Request {
        /// Client that sent it.
        client: Client,
        /// Request.
        frame: FrameBuf,
    },
    /// A client got a reply.
    Reply {
        /// Client that gets it.
        client: Client,
        /// Reply.
        frame: FrameBuf,
        /// True if the reply is cached, or answers a request that another client sent.
        shared: bool,
    },
    /// A request ended without a reply, so the client gets none: the reply was lost or too late, or
    /// the line was lost.
    Unanswered {
        /// Client that sent the request.
        client: Client,
        /// Request.
        frame: FrameBuf,
    },
    /// A request was dropped without being sent to the arm.
    Dropped {
        /// Client that sent it.
        client: Client,
        /// Request.
        frame: FrameBuf,
        /// Reason.
        reason: Reason,
    },
    /// The proxy itself sent a frame: a fence between two requests, or the stop of a jog
    /// without an owner.
    Own {
        /// Frame.
        frame: FrameBuf,
    },
    /// The arm sent a frame that no client waits for, such as a reply that is too late.
    Unclaimed {
        /// Frame.
        frame: FrameBuf,
    },
    /// Bytes outside of any frame arrived.
    Foreign {
        /// Sender; `None` for the arm.
        from: Option<Client>,
        /// Bytes; a long run is split over several events.
        bytes: Chunk,
        /// True if they were passed on.
        passed: bool,
    },
}

/// Reason why a request was not sent to the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The client disconnected.
    Left,
    /// A stop of the same client overtook it.
    Stopped,
    /// The line to the arm is lost.
    NoLine,
    /// The client has too many requests waiting.
    Full,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Left => "its program disconnected",
            Self::Stopped => "a stop overtook it",
            Self::NoLine => "the line to the arm is lost",
            Self::Full => "too many requests wait",
        })
    }
}

/// Up to 254 bytes, without allocation.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Chunk {
    /// Splits bytes into chunks.
    pub(super) fn split(bytes: &[u8]) -> impl Iterator<Item = Self> + '_ {
        bytes.chunks(MAX_FRAME).map(|part| {
            let mut bytes = [0; MAX_FRAME];
            for (to, from) in bytes.iter_mut().zip(part) {
                *to = *from;
            }
            Self {
                bytes,
                length: part.len(),
            }
        })
    }

    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl From<&FrameBuf> for Chunk {
    fn from(frame: &FrameBuf) -> Self {
        // A frame is never larger than a chunk.
        let all = Self::split(frame.bytes()).next();
        all.unwrap_or(Self {
            bytes: [0; MAX_FRAME],
            length: 0,
        })
    }
}

impl fmt::Debug for Chunk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Chunk({:02X?})", self.bytes())
    }
}
