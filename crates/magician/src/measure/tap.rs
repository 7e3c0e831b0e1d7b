//! A line that is looked at while it is used: when a stop went out, and when its answer came.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};

use magician_protocol::commands::QueuedCmdForceStopExec;
use magician_protocol::{BAUD_RATE, Ctrl, FrameBuf, Writable};
use tokio::time::Instant;

use super::Exchange;
use crate::transport::Transport;

/// What was seen of the last stop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// When its first byte was on the line.
    pub(super) sent: Option<Instant>,
    /// When its answer had come.
    pub(super) answered: Option<Instant>,
    /// Until when bytes handed over before keep a line of 115200 baud busy.
    busy: Option<Instant>,
}

/// The log of a [`Tap`]; clones share it.
#[derive(Clone, Debug, Default)]
pub(super) struct Log(Arc<Mutex<Seen>>);

impl Log {
    fn lock(&self) -> MutexGuard<'_, Seen> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets the last stop.
    pub(super) fn forget(&self) {
        let mut seen = self.lock();
        (seen.sent, seen.answered) = (None, None);
    }

    pub(super) fn seen(&self) -> Seen {
        *self.lock()
    }
}

/// A transport and its log.
pub(super) struct Tap {
    inner: Box<dyn Transport>,
    /// Whether bytes take their time at 115200 baud.
    paced: bool,
    stop: FrameBuf,
    /// The end of what came, for an answer that comes in pieces.
    tail: Vec<u8>,
    log: Log,
}

impl Tap {
    pub(super) fn new(inner: Box<dyn Transport>, paced: bool, log: Log) -> crate::Result<Self> {
        let stop = FrameBuf::encode(
            QueuedCmdForceStopExec::ROW.id,
            Ctrl::SET,
            &QueuedCmdForceStopExec {},
        )?;
        Ok(Self {
            inner,
            paced,
            stop,
            tail: Vec::new(),
            log,
        })
    }

    fn wrote(&self, bytes: &[u8]) {
        let now = Instant::now();
        let mut seen = self.log.lock();
        let begins = seen.busy.map_or(now, |busy| busy.max(now));
        if bytes.starts_with(self.stop.bytes()) {
            seen.sent.get_or_insert(begins);
        }
        let wire = Exchange {
            request: u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            reply: 0,
        };
        seen.busy = self.paced.then(|| begins + wire.wire_time(BAUD_RATE));
    }

    /// The answer to a stop is the very frame that was sent.
    fn came(&mut self, bytes: &[u8]) {
        self.tail.extend_from_slice(bytes);
        let stop = self.stop.bytes();
        if self.tail.windows(stop.len()).any(|part| part == stop) {
            self.log.lock().answered.get_or_insert_with(Instant::now);
            self.tail.clear();
        }
        let keep = self.tail.len().min(stop.len() - 1);
        self.tail.drain(..self.tail.len() - keep);
    }
}

impl Transport for Tap {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let count = ready!(self.inner.poll_read(cx, bytes))?;
        self.came(bytes.get(..count).unwrap_or_default());
        Poll::Ready(Ok(count))
    }

    fn ask(&mut self) {
        self.inner.ask();
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let count = ready!(self.inner.poll_write(cx, bytes))?;
        self.wrote(bytes.get(..count).unwrap_or_default());
        Poll::Ready(Ok(count))
    }
}
