//! Precise timer. A reply of 38 bytes takes 3.3 ms on the line, so milliseconds are too coarse for
//! pacing. Linux has timers precise to a few microseconds; other systems use the runtime's
//! milliseconds.

use std::task::{Context, Poll};
use std::time::{Duration, Instant};

#[cfg(target_os = "linux")]
pub(super) use linux::Timer;
#[cfg(not(target_os = "linux"))]
pub(super) use portable::Timer;

#[cfg(target_os = "linux")]
mod linux {
    use super::{Context, Duration, Instant, Poll};
    use std::io;
    use std::os::fd::OwnedFd;

    use rustix::time::{
        Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec, timerfd_create,
        timerfd_settime,
    };
    use tokio::io::Interest;
    use tokio::io::unix::AsyncFd;

    use super::super::reactor::register;

    pub(in super::super) struct Timer {
        fd: AsyncFd<OwnedFd>,
        armed: Option<Instant>,
    }

    impl Timer {
        pub(in super::super) fn new() -> io::Result<Self> {
            let flags = TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK;
            let fd = timerfd_create(TimerfdClockId::Monotonic, flags)?;
            Ok(Self {
                fd: register(fd, Interest::READABLE)?,
                armed: None,
            })
        }

        /// Ready if `wait` has passed or may have; otherwise wakes the task then, or earlier.
        pub(in super::super) fn poll(&mut self, cx: &mut Context<'_>, wait: Duration) -> Poll<()> {
            if wait.is_zero() {
                return Poll::Ready(());
            }
            while let Poll::Ready(guard) = self.fd.poll_read_ready(cx) {
                let Ok(mut guard) = guard else {
                    return Poll::Ready(());
                };
                let mut count = [0; 8];
                match guard.try_io(|fd| Ok(rustix::io::read(fd, &mut count)?)) {
                    // The readiness was stale; `try_io` has cleared it.
                    Err(_) => {}
                    Ok(_) => self.armed = None,
                }
            }
            // Deadlines mostly move away, and an early wake-up costs less than setting the timer
            // again.
            let at = Instant::now() + wait;
            if self.armed.is_none_or(|armed| at < armed) {
                let timer = Itimerspec {
                    it_interval: Timespec::default(),
                    it_value: timespec(wait),
                };
                if timerfd_settime(&self.fd, TimerfdTimerFlags::empty(), &timer).is_err() {
                    return Poll::Ready(());
                }
                self.armed = Some(at);
            }
            Poll::Pending
        }
    }

    fn timespec(wait: Duration) -> Timespec {
        Timespec {
            // Seconds beyond the type's range are as good as forever.
            tv_sec: i64::try_from(wait.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(wait.subsec_nanos()),
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod portable {
    use super::{Context, Duration, Instant, Poll};
    use std::future::Future;
    use std::io;
    use std::pin::Pin;

    pub(in super::super) struct Timer {
        sleep: Pin<Box<tokio::time::Sleep>>,
        armed: Option<Instant>,
    }

    impl Timer {
        pub(in super::super) fn new() -> io::Result<Self> {
            Ok(Self {
                sleep: Box::pin(tokio::time::sleep(Duration::ZERO)),
                armed: None,
            })
        }

        /// Ready if `wait` has passed or may have; otherwise wakes the task then, or earlier.
        pub(in super::super) fn poll(&mut self, cx: &mut Context<'_>, wait: Duration) -> Poll<()> {
            if wait.is_zero() {
                return Poll::Ready(());
            }
            let now = Instant::now();
            // A day is long enough for another look, and short enough for any clock.
            let at = now + wait.min(Duration::from_secs(86_400));
            if self.armed.is_none_or(|armed| at < armed || armed <= now) {
                self.sleep.as_mut().reset(at.into());
                self.armed = Some(at);
            }
            self.sleep.as_mut().poll(cx)
        }
    }
}
