//! The line to a real arm, whose bytes the page carries.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// Largest number of buffered bytes per direction: five seconds of a serial line. A real arm cannot
/// send more; towards the arm, a full buffer makes the driver wait for the page.
const BUFFER_SIZE: usize = 64 * 1024;

/// Both directions of the line. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line(Arc<Mutex<LineState>>);

#[derive(Debug, Default)]
struct LineState {
    lost: bool,
    /// Number of losses. A [`LineEnd`] opened before the last loss is closed: its reads return the
    /// end of the stream, and its writes fail.
    losses: u64,
    from_arm: VecDeque<u8>,
    to_arm: Vec<u8>,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

impl Line {
    fn state(&self) -> MutexGuard<'_, LineState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Buffers bytes from the arm.
    pub(crate) fn receive(&self, bytes: &[u8]) {
        let mut state = self.state();
        if state.lost {
            return;
        }
        let room = BUFFER_SIZE.saturating_sub(state.from_arm.len());
        state.from_arm.extend(bytes.iter().take(room));
        if let Some(reader) = state.reader.take() {
            reader.wake();
        }
    }

    /// Marks the line as lost and drops buffered bytes.
    pub(crate) fn mark_lost(&self) {
        let mut state = self.state();
        if std::mem::replace(&mut state.lost, true) {
            return;
        }
        state.losses += 1;
        state.from_arm.clear();
        state.to_arm.clear();
        let waiting = [state.reader.take(), state.writer.take()];
        // Unlock before waking, because a woken task locks it again.
        drop(state);
        waiting.into_iter().flatten().for_each(Waker::wake);
    }

    /// Marks the line as present again.
    pub(crate) fn mark_found(&self) {
        self.state().lost = false;
    }

    /// Takes all bytes for the arm.
    pub(crate) fn take_output(&self) -> Option<Vec<u8>> {
        let mut state = self.state();
        let bytes = std::mem::take(&mut state.to_arm);
        if let Some(writer) = state.writer.take() {
            writer.wake();
        }
        (!bytes.is_empty()).then_some(bytes)
    }

    /// Opens the driver's end.
    pub(crate) fn open(&self) -> io::Result<LineEnd> {
        let state = self.state();
        if state.lost {
            return Err(io::Error::new(
                io::ErrorKind::NotConnected,
                "the line is lost",
            ));
        }
        Ok(LineEnd {
            line: self.clone(),
            losses_at_opening: state.losses,
        })
    }
}

/// The driver's end of a line, valid until the line is lost.
#[derive(Debug)]
pub(crate) struct LineEnd {
    line: Line,
    losses_at_opening: u64,
}

impl AsyncRead for LineEnd {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let mut state = self.line.state();
        // Reading no bytes signals the end of the stream.
        if state.losses != self.losses_at_opening {
            return Poll::Ready(Ok(()));
        }
        if state.from_arm.is_empty() {
            state.reader = Some(cx.waker().clone());
            return Poll::Pending;
        }
        let count = buffer.remaining().min(state.from_arm.len());
        for byte in state.from_arm.drain(..count) {
            buffer.put_slice(&[byte]);
        }
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for LineEnd {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let mut state = self.line.state();
        if state.losses != self.losses_at_opening {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        let room = BUFFER_SIZE.saturating_sub(state.to_arm.len());
        if room == 0 {
            state.writer = Some(cx.waker().clone());
            return Poll::Pending;
        }
        let count = room.min(bytes.len());
        state.to_arm.extend(bytes.iter().take(count));
        Poll::Ready(Ok(count))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
