//! Recovery of frames from a byte stream that may be split anywhere, contain foreign text or be
//! damaged.
//!
//! The header is not escaped, so 0xAA 0xAA may also stand inside parameters, and a frame with a
//! damaged Len byte may appear to contain the frames after it. The deframer therefore treats each
//! header as a *candidate*: it waits for Len bytes, compares the checksum, and on failure resumes
//! the search at the candidate's second byte. A candidate whose checksum matches by chance although
//! its Len is damaged is recognised by two signs together: its length is unusual for the command,
//! and whole frames stand inside it.
//!
//! Memory and work are bounded for any input, because the deframer also runs in interrupt handlers
//! and faces strangers on the network.

use core::fmt;

use crate::Row;
use crate::frame::{Ctrl, Frame, MAX_LEN, checksum};

// Above MAX_FRAME (254), so that the buffer is not moved for every frame, and small enough that
// the whole state stays below 512 bytes (invariant; test `state_is_small`).
const BUFFER_SIZE: usize = 472;
/// Size of the shortest frame (header, Len, id, Ctrl, checksum), bytes.
const MIN_FRAME_SIZE: usize = 6;
/// Largest number of bytes summed for checksums, per candidate, in the search for frames inside it.
// Together with the candidate's own checksum this budget keeps the worst input, a run of 0xAA,
// below 256 additions a byte.
const SEARCH_BUDGET: usize = 80;

/// Reason why a frame candidate (two header bytes and what follows) was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// The checksum byte does not match the body.
    Checksum {
        /// Checksum computed over the body.
        expected: u8,
        /// Checksum byte received.
        found: u8,
    },
    /// Len is below 2 or above 250 (errata E03), or it was damaged and the checksum matches by
    /// chance. Damage shows by two signs together: the length is unusual for the command, and the
    /// candidate contains whole frames.
    Length(u8),
    /// The line fell silent, or the input ended, inside the frame.
    Truncated,
}

impl Rejection {
    /// Short name: `checksum`, `length` or `truncated`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Checksum { .. } => "checksum",
            Self::Length(_) => "length",
            Self::Truncated => "truncated",
        }
    }
}

/// Describes the rejection; the alternate form (`#`) omits the leading [name](Self::name).
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

/// An event of the [`Deframer`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// A whole frame.
    Frame {
        /// Position of its first byte in the stream.
        offset: u64,
        /// The frame.
        frame: Frame<'a>,
    },
    /// A rejected candidate. The search resumes at its second byte.
    Rejected {
        /// Position of its first byte in the stream.
        offset: u64,
        /// Bytes of the candidate received so far.
        bytes: &'a [u8],
        /// Reason of the rejection.
        reason: Rejection,
    },
    /// Bytes outside any candidate. A long run may be split over several events.
    Noise {
        /// Position of the first byte in the stream.
        offset: u64,
        /// The bytes.
        bytes: &'a [u8],
    },
}

/// Finds frames in a byte stream that may be split anywhere, contain foreign text or be damaged.
///
/// The protocol does not escape its header (errata E04), so the search resumes at the second byte
/// of a rejected candidate. A fault costs the frame it hits and, if a false checksum matches by
/// chance (1 in 256), one good frame after it. State is below 512 bytes, work below 256 additions a
/// byte.
///
/// The deframer has no clock. When the line has been silent for
/// [`INTER_BYTE_TIMEOUT_MS`](crate::INTER_BYTE_TIMEOUT_MS) and [`pending`](Self::pending) is true,
/// call [`expire`](Self::expire).
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
    buffer: [u8; BUFFER_SIZE],
    start: u16,
    end: u16,
    expiring: bool,
    /// Bytes the candidate at `start` needs before it is judged again.
    wanted: u16,
    /// Stream position of `buffer[start]`.
    offset: u64,
    /// Stream position up to which a rejected candidate has reported the bytes already.
    reported: u64,
}

enum Verdict {
    Incomplete,
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
    /// Creates a deframer at stream position 0.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            buffer: [0; BUFFER_SIZE],
            start: 0,
            end: 0,
            expiring: false,
            wanted: 0,
            offset: 0,
            reported: 0,
        }
    }

    /// Consumes bytes from the front of `input` until there is an event to report.
    ///
    /// `None` when all of `input` is consumed and the bytes held may still become a frame.
    #[inline]
    pub fn next<'a>(&'a mut self, input: &mut &[u8]) -> Option<Event<'a>> {
        // Fast path for byte-by-byte input: do not judge a candidate that these bytes cannot
        // complete.
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
            match self.classify() {
                Verdict::Incomplete => {
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
                    // Only one byte is consumed: a true header may begin inside a false candidate.
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
                    // The rejected candidate showed these bytes already: report each byte once.
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

    /// Gives up the incomplete candidate, after the inter-byte timeout or at the end of input.
    ///
    /// Then call [`next`](Self::next) with empty input until it returns `None`, to get the frames
    /// that the candidate hid.
    pub fn expire(&mut self) {
        self.expiring = self.pending();
    }

    /// True if bytes wait for the rest of their frame.
    #[must_use]
    pub fn pending(&self) -> bool {
        self.start != self.end
    }

    /// Stream position of the search: all bytes before it have been reported.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Consumes `count` bytes and returns the stream and buffer positions of the first.
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
        } else if end == BUFFER_SIZE {
            self.buffer.copy_within(start..end, 0);
            (self.start, self.end) = (0, (end - start) as u16);
        }
        let end = usize::from(self.end);
        let count = input.len().min(BUFFER_SIZE - end);
        let (now, later) = input.split_at(count);
        self.buffer[end..end + count].copy_from_slice(now);
        self.end += count as u16;
        *input = later;
        true
    }

    fn classify(&mut self) -> Verdict {
        if self.end - self.start < self.wanted && !self.expiring {
            return Verdict::Incomplete;
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
                } else if has_damaged_len(body) {
                    Verdict::Rejected(len_byte + 4, Rejection::Length(*len))
                } else {
                    Verdict::Frame(len_byte + 4)
                }
            }
            [] => Verdict::Incomplete,
            [0xAA] => self.incomplete(2),
            [0xAA, 0xAA] => self.incomplete(3),
            // Neither a header nor the beginning of one.
            _ => Verdict::Noise(noise_length(bytes)),
        }
    }

    /// Returns the verdict on a candidate that is shorter than the `wanted` bytes needed to judge
    /// it.
    fn incomplete(&mut self, wanted: usize) -> Verdict {
        match (self.expiring, self.end - self.start) {
            (false, _) => {
                self.wanted = wanted as u16;
                Verdict::Incomplete
            }
            (true, 1) => Verdict::Noise(1),
            (true, count) => Verdict::Rejected(count.into(), Rejection::Truncated),
        }
    }
}

/// True if a candidate is no frame although its checksum matches, because its Len was damaged.
///
/// One in 256 damaged Len bytes passes the checksum and could take thirty good frames with it.
#[inline]
fn has_damaged_len(body: &[u8]) -> bool {
    let [id, ctrl, params @ ..] = body else {
        return false;
    };
    params.len() >= MIN_FRAME_SIZE
        && !Row::has_usual_size(*id, Ctrl(*ctrl), params.len())
        && contains_unexpected_frame(*id, params)
}

#[cold]
fn contains_unexpected_frame(id: u8, params: &[u8]) -> bool {
    holds_frame(params) && !Row::with_id(id).is_some_and(|row| row.may_be_open_ended(params))
}

/// True if `bytes` contain a whole frame. Gives up after [`SEARCH_BUDGET`] additions.
fn holds_frame(bytes: &[u8]) -> bool {
    let mut budget = SEARCH_BUDGET;
    bytes.windows(MIN_FRAME_SIZE).enumerate().any(|(at, head)| {
        let (len, inner) = match (head, bytes.get(at + 3..)) {
            ([0xAA, 0xAA, len, ..], Some(inner)) => (usize::from(*len), inner),
            // Not a header here: try the next position.
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

/// Bytes before the next possible header; at least 1.
fn noise_length(bytes: &[u8]) -> usize {
    let mut at = 1;
    while let Some(skip) = bytes[at..].iter().position(|byte| *byte == 0xAA) {
        at += skip;
        match bytes.get(at + 1) {
            // The last byte, if 0xAA, may be half a header: keep it.
            None | Some(0xAA) => return at,
            Some(_) => at += 1,
        }
    }
    bytes.len()
}
