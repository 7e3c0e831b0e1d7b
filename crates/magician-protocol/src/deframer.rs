use core::fmt;

use crate::Row;
use crate::frame::{Ctrl, Frame, MAX_LEN, checksum};

const CAPACITY: usize = 472;
/// Bytes of the shortest frame.
const SHORTEST: usize = 6;
/// Additions that the search for swallowed frames may cost a candidate; with the candidate's own
/// sum it keeps the worst input, a run of 0xAA, under 256 additions a byte.
const SEARCH: usize = 80;

/// Why a frame candidate (two header bytes and what follows) was given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// The checksum byte is not the one the bytes call for.
    Checksum {
        /// What the bytes call for.
        expected: u8,
        /// What stood there.
        found: u8,
    },
    /// Len is below 2 or above 250 (errata E03); or it fits no form of the command and takes in
    /// whole frames, which is what a damaged Len does when the sum happens to be right.
    Length(u8),
    /// The line fell silent, or the input ended, inside the frame.
    Truncated,
}

impl Rejection {
    /// It in a word: `checksum`, `length`, `truncated`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Checksum { .. } => "checksum",
            Self::Length(_) => "length",
            Self::Truncated => "truncated",
        }
    }
}

/// With `#` it does not repeat the [name](Self::name).
impl fmt::Display for Rejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !f.alternate() && *self != Self::Truncated {
            write!(f, "{} ", self.name())?;
        }
        match self {
            Self::Checksum { expected, found } => {
                write!(f, "is {found:02X}, expected {expected:02X}")
            }
            Self::Length(len) => write!(f, "is {len}, a frame has 2 to 250"),
            Self::Truncated => f.write_str("the input ends inside the frame"),
        }
    }
}

/// What a [`Deframer`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// A whole frame.
    Frame {
        /// Position of its first byte in the stream.
        offset: u64,
        /// The frame.
        frame: Frame<'a>,
    },
    /// A candidate that was given up; the search goes on from its second byte.
    Rejected {
        /// Position of its first byte in the stream.
        offset: u64,
        /// The candidate's bytes as far as they were there.
        bytes: &'a [u8],
        /// Why.
        reason: Rejection,
    },
    /// Bytes that belong to no candidate. A long run may come in several events.
    Noise {
        /// Position of the first byte in the stream.
        offset: u64,
        /// The bytes.
        bytes: &'a [u8],
    },
}

/// Finds frames in a byte stream: in any split, between foreign text, after damage.
///
/// The protocol does not escape its header (errata E04), so a candidate that fails is searched
/// again from its second byte: a fault costs the frame it hits, and one good frame after it when
/// by chance (1 in 256) a false sum is right. State is under 512 bytes, work
/// under 256 additions a byte. There is no clock inside: when the line has been silent for
/// [`INTER_BYTE_TIMEOUT_MS`](crate::INTER_BYTE_TIMEOUT_MS) and [`pending`](Self::pending) says
/// that bytes wait, call [`expire`](Self::expire).
///
/// ```
/// use magician_protocol::{Deframer, Event};
///
/// let mut deframer = Deframer::new();
/// let mut input = &b"M10\r\n\xAA\xAA\x02\x0A\x00\xF6"[..];
/// assert!(matches!(deframer.next(&mut input), Some(Event::Noise { bytes: b"M10\r\n", .. })));
/// assert!(matches!(deframer.next(&mut input), Some(Event::Frame { offset: 5, .. })));
/// assert_eq!(deframer.next(&mut input), None);
/// ```
#[derive(Clone, Debug)]
pub struct Deframer {
    buffer: [u8; CAPACITY],
    start: u16,
    end: u16,
    expiring: bool,
    /// Bytes the candidate at `start` needs before it is worth another look.
    wanted: u16,
    /// Stream position of `buffer[start]`.
    offset: u64,
    /// Stream position up to which a rejected candidate has already reported the bytes.
    reported: u64,
}

enum Verdict {
    More,
    Frame(usize),
    Rejected(usize, Rejection),
    Noise(usize),
}

impl Default for Deframer {
    fn default() -> Self {
        Self::new()
    }
}

impl Deframer {
    /// An empty decoder at stream position 0.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            buffer: [0; CAPACITY],
            start: 0,
            end: 0,
            expiring: false,
            wanted: 0,
            offset: 0,
            reported: 0,
        }
    }

    /// Takes bytes from the front of `input` until there is something to report; `None` when all
    /// of `input` has been taken and what is left may still become a frame.
    #[inline]
    pub fn next<'a>(&'a mut self, input: &mut &[u8]) -> Option<Event<'a>> {
        // What cannot complete the candidate is only kept.
        let held = usize::from(self.end - self.start);
        if held + input.len() < usize::from(self.wanted) && !self.expiring {
            self.refill(input);
            if input.is_empty() {
                return None;
            }
        }
        self.search(input)
    }

    fn search<'a>(&'a mut self, input: &mut &[u8]) -> Option<Event<'a>> {
        loop {
            match self.judge() {
                Verdict::More => {
                    if self.expiring && !self.pending() {
                        self.expiring = false;
                    }
                    if !self.refill(input) {
                        return None;
                    }
                }
                Verdict::Frame(count) => {
                    let (offset, at) = self.take(count);
                    let frame = Frame::trusted(&self.buffer[at..at + count]);
                    return Some(Event::Frame { offset, frame });
                }
                Verdict::Rejected(count, reason) => {
                    let (offset, at) = self.take(1);
                    self.reported = self.reported.max(offset + count as u64);
                    let bytes = &self.buffer[at..at + count];
                    return Some(Event::Rejected {
                        offset,
                        bytes,
                        reason,
                    });
                }
                Verdict::Noise(count) => {
                    let known = self.reported.saturating_sub(self.offset).min(count as u64);
                    let (offset, at) = self.take(count);
                    let fresh = known as usize;
                    if fresh < count {
                        return Some(Event::Noise {
                            offset: offset + known,
                            bytes: &self.buffer[at + fresh..at + count],
                        });
                    }
                }
            }
        }
    }

    /// The line has been silent for the inter-byte timeout, or the input has ended: gives up the
    /// candidate that waits for bytes. Call [`next`](Self::next) with no input until it returns
    /// `None` to see what that leaves.
    pub fn expire(&mut self) {
        self.expiring = self.pending();
    }

    /// Whether bytes wait for the rest of their frame.
    #[must_use]
    pub fn pending(&self) -> bool {
        self.start != self.end
    }

    /// Stream position that the search has reached: every byte before it has been reported.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Moves past `count` bytes; returns the stream and buffer position they began at.
    fn take(&mut self, count: usize) -> (u64, usize) {
        let before = (self.offset, usize::from(self.start));
        self.offset += count as u64;
        self.start += count as u16;
        self.wanted = 0;
        before
    }

    fn refill(&mut self, input: &mut &[u8]) -> bool {
        if input.is_empty() {
            return false;
        }
        let (start, end) = (usize::from(self.start), usize::from(self.end));
        if start == end {
            (self.start, self.end) = (0, 0);
        } else if end == CAPACITY {
            self.buffer.copy_within(start..end, 0);
            (self.start, self.end) = (0, (end - start) as u16);
        }
        let end = usize::from(self.end);
        let count = input.len().min(CAPACITY - end);
        let (now, later) = input.split_at(count);
        self.buffer[end..end + count].copy_from_slice(now);
        self.end += count as u16;
        *input = later;
        true
    }

    fn judge(&mut self) -> Verdict {
        if self.end - self.start < self.wanted && !self.expiring {
            return Verdict::More;
        }
        let bytes = &self.buffer[usize::from(self.start)..usize::from(self.end)];
        match bytes {
            [0xAA, 0xAA, len, rest @ ..] => {
                let len_byte = usize::from(*len);
                if !(2..=MAX_LEN).contains(&len_byte) {
                    return Verdict::Rejected(3, Rejection::Length(*len));
                }
                let Some((body, [found, ..])) = rest.split_at_checked(len_byte) else {
                    return self.incomplete(len_byte + 4);
                };
                let (expected, found) = (checksum(body), *found);
                if expected != found {
                    Verdict::Rejected(len_byte + 4, Rejection::Checksum { expected, found })
                } else if is_false(body) {
                    Verdict::Rejected(len_byte + 4, Rejection::Length(*len))
                } else {
                    Verdict::Frame(len_byte + 4)
                }
            }
            [] => Verdict::More,
            [0xAA] => self.incomplete(2),
            [0xAA, 0xAA] => self.incomplete(3),
            _ => Verdict::Noise(noise_length(bytes)),
        }
    }

    /// A candidate that cannot be judged before it has `wanted` bytes.
    fn incomplete(&mut self, wanted: usize) -> Verdict {
        match (self.expiring, self.end - self.start) {
            (false, _) => {
                self.wanted = wanted as u16;
                Verdict::More
            }
            (true, 1) => Verdict::Noise(1),
            (true, count) => Verdict::Rejected(count.into(), Rejection::Truncated),
        }
    }
}

/// Whether a candidate whose sum is right is none all the same. One in 256 damaged Len bytes gets
/// past the sum, and could take thirty good frames with it.
#[inline]
fn is_false(body: &[u8]) -> bool {
    let [id, ctrl, params @ ..] = body else {
        return false;
    };
    params.len() >= SHORTEST && !Row::usual(*id, Ctrl(*ctrl), params.len()) && swallows(*id, params)
}

#[cold]
fn swallows(id: u8, params: &[u8]) -> bool {
    holds_frame(params) && !Row::with_id(id).is_some_and(|row| row.takes_open(params))
}

/// Whether a whole frame stands in these bytes; gives up after [`SEARCH`] additions.
fn holds_frame(bytes: &[u8]) -> bool {
    let mut budget = SEARCH;
    bytes.windows(SHORTEST).enumerate().any(|(at, head)| {
        let (len, inner) = match (head, bytes.get(at + 3..)) {
            ([0xAA, 0xAA, len, ..], Some(inner)) => (usize::from(*len), inner),
            _ => return false,
        };
        let Some((body, [sum, ..])) = inner.split_at_checked(len) else {
            return false;
        };
        let Some(left) = budget.checked_sub(len).filter(|_| len >= 2) else {
            return false;
        };
        budget = left;
        checksum(body) == *sum
    })
}

/// How many bytes come before the next possible header; at least 1.
fn noise_length(bytes: &[u8]) -> usize {
    let mut at = 1;
    while let Some(skip) = bytes[at..].iter().position(|byte| *byte == 0xAA) {
        at += skip;
        match bytes.get(at + 1) {
            None | Some(0xAA) => return at,
            Some(_) => at += 1,
        }
    }
    bytes.len()
}
