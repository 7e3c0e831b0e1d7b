//! The line to a real arm, whose bytes the page carries.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// Largest number of buffered bytes per direction: five seconds of a serial line. A real arm cannot
/// send more; towards the arm, a full buffer makes the driver wait for the page.
const ROOM: usize = 64 * 1024;

/// Both directions of the line. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line(Arc<Mutex<Wire>>);

#[derive(Debug, Default)]
struct Wire {
    lost: bool,
    /// Number of losses. An end opened before the last loss reads and writes nothing.
    losses: u64,
    from_arm: VecDeque<u8>,
    to_arm: Vec<u8>,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

impl Line {
    fn wire(&self) -> MutexGuard<'_, Wire> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Buffers bytes from the arm.
    pub(crate) fn hear(&self, bytes: &[u8]) {
        let mut wire = self.wire();
        if wire.lost {
            return;
        }
        let room = ROOM.saturating_sub(wire.from_arm.len());
        wire.from_arm.extend(bytes.iter().take(room));
        if let Some(reader) = wire.reader.take() {
            reader.wake();
        }
    }

    /// Marks the line as lost and drops buffered bytes.
    pub(crate) fn lose(&self) {
        let mut wire = self.wire();
        if std::mem::replace(&mut wire.lost, true) {
            return;
        }
        wire.losses += 1;
        wire.from_arm.clear();
        wire.to_arm.clear();
        let waiting = [wire.reader.take(), wire.writer.take()];
        // Unlock before waking, because a woken task locks it again.
        drop(wire);
        waiting.into_iter().flatten().for_each(Waker::wake);
    }

    /// Marks the line as present again.
    pub(crate) fn find(&self) {
        self.wire().lost = false;
    }

    /// Takes all bytes for the arm.
    pub(crate) fn say(&self) -> Option<Vec<u8>> {
        let mut wire = self.wire();
        let bytes = std::mem::take(&mut wire.to_arm);
        if let Some(writer) = wire.writer.take() {
            writer.wake();
        }
        (!bytes.is_empty()).then_some(bytes)
    }

    /// Opens the driver's end.
    pub(crate) fn open(&self) -> io::Result<LineEnd> {
        let wire = self.wire();
        if wire.lost {
            return Err(io::Error::new(
                io::ErrorKind::NotConnected,
                "the line is lost",
            ));
        }
        Ok(LineEnd {
            line: self.clone(),
            of: wire.losses,
        })
    }
}

/// The driver's end of a line, valid until the line is lost.
#[derive(Debug)]
pub(crate) struct LineEnd {
    line: Line,
    of: u64,
}

impl AsyncRead for LineEnd {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let mut wire = self.line.wire();
        // Reading no bytes signals the end of the stream.
        if wire.losses != self.of {
            return Poll::Ready(Ok(()));
        }
        if wire.from_arm.is_empty() {
            wire.reader = Some(cx.waker().clone());
            return Poll::Pending;
        }
        let count = into.remaining().min(wire.from_arm.len());
        for byte in wire.from_arm.drain(..count) {
            into.put_slice(&[byte]);
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
        let mut wire = self.line.wire();
        if wire.losses != self.of {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        let room = ROOM.saturating_sub(wire.to_arm.len());
        if room == 0 {
            wire.writer = Some(cx.waker().clone());
            return Poll::Pending;
        }
        let count = room.min(bytes.len());
        wire.to_arm.extend(bytes.iter().take(count));
        Poll::Ready(Ok(count))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
