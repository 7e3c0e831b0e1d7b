use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};

use magician_sim::LinkId;
use tokio::time::{Instant, Sleep, sleep_until};

use super::Transport;
use crate::VirtualArm;

const LINK: LinkId = LinkId(0);

/// The line to a virtual arm in this process.
pub(crate) struct Sim {
    arm: VirtualArm,
    alarm: Pin<Box<Sleep>>,
}

impl Sim {
    pub(crate) fn new(arm: VirtualArm) -> Self {
        Self {
            arm,
            alarm: Box::pin(sleep_until(Instant::now())),
        }
    }
}

impl Drop for Sim {
    /// What the arm still had to say to this connection is not for the next one.
    fn drop(&mut self) {
        self.arm.lock().runner.close(LINK);
    }
}

impl Transport for Sim {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let mut cell = self.arm.lock();
        cell.waker = Some(cx.waker().clone());
        loop {
            let now = cell.now();
            cell.runner.handle_timeout(now);
            if let Some(frame) = cell.runner.poll_transmit(now, LINK) {
                let frame = frame.bytes();
                let count = frame.len().min(bytes.len());
                bytes[..count].copy_from_slice(&frame[..count]);
                return Poll::Ready(Ok(count));
            }
            let Some(at) = cell.runner.poll_timeout() else {
                return Poll::Pending;
            };
            // Timers may fire a little early; an instant that has come is waited for a moment.
            let Some(comes) = cell.comes(at.max(now + 1)) else {
                // Whoever lets time pass wakes this; what is due already goes on when others had their turn.
                if at <= now {
                    cx.waker().wake_by_ref();
                }
                return Poll::Pending;
            };
            self.alarm.as_mut().reset(comes);
            if self.alarm.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
    }

    fn poll_write(&mut self, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let mut cell = self.arm.lock();
        let now = cell.now();
        cell.runner.receive(now, LINK, bytes);
        Poll::Ready(Ok(bytes.len()))
    }
}
