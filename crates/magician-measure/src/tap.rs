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
    /// True if bytes take their time at 115200 baud.
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

    fn wrote(&self, bytes: &[u8]) {
        let now = Instant::now();
        let mut state = self.lock();
        // The write returns at once; the adapter still sends the bytes before.
        let begins = state.busy.map_or(now, |busy| busy.max(now));
        if bytes.starts_with(self.stop.bytes()) {
            state.seen.sent.get_or_insert(begins);
        }
        let wire = Exchange {
            request: u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            reply: 0,
        };
        state.busy = self.paced.then(|| begins + wire.wire_time(BAUD_RATE));
    }

    fn came(&self, bytes: &[u8]) {
        let mut state = self.lock();
        state.tail.extend_from_slice(bytes);
        let stop = self.stop.bytes();
        if state.tail.windows(stop.len()).any(|part| part == stop) {
            state.seen.answered.get_or_insert_with(Instant::now);
            state.tail.clear();
        }
        // An answer may be cut anywhere, so its possible beginning is kept.
        let keep = state.tail.len().min(stop.len() - 1);
        let gone = state.tail.len() - keep;
        state.tail.drain(..gone);
    }
}

impl Tap for StopTap {
    fn passed(&self, _line: &str, direction: Direction, bytes: &[u8]) {
        match direction {
            Direction::Request => self.wrote(bytes),
            Direction::Reply => self.came(bytes),
        }
    }
}
