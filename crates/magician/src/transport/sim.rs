//! Line to a virtual arm in this process.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_sim::LinkId;
use tokio::time::{Instant, Sleep, sleep_until};

use super::{Leap, LeapTo, Transport};
use crate::VirtualArm;

/// Line to a virtual arm in this process.
pub(crate) struct Sim {
    arm: VirtualArm,
    link: LinkId,
    /// Number of cable pulls when this line was opened.
    pulls: u64,
    alarm: Pin<Box<Sleep>>,
}

impl Sim {
    pub(crate) fn new(arm: VirtualArm) -> Self {
        let (link, pulls) = {
            let mut cell = arm.lock();
            (cell.open(), cell.runner.pulls())
        };
        Self {
            arm,
            link,
            pulls,
            alarm: Box::pin(sleep_until(Instant::now())),
        }
    }
}

impl Drop for Sim {
    /// Drops the pending replies to this connection: they are not for the next one.
    fn drop(&mut self) {
        self.arm.lock().close(self.link);
    }
}

impl Transport for Sim {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let mut cell = self.arm.lock();
        loop {
            let now = cell.now();
            cell.runner.handle_timeout(now);
            // Even if the cable is in again: the connection of before is gone.
            if cell.breaks() && cell.runner.pulls() != self.pulls {
                return Poll::Ready(Err(io::Error::other("the cable was pulled")));
            }
            let count = cell.hear(now, self.link, bytes);
            if count > 0 {
                return Poll::Ready(Ok(count));
            }
            cell.listen(self.link, cx.waker());
            let Some(at) = cell.runner.poll_change() else {
                return Poll::Pending;
            };
            // Timers may fire slightly early, so even a past instant is waited for shortly.
            let Some(comes) = cell.comes(at.max(now.after_micros(1))) else {
                // Advancing the clock wakes this task; an event already due continues after the
                // others' turn.
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
        self.arm.lock().receive(self.link, bytes);
        Poll::Ready(Ok(bytes.len()))
    }

    fn lead(&mut self, leads: bool) -> bool {
        self.arm.lock().lead(self.link, leads)
    }

    fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        self.arm.lock().leap(self.link, most, to)
    }
}
