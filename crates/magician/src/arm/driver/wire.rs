use std::io;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use magician_protocol::FrameBuf;

use crate::connection::{Connection, Micros};
use crate::transport::{Leap, LeapTo, Transport};

/// An open line with the frame that is being written to it.
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

    /// Hands what has come to the connection; whether anything has.
    pub(super) fn read(
        &mut self,
        cx: &mut Context<'_>,
        now: Micros,
        connection: &mut Connection,
    ) -> io::Result<bool> {
        let mut bytes = [0; 1024];
        match self.transport.poll_read(cx, &mut bytes) {
            Poll::Pending => Ok(false),
            Poll::Ready(Err(error)) => Err(error),
            Poll::Ready(Ok(0)) => Err(io::ErrorKind::UnexpectedEof.into()),
            Poll::Ready(Ok(count)) => {
                connection.receive(now, bytes.get(..count).unwrap_or_default());
                Ok(true)
            }
        }
    }

    /// Writes what the connection wants to say next; whether anything went out. `begins` sees every frame before its
    /// first byte.
    pub(super) fn write(
        &mut self,
        cx: &mut Context<'_>,
        now: Micros,
        connection: &mut Connection,
        begins: impl FnOnce(&FrameBuf),
    ) -> io::Result<bool> {
        if self.out.is_none() {
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

    /// As [`Transport::ask`].
    pub(super) fn ask(&mut self) {
        self.transport.ask();
    }

    /// As [`Transport::lead`].
    pub(super) fn lead(&mut self, leads: bool) -> bool {
        self.transport.lead(leads)
    }

    /// As [`Transport::leap`].
    pub(super) fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        self.transport.leap(most, to)
    }

    /// Writes what goes out without waiting, because there is no caller to wait: the rest of the frame under way, then
    /// these.
    pub(super) fn blurt(&mut self, frames: impl IntoIterator<Item = FrameBuf>) {
        let mut cx = Context::from_waker(Waker::noop());
        if let Some((frame, written)) = self.out.take() {
            let rest = frame.bytes().get(written..).unwrap_or_default();
            let _ = self.transport.poll_write(&mut cx, rest);
        }
        for frame in frames {
            let _ = self.transport.poll_write(&mut cx, frame.bytes());
        }
    }
}
