//! Open line with its partly written frame.

use std::io;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use magician_protocol::FrameBuf;

use crate::connection::{Connection, Micros};
use crate::transport::{Leap, LeapTo, Transport};

/// Open line with the frame that is being written to it.
pub(super) struct Wire {
    transport: Box<dyn Transport>,
    out: Option<(FrameBuf, usize)>,
}

impl Wire {
    pub(super) fn new(transport: Box<dyn Transport>) -> Self {
        Self {
            transport,
            out: None,
        }
    }

    /// Passes arrived bytes to the connection; true if there were any.
    pub(super) fn read(
        &mut self,
        cx: &mut Context<'_>,
        now: Micros,
        connection: &mut Connection,
    ) -> io::Result<bool> {
        // Larger than any burst of a serial line between two rounds; longer ones take another read.
        let mut bytes = [0; 1024];
        match self.transport.poll_read(cx, &mut bytes) {
            Poll::Pending => Ok(false),
            Poll::Ready(Err(error)) => Err(error),
            // The other end has closed the line in an orderly way, which is a loss all the same.
            Poll::Ready(Ok(0)) => Err(io::ErrorKind::UnexpectedEof.into()),
            Poll::Ready(Ok(count)) => {
                connection.receive(now, bytes.get(..count).unwrap_or_default());
                Ok(true)
            }
        }
    }

    /// Writes the next frame of the connection; true if anything was written. `begins` sees every
    /// frame before its first byte.
    pub(super) fn write(
        &mut self,
        cx: &mut Context<'_>,
        now: Micros,
        connection: &mut Connection,
        begins: impl FnOnce(&FrameBuf),
    ) -> io::Result<bool> {
        if self.out.is_none() {
            // Only when the previous frame is out: a stop may then still overtake what waits.
            self.out = connection.poll_transmit(now).map(|frame| (frame, 0));
            if let Some((frame, _)) = &self.out {
                begins(frame);
            }
        }
        let Some((frame, written)) = &mut self.out else {
            return Ok(false);
        };
        let rest = frame.bytes().get(*written..).unwrap_or_default();
        match self.transport.poll_write(cx, rest) {
            Poll::Pending => Ok(false),
            Poll::Ready(Err(error)) => Err(error),
            Poll::Ready(Ok(0)) => Err(io::ErrorKind::WriteZero.into()),
            Poll::Ready(Ok(count)) => {
                *written += count;
                if *written >= frame.bytes().len() {
                    self.out = None;
                }
                Ok(true)
            }
        }
    }

    /// Forwards to [`Transport::ask`].
    pub(super) fn ask(&mut self) {
        self.transport.ask();
    }

    /// Forwards to [`Transport::lead`].
    pub(super) fn lead(&mut self, leads: bool) -> bool {
        self.transport.lead(leads)
    }

    /// Forwards to [`Transport::leap`].
    pub(super) fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        self.transport.leap(most, to)
    }

    /// Writes as much as possible without waiting: the rest of the current frame, then these. For a
    /// drop, where nothing can wait.
    pub(super) fn blurt(&mut self, frames: impl IntoIterator<Item = FrameBuf>) {
        let mut cx = Context::from_waker(Waker::noop());
        if let Some((frame, written)) = self.out.take() {
            let rest = frame.bytes().get(written..).unwrap_or_default();
            let _ = self.transport.poll_write(&mut cx, rest);
        }
        for frame in frames {
            // Best effort: a pending write is dropped, since nothing can wait for it.
            let _ = self.transport.poll_write(&mut cx, frame.bytes());
        }
    }
}
