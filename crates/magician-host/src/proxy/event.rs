use std::fmt;

use magician_protocol::{FrameBuf, MAX_FRAME};

/// Names a client of a [`Proxy`](super::Proxy), by a number of the caller's choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Client(pub u32);

/// What a [`Proxy`](super::Proxy) has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::large_enum_variant)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Event {
    /// A client asks.
    Request {
        /// The client.
        client: Client,
        /// What.
        frame: FrameBuf,
    },
    /// A client is answered.
    Reply {
        /// The client.
        client: Client,
        /// With what.
        frame: FrameBuf,
        /// Whether another client asked the arm.
        shared: bool,
    },
    /// The arm did not answer in time; neither does the proxy.
    Unanswered {
        /// The client that asked.
        client: Client,
        /// What.
        frame: FrameBuf,
    },
    /// A request that did not go to the arm and will not.
    Dropped {
        /// The client that asked.
        client: Client,
        /// What.
        frame: FrameBuf,
        /// Why.
        reason: Reason,
    },
    /// The proxy itself says something to the arm: a fence between two requests, or the end of a
    /// jog without an owner.
    Own {
        /// What.
        frame: FrameBuf,
    },
    /// The arm sent something unsolicited, such as a reply that is too late.
    Unclaimed {
        /// What.
        frame: FrameBuf,
    },
    /// Bytes that are part of no frame.
    Foreign {
        /// The sender; `None`: the arm.
        from: Option<Client>,
        /// The bytes; a long run comes in several.
        bytes: Chunk,
        /// Whether they were passed on.
        passed: bool,
    },
}

/// Why a request did not go to the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Its client left.
    Left,
    /// A stop of the same client overtook it.
    Stopped,
    /// There is no line to the arm.
    NoLine,
    /// Its client has too many requests waiting.
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

/// Up to 254 bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Chunk {
    /// The bytes in pieces of a chunk's size.
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
