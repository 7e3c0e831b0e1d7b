use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use magician_sim::{Controller, Line, LinkId, Micros, Profile, Runner, Speed};
use tokio::time::{Instant, Sleep, sleep_until};

use super::Transport;
use crate::SimSpeed;

const LINK: LinkId = LinkId(0);

/// A virtual arm in this process.
pub(crate) struct Sim {
    runner: Runner,
    begun: Instant,
    alarm: Pin<Box<Sleep>>,
}

impl Sim {
    /// An arm that has just been switched on, at the end of a line that takes no time.
    pub(crate) fn powered_up(speed: SimSpeed) -> Self {
        let speed = match speed {
            SimSpeed::Max => Speed::Max,
            SimSpeed::Times(times) => Speed::Times(times),
        };
        let line = Line {
            baud: None,
            turnaround: 0,
        };
        Self::new(Runner::new(
            Controller::new(Profile::default()),
            speed,
            line,
        ))
    }

    pub(crate) fn new(runner: Runner) -> Self {
        let begun = Instant::now();
        Self {
            runner,
            begun,
            alarm: Box::pin(sleep_until(begun)),
        }
    }

    fn now(&self) -> Micros {
        let micros = self.begun.elapsed().as_micros();
        Micros::try_from(micros).unwrap_or(Micros::MAX)
    }
}

impl Transport for Sim {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        loop {
            let now = self.now();
            self.runner.handle_timeout(now);
            if let Some(frame) = self.runner.poll_transmit(now, LINK) {
                let frame = frame.bytes();
                let count = frame.len().min(bytes.len());
                bytes[..count].copy_from_slice(&frame[..count]);
                return Poll::Ready(Ok(count));
            }
            let Some(at) = self.runner.poll_timeout() else {
                return Poll::Pending;
            };
            // Timers may fire a little early; an instant that has come is waited for a moment.
            let at = at.max(now + 1);
            self.alarm
                .as_mut()
                .reset(self.begun + Duration::from_micros(at));
            if self.alarm.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
    }

    fn poll_write(&mut self, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let now = self.now();
        self.runner.receive(now, LINK, bytes);
        Poll::Ready(Ok(bytes.len()))
    }
}
