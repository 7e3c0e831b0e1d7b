//! Substitute on systems that do not report when a client opens or closes a terminal: every second
//! the exclusive flag that a killed client may have left is cleared. Unread replies wait for the
//! next client.

use std::io;
use std::path::Path;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior, interval};

/// True if clients cannot be detected.
pub(super) const BLIND: bool = true;

pub(super) struct Watch {
    interval: Interval,
}

/// Event at the terminal: a second passed. Nothing else is visible here.
pub(super) struct Seen {
    pub(super) opened: bool,
    pub(super) closed: bool,
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
        Ok(self.interval.poll_tick(cx).map(|_| Seen {
            opened: false,
            closed: false,
        }))
    }
}
