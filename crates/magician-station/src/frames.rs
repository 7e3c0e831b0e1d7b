//! Ring buffer of the bytes that passed on an arm's serial line during the last ten minutes.
//!
//! A recording that is started after an incident still contains the traffic that led to it. The
//! ring holds *pieces*: what the driver read or wrote at once, with its time and direction. Each
//! piece is stored behind a head of six bytes in one byte queue, so memory is bounded by bytes and
//! not by the number of pieces. A reader keeps a [`RingPosition`] and asks for what came after it;
//! pieces that the ring dropped meanwhile are counted.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_protocol::Direction;
use tokio::time::Instant;

/// Age at which a piece is dropped. The history of readings covers the same ten minutes.
const HISTORY_LENGTH: Duration = Duration::from_secs(600);
/// Size of the head of a piece, bytes: time since the piece before in microseconds (4), direction
/// and length (2).
const HEAD_SIZE: usize = 6;
/// Bit that marks a reply. It shares 16 bits with the length.
const REPLY_FLAG: u16 = 1 << 15;

/// Bytes that passed on a line at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrafficPiece {
    /// Time since the ring was created.
    pub at: Duration,
    /// Direction: request to the arm, or reply from it.
    pub direction: Direction,
    /// The bytes as they passed: one frame, part of a frame, or several frames.
    pub bytes: Vec<u8>,
}

/// Traffic of one line: the last ten minutes, and at most [`FrameRing::MAX_SIZE`] bytes.
///
/// With the feature `http` the ring is a [`Tap`](magician::Tap), which the driver calls with all
/// traffic. The writer of recordings reads from the ring.
///
/// ```
/// use std::time::Duration;
/// use magician_protocol::Direction;
/// use magician_station::{FrameRing, RingPosition};
///
/// let ring = FrameRing::new("/dev/ttyUSB0");
/// ring.add(Duration::from_secs(1), Direction::Request, &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6]);
/// let (passed, _, missed) = ring.since(&RingPosition::default());
/// assert_eq!((passed.len(), missed), (1, 0));
/// ```
#[derive(Debug)]
pub struct FrameRing {
    line: String,
    started: Instant,
    ring: Mutex<Ring>,
}

#[derive(Debug, Default)]
struct Ring {
    bytes: VecDeque<u8>,
    /// Position of the oldest piece, and the time at which it passed, us.
    first: RingPosition,
    first_at: u64,
    /// Position of the next piece.
    next: RingPosition,
    /// Unix time at which the ring was created, s.
    zero: f64,
}

/// Position in the traffic since the ring was created. The default is the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RingPosition {
    /// Number of pieces before the position, and their bytes in the ring.
    pieces: u64,
    bytes: u64,
    /// Time of the last piece before the position, us.
    at: u64,
}

impl FrameRing {
    /// Largest size of the ring, bytes. A piece takes six bytes more than its content.
    pub const MAX_SIZE: usize = 16 << 20;

    /// Creates an empty ring for the line with this name.
    #[must_use]
    pub fn new(line: impl Into<String>) -> Arc<Self> {
        Arc::new(Self {
            line: line.into(),
            started: Instant::now(),
            ring: Mutex::default(),
        })
    }

    /// Returns the name of the line.
    #[must_use]
    pub fn line(&self) -> &str {
        &self.line
    }

    fn ring(&self) -> MutexGuard<'_, Ring> {
        self.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the clock of the ring: at the instant `at` the Unix time is `unix`, s.
    pub(crate) fn set_clock(&self, at: Instant, unix: f64) {
        let before = at.saturating_duration_since(self.started).as_secs_f64();
        self.ring().zero = unix - before;
    }

    /// Converts a time since the creation of the ring to Unix seconds.
    pub(crate) fn unix(&self, at: Duration) -> f64 {
        self.ring().zero + at.as_secs_f64()
    }

    /// Adds bytes that passed at this time since the creation of the ring.
    pub fn add(&self, at: Duration, direction: Direction, bytes: &[u8]) {
        // Microseconds in 64 bits last half a million years.
        let at = u64::try_from(at.as_micros()).unwrap_or(u64::MAX);
        let mut ring = self.ring();
        // The length has 15 bits, because the direction takes one.
        for piece in bytes.chunks(usize::from(REPLY_FLAG - 1)) {
            ring.add(at, direction, piece);
        }
    }

    /// Adds bytes that pass now.
    pub fn pass(&self, direction: Direction, bytes: &[u8]) {
        self.add(self.started.elapsed(), direction, bytes);
    }

    /// Returns the current end of the traffic.
    #[must_use]
    pub fn position(&self) -> RingPosition {
        self.ring().next
    }

    /// Returns the pieces after `mark`, the new end, and the number of pieces that were dropped
    /// before they could be read.
    #[must_use]
    pub fn since(&self, mark: &RingPosition) -> (Vec<TrafficPiece>, RingPosition, u64) {
        let (bytes, first, next, missed) = {
            let ring = self.ring();
            // Copies under the lock and parses after it, because the driver waits for the lock.
            let missed = ring.first.pieces.saturating_sub(mark.pieces);
            let offset = mark.bytes.saturating_sub(ring.first.bytes) as usize;
            let bytes: Vec<u8> = ring.bytes.range(offset..).copied().collect();
            // The time of a piece is stored relative to the piece before. If that one was dropped,
            // the reader starts from the ring's own first time.
            let whole = mark.pieces <= ring.first.pieces;
            let first = whole.then_some(ring.first_at);
            (bytes, first.ok_or(mark.at), ring.next, missed)
        };
        (pieces(&bytes, first), next, missed)
    }

    /// Returns the allocated memory, bytes.
    #[must_use]
    pub fn memory(&self) -> usize {
        self.ring().bytes.capacity()
    }
}

#[cfg(feature = "http")]
impl magician::Tap for FrameRing {
    fn passed(&self, _: &str, direction: Direction, bytes: &[u8]) {
        self.pass(direction, bytes);
    }
}

impl Ring {
    fn add(&mut self, at: u64, direction: Direction, bytes: &[u8]) {
        let kept = u64::try_from(HISTORY_LENGTH.as_micros()).unwrap_or(u64::MAX);
        let needs = HEAD_SIZE + bytes.len();
        let too_much = |ring: &Self| ring.bytes.len() + needs > FrameRing::MAX_SIZE;
        while !self.bytes.is_empty() && (at.saturating_sub(self.first_at) > kept || too_much(self))
        {
            self.drop_first();
        }
        if self.bytes.is_empty() {
            (self.first_at, self.next.at) = (at, at);
        }
        // Fits in 32 bits: what is kept is less than ten minutes old, and an empty ring starts
        // anew.
        let since = u32::try_from(at.saturating_sub(self.next.at)).unwrap_or(u32::MAX);
        if self.bytes.capacity() < self.bytes.len() + needs {
            // `reserve` could grow the buffer beyond `MAX_SIZE`, which the ring never exceeds.
            let more = (self.bytes.len() + needs).min(FrameRing::MAX_SIZE - self.bytes.len());
            self.bytes.reserve_exact(more);
        }
        let length = bytes.len() as u16;
        let head = match direction {
            Direction::Request => length,
            Direction::Reply => length | REPLY_FLAG,
        };
        self.bytes.extend(since.to_le_bytes());
        self.bytes.extend(head.to_le_bytes());
        self.bytes.extend(bytes);
        self.next.at += u64::from(since);
        self.next.pieces += 1;
        self.next.bytes += needs as u64;
    }

    fn drop_first(&mut self) {
        let head = |ring: &Self| {
            // A deque may wrap around, so the head is read byte by byte.
            let byte = |nth: usize| ring.bytes.get(nth).copied().unwrap_or(0);
            head_of([0, 1, 2, 3, 4, 5].map(byte))
        };
        let (.., length) = head(self);
        let whole = (HEAD_SIZE + length).min(self.bytes.len());
        self.bytes.drain(..whole);
        // Positions count from the creation of the ring, so marks stay valid when pieces are
        // dropped.
        self.first.pieces += 1;
        self.first.bytes += whole as u64;
        if !self.bytes.is_empty() {
            self.first_at += head(self).0;
        }
    }
}

/// Decodes a head: time since the piece before (us), direction, length.
fn head_of(head: [u8; HEAD_SIZE]) -> (u64, Direction, usize) {
    let [a, b, c, d, low, high] = head;
    let (since, length) = (
        u32::from_le_bytes([a, b, c, d]),
        u16::from_le_bytes([low, high]),
    );
    let direction = if length & REPLY_FLAG == 0 {
        Direction::Request
    } else {
        Direction::Reply
    };
    (since.into(), direction, usize::from(length & !REPLY_FLAG))
}

/// Splits bytes into pieces. `first` is the time of the first piece (`Ok`), or of the piece before
/// it (`Err`).
fn pieces(mut bytes: &[u8], first: Result<u64, u64>) -> Vec<TrafficPiece> {
    let mut all = Vec::new();
    let mut at = first.unwrap_or_else(|before| before);
    let mut counts = first.is_err();
    while let Some((head, rest)) = bytes.split_first_chunk::<HEAD_SIZE>() {
        let (since, direction, length) = head_of(*head);
        at += if std::mem::replace(&mut counts, true) {
            since
        } else {
            0
        };
        let (piece, rest) = rest.split_at(length.min(rest.len()));
        all.push(TrafficPiece {
            at: Duration::from_micros(at),
            direction,
            bytes: piece.to_vec(),
        });
        bytes = rest;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const GET: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];

    #[test]
    fn ring_returns_pieces_with_direction_and_time() {
        let ring = FrameRing::new("line");
        let mut fourth = RingPosition::default();
        for nth in 0..10 {
            if nth == 4 {
                fourth = ring.position();
            }
            let direction = if nth % 2 == 0 {
                Direction::Request
            } else {
                Direction::Reply
            };
            ring.add(
                Duration::from_millis(nth * 7),
                direction,
                &GET[..1 + nth as usize % 5],
            );
        }
        let (passed, next, missed) = ring.since(&fourth);
        assert_eq!((passed.len(), next, missed), (6, ring.position(), 0));
        assert_eq!(
            passed[3],
            TrafficPiece {
                at: Duration::from_millis(49),
                direction: Direction::Reply,
                bytes: GET[..3].to_vec(),
            }
        );
        assert_eq!(ring.since(&next), (Vec::new(), next, 0));
        let (all, ..) = ring.since(&RingPosition::default());
        assert_eq!(all[4..], passed);
    }

    #[test]
    fn ring_covers_ten_minutes() {
        let ring = FrameRing::new("line");
        for second in 0..2000 {
            ring.add(Duration::from_secs(second), Direction::Request, &GET);
        }
        let (passed, _, missed) = ring.since(&RingPosition::default());
        assert_eq!((passed.len(), missed), (601, 1399));
        assert_eq!(passed[0].at, Duration::from_secs(1399));
        // A line that was silent for hours: the gap exceeds 32 bits of microseconds.
        ring.add(Duration::from_secs(100_000), Direction::Request, &GET);
        let (passed, ..) = ring.since(&RingPosition::default());
        assert_eq!(passed.len(), 1);
        assert_eq!(passed[0].at, Duration::from_secs(100_000));
    }

    #[test]
    fn full_ring_drops_and_counts_the_oldest_pieces() {
        let ring = FrameRing::new("line");
        let piece = [0; 1000];
        for nth in 0..30_000 {
            ring.add(Duration::from_millis(nth), Direction::Reply, &piece);
        }
        let (passed, _, missed) = ring.since(&RingPosition::default());
        let most = FrameRing::MAX_SIZE / (piece.len() + HEAD_SIZE);
        assert_eq!((passed.len(), missed), (most, 30_000 - most as u64));
        assert!(ring.memory() <= FrameRing::MAX_SIZE, "{}", ring.memory());
        assert_eq!(passed[0].at, Duration::from_millis(missed));
    }
}
