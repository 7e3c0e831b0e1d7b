//! Pacing of a serial line.

use super::Micros;

/// Backlog on the line up to which another frame is handed out, ns.
// A choice: it adds 1 ms to a stop's delay and covers the caller's own delays.
const MAX_BACKLOG_NS: u64 = 1_000_000;

/// Tracks how long the frames handed out keep a serial line busy.
///
/// Bytes handed to the operating system cannot be overtaken by a stop any more, so frames are
/// handed out only shortly before the line is free.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    baud: Option<u64>,
    /// Instant at which the last byte will have been sent, ns.
    free: u64,
    /// Instant at which a waiting frame may be sent.
    wakes: Option<Micros>,
}

impl Pace {
    pub(super) fn new(baud: Option<u32>) -> Self {
        Self {
            baud: baud.filter(|baud| *baud > 0).map(u64::from),
            free: 0,
            wakes: None,
        }
    }

    /// Notes that a frame of `bytes` bytes is handed out.
    pub(super) fn sent(&mut self, now: Micros, bytes: usize) {
        if self.baud.is_some() {
            let begins = self.free.max(now.saturating_mul(1000));
            self.free = begins.saturating_add(self.time(bytes));
        }
    }

    /// True if another frame (not a stop) may be sent now. Otherwise remembers when.
    pub(super) fn admits(&mut self, now: Micros) -> bool {
        let from = self.free.saturating_sub(MAX_BACKLOG_NS).div_ceil(1000);
        self.wakes = (self.baud.is_some() && from > now).then_some(from);
        self.wakes.is_none()
    }

    /// True if a shorter frame of `bytes` bytes may follow one of `before` bytes. A stop then waits
    /// at most `MAX_BACKLOG_NS` plus the time of `before` bytes, as behind any frame of that size.
    pub(super) fn admits_behind(&self, now: Micros, before: usize, bytes: usize) -> bool {
        let spared = self.time(before).saturating_sub(self.time(bytes));
        self.free
            <= now
                .saturating_mul(1000)
                .saturating_add(MAX_BACKLOG_NS + spared)
    }

    /// Transmission time of `bytes` bytes, ns.
    fn time(&self, bytes: usize) -> u64 {
        // 10 bits a byte: 8N1.
        let time = |baud| (bytes as u64).saturating_mul(10_000_000_000) / baud;
        self.baud.map_or(0, time)
    }

    /// Instant at which a waiting frame will be admitted. `None` if no frame waits.
    pub(super) fn wakes(&self) -> Option<Micros> {
        self.wakes
    }

    pub(super) fn pass(&mut self, now: Micros) {
        self.wakes = self.wakes.filter(|at| *at > now);
    }

    /// Notes that the line is empty, because everything was answered or it is a new line.
    pub(super) fn begin_anew(&mut self) {
        (self.free, self.wakes) = (0, None);
    }
}
