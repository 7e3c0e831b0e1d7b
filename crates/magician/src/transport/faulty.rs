//! Transport with injected faults, for tests and `--faults`.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::time::{Instant, Sleep, sleep_until};

use super::{Leap, LeapTo, Transport};
use crate::connection::Micros;
use crate::faults::{Faults, Injector, Passed, Side};
use crate::{Error, ErrorCode, Result, message};

/// Fault that happens to the controller itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InjectedFault {
    /// The controller restarts.
    Reset,
    /// The cable was unplugged and is plugged in again.
    Replugged,
}

/// Applies an [`InjectedFault`] to a virtual arm.
pub(crate) type Restart = Box<dyn Fn(InjectedFault) + Send>;

/// Makes the random faults of the two directions differ.
const REPLY_SEED_MASK: u64 = 0x0DD5_1DE5;

/// Faults of a route; their sequence continues when the line is reopened.
#[derive(Clone)]
pub(super) struct FaultLayer {
    state: Arc<Mutex<State>>,
    faults: Faults,
    begun: Instant,
}

struct State {
    to_arm: Injector,
    to_host: Injector,
    /// Time until which the cable is unplugged.
    out_until: Option<Micros>,
}

impl FaultLayer {
    pub(super) fn new(faults: Faults) -> Self {
        let state = State {
            to_arm: Injector::new(faults.on(Side::Requests), faults.seed),
            to_host: Injector::new(faults.on(Side::Replies), faults.seed ^ REPLY_SEED_MASK),
            out_until: None,
        };
        Self {
            state: Arc::new(Mutex::new(state)),
            faults,
            begun: Instant::now(),
        }
    }

    /// Returns an error while the cable is unplugged.
    pub(super) fn reachable(&self, name: &str) -> Result<()> {
        let now = self.now();
        if self.lock().out_until.is_some_and(|until| now < until) {
            let message = message!(
                "{name} is unplugged by an injected fault; it comes back by itself",
                name
            );
            return Err(Error::new(ErrorCode::NoPort, message));
        }
        Ok(())
    }

    /// Wraps a line in the faults.
    pub(super) fn around(
        &self,
        inner: Box<dyn Transport>,
        restart: Option<Restart>,
        name: &str,
    ) -> Result<Faulty> {
        if self.faults.reset > 0.0 && restart.is_none() {
            return Err(Error::invalid(message!(
                "'reset' does not work on {name}: only a virtual arm in this process can be reset \
                    from here",
                name
            )));
        }
        let mut state = self.lock();
        if state.out_until.take().is_some()
            && let Some(restart) = &restart
        {
            restart(InjectedFault::Replugged);
        }
        // Bytes in flight on the previous line are lost.
        state.to_arm.plug_in();
        state.to_host.plug_in();
        drop(state);
        Ok(Faulty {
            inner,
            spoiler: self.clone(),
            restart,
            out: Vec::new(),
            come: Vec::new(),
            gone: false,
            timer: Box::pin(sleep_until(self.begun)),
        })
    }

    fn now(&self) -> Micros {
        Micros::try_from(self.begun.elapsed().as_micros()).unwrap_or(Micros::MAX)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Line with faults in both directions.
pub(super) struct Faulty {
    inner: Box<dyn Transport>,
    spoiler: FaultLayer,
    restart: Option<Restart>,
    /// Bytes on their way to the arm, after the faults.
    out: Vec<u8>,
    /// Bytes from the arm, after the faults.
    come: Vec<u8>,
    gone: bool,
    timer: Pin<Box<Sleep>>,
}

impl Faulty {
    /// Writes the chunks that are due. Each chunk is one write, and so one datagram.
    fn forward(&mut self, cx: &mut Context<'_>) -> io::Result<()> {
        while !self.gone {
            if !self.out.is_empty() {
                match self.inner.poll_write(cx, &self.out) {
                    Poll::Pending => return Ok(()),
                    Poll::Ready(Err(error)) => return Err(error),
                    Poll::Ready(Ok(0)) => return Err(io::ErrorKind::WriteZero.into()),
                    Poll::Ready(Ok(count)) => drop(self.out.drain(..count.min(self.out.len()))),
                }
                continue;
            }
            let now = self.spoiler.now();
            let passed = self.spoiler.lock().to_arm.poll(now);
            match passed {
                None => return Ok(()),
                Some(passed) => self.out = self.take(passed),
            }
        }
        Ok(())
    }

    /// Returns the bytes, or applies the fault instead and returns none.
    fn take(&mut self, passed: Passed) -> Vec<u8> {
        match passed {
            Passed::Bytes(bytes) => return bytes,
            Passed::Reset => {
                if let Some(restart) = &self.restart {
                    restart(InjectedFault::Reset);
                }
            }
            Passed::Unplugged => {
                self.gone = true;
                let until = self
                    .spoiler
                    .now()
                    .saturating_add(self.spoiler.faults.unplug_for);
                let mut state = self.spoiler.lock();
                state.out_until = Some(until);
            }
            // Unreachable in a published build too: the crates depend on each other by exact
            // version.
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
        Vec::new()
    }

    /// Fills `come` with the next chunk that is due.
    fn fetch(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            self.forward(cx)?;
            if self.gone {
                return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
            }
            let now = self.spoiler.now();
            let passed = self.spoiler.lock().to_host.poll(now);
            if let Some(passed) = passed {
                self.come = self.take(passed);
                if !self.come.is_empty() {
                    return Poll::Ready(Ok(()));
                }
                continue;
            }
            let mut bytes = [0; 2048];
            match self.inner.poll_read(cx, &mut bytes) {
                Poll::Ready(Ok(0)) => return Poll::Ready(Err(io::ErrorKind::UnexpectedEof.into())),
                Poll::Ready(Err(error)) => return Poll::Ready(Err(error)),
                Poll::Ready(Ok(count)) => {
                    let bytes = bytes.get(..count).unwrap_or_default();
                    self.spoiler.lock().to_host.push(now, bytes);
                }
                Poll::Pending if self.sleep(cx).is_pending() => return Poll::Pending,
                Poll::Pending => {}
            }
        }
    }

    /// Sleeps until the next chunk is due.
    fn sleep(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let next = {
            let state = self.spoiler.lock();
            let next = [state.to_arm.poll_timeout(), state.to_host.poll_timeout()];
            next.into_iter().flatten().min()
        };
        // With bytes left to write the line itself will wake the task.
        let Some(at) = next.filter(|_| self.out.is_empty()) else {
            return Poll::Pending;
        };
        // Timers may fire slightly early, so even a past instant is waited for shortly.
        let at = at.max(self.spoiler.now().saturating_add(1));
        let at = self.spoiler.begun + Duration::from_micros(at);
        self.timer.as_mut().reset(at);
        self.timer.as_mut().poll(cx)
    }
}

impl Transport for Faulty {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        if self.come.is_empty() {
            match self.fetch(cx) {
                Poll::Pending => return Poll::Pending,
                Poll::Ready(fetched) => fetched?,
            }
        }
        let count = self.come.len().min(bytes.len());
        let (come, after) = self.come.split_at(count);
        bytes[..count].copy_from_slice(come);
        self.come = after.to_vec();
        Poll::Ready(Ok(count))
    }

    fn ask(&mut self) {
        self.inner.ask();
    }

    /// Accepts everything at once. The timer is left to [`poll_read`](Transport::poll_read),
    /// because a last write may come after the end of the runtime.
    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if self.gone {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        let now = self.spoiler.now();
        self.spoiler.lock().to_arm.push(now, bytes);
        self.forward(cx)?;
        Poll::Ready(Ok(bytes.len()))
    }

    fn lead(&mut self, leads: bool) -> bool {
        self.inner.lead(leads)
    }

    /// Bytes delayed by a fault are delayed in wall-clock time, and the arm waits for them.
    fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        let held_up = {
            let state = self.spoiler.lock();
            let next = [state.to_arm.poll_timeout(), state.to_host.poll_timeout()];
            next.iter().any(Option::is_some)
        };
        let free = !held_up && self.out.is_empty() && self.come.is_empty();
        free.then(|| self.inner.leap(most, to))?
    }
}
