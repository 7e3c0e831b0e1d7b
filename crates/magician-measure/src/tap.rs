//! Observer of a line in use: the times of a stop and of its answer.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Result, Tap};
use magician_protocol::commands::QueuedCmdForceStopExec;
use magician_protocol::{BAUD_RATE, Ctrl, Direction, FrameBuf, Writable};
use tokio::time::Instant;

use crate::Exchange;

/// Times of a stop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// Time of its first byte on the line.
    pub(crate) sent: Option<Instant>,
    /// Time of its answer.
    pub(crate) answered: Option<Instant>,
}

/// Observer of a line for the most recent stop and its answer.
pub(crate) struct StopTap {
    /// Bytes of a stop; its answer is equal.
    stop: FrameBuf,
    /// True if the line transmits at 115200 baud, so that bytes have a wire time.
    paced: bool,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    seen: Seen,
    /// Time until which earlier bytes keep a line of 115200 baud busy.
    busy: Option<Instant>,
    /// Received bytes that could be the beginning of the answer.
    tail: Vec<u8>,
}

impl StopTap {
    pub(crate) fn new(paced: bool) -> Result<Arc<Self>> {
        let stop = FrameBuf::encode(
            QueuedCmdForceStopExec::ROW.id,
            Ctrl::SET,
            &QueuedCmdForceStopExec {},
        )?;
        Ok(Arc::new(Self {
            stop,
            paced,
            state: Mutex::default(),
        }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets the previous stop.
    pub(crate) fn forget(&self) {
        self.lock().seen = Seen::default();
    }

    pub(crate) fn seen(&self) -> Seen {
        self.lock().seen
    }

    fn record_write(&self, bytes: &[u8]) {
        let now = Instant::now();
        let mut state = self.lock();
        // A write returns at once, while the adapter may still be sending earlier bytes.
        let starts_at = state.busy.map_or(now, |busy| busy.max(now));
        if bytes.starts_with(self.stop.bytes()) {
            state.seen.sent.get_or_insert(starts_at);
        }
        let wire = Exchange {
            request: u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            reply: 0,
        };
        state.busy = self.paced.then(|| starts_at + wire.wire_time(BAUD_RATE));
    }

    fn record_reply(&self, bytes: &[u8]) {
        let mut state = self.lock();
        state.tail.extend_from_slice(bytes);
        let stop = self.stop.bytes();
        if state.tail.windows(stop.len()).any(|part| part == stop) {
            state.seen.answered.get_or_insert_with(Instant::now);
            state.tail.clear();
        }
        // An answer may be cut anywhere, so its possible beginning is kept.
        let keep = state.tail.len().min(stop.len() - 1);
        let surplus = state.tail.len() - keep;
        state.tail.drain(..surplus);
    }
}

impl Tap for StopTap {
    fn passed(&self, _line: &str, direction: Direction, bytes: &[u8]) {
        match direction {
            Direction::Request => self.record_write(bytes),
            Direction::Reply => self.record_reply(bytes),
        }
    }
}
