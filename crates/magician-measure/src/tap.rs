//! A line that is looked at while it is used: when a stop went out, and when its answer came.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Result, Tap};
use magician_protocol::commands::QueuedCmdForceStopExec;
use magician_protocol::{BAUD_RATE, Ctrl, Direction, FrameBuf, Writable};
use tokio::time::Instant;

use crate::Exchange;

/// When the stop passed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// When its first byte was on the line.
    pub(crate) sent: Option<Instant>,
    /// When its answer was there.
    pub(crate) answered: Option<Instant>,
}

/// Watches a line for the stop that was sent last, and for its answer.
pub(crate) struct StopTap {
    /// The bytes of a stop; its answer is the same bytes.
    stop: FrameBuf,
    /// Whether bytes take their time at 115200 baud.
    paced: bool,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    seen: Seen,
    /// Until when bytes handed over before keep a line of 115200 baud busy.
    busy: Option<Instant>,
    /// What came and could be the beginning of the answer.
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

    /// Forgets the stop before.
    pub(crate) fn forget(&self) {
        self.lock().seen = Seen::default();
    }

    pub(crate) fn seen(&self) -> Seen {
        self.lock().seen
    }

    fn wrote(&self, bytes: &[u8]) {
        let now = Instant::now();
        let mut state = self.lock();
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
