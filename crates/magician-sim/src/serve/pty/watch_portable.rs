//! Systems that do not tell when a client opens or closes a terminal: every second the exclusive
//! flag that a killed client may have left is cleared. Replies that were not read wait for the next
//! client.

use std::io;
use std::path::Path;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior, interval};

pub(super) struct Watch {
    interval: Interval,
}

/// What happened to the terminal.
pub(super) enum Seen {
    /// A client opened it.
    #[expect(dead_code, reason = "cannot be seen here")]
    Opened,
    /// A client closed it.
    #[expect(dead_code, reason = "cannot be seen here")]
    Closed,
    /// Nothing that could be seen, for a second.
    Nothing,
}

impl Watch {
    pub(super) fn new(_: &Path) -> io::Result<Self> {
        let mut interval = interval(Duration::from_secs(1));
        interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Ok(Self { interval })
    }

    #[expect(clippy::unnecessary_wraps, clippy::unused_self, reason = "as on Linux")]
    pub(super) fn pause(&mut self) -> io::Result<()> {
        Ok(())
    }

    #[expect(clippy::unnecessary_wraps, clippy::unused_self, reason = "as on Linux")]
    pub(super) fn resume(&mut self, _: &Path) -> io::Result<()> {
        Ok(())
    }

    pub(super) fn poll(&mut self, cx: &mut Context<'_>) -> io::Result<Poll<Seen>> {
        Ok(self.interval.poll_tick(cx).map(|_| Seen::Nothing))
    }
}
