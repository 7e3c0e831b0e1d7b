//! Bytes that arrived while the line was not read.
//!
//! A reactor reports when bytes can be read, and it may be late: if a process was suspended
//! (stopped, or held in a debugger), its wait is interrupted and its timers fire first, while the
//! answer waits in the kernel. A request would then time out although it was answered. So a line
//! that was not read for a while is read directly, without asking the reactor, until it is empty.

use std::io;
use std::task::Poll;
use std::time::Duration;

use tokio::time::Instant;

/// Time without reads after which the line is read directly. Choice: longer than a busy scheduler's
/// delay.
const MAX_READ_GAP: Duration = Duration::from_millis(20);

/// State of the last read.
#[derive(Debug, Default)]
pub(crate) struct ReadGap {
    looked: Option<Instant>,
    /// True if the line was not read for a while, and not seen empty since.
    asks: bool,
}

impl ReadGap {
    /// Makes the next read direct, as after a long time without reads.
    pub(crate) fn ask(&mut self) {
        self.asks = true;
    }

    /// Returns the result of a read: that of the reactor (`told`), or else the bytes that `ask`
    /// reads directly without waiting; `None` from `ask` means no bytes.
    pub(crate) fn look(
        &mut self,
        told: Poll<io::Result<usize>>,
        ask: impl FnOnce() -> Option<usize>,
    ) -> Poll<io::Result<usize>> {
        let now = Instant::now();
        let before = self.looked.replace(now);
        // The first read counts as one after a long time: bytes may have arrived before.
        self.asks |=
            before.is_none_or(|before| now.saturating_duration_since(before) > MAX_READ_GAP);
        if told.is_ready() || !self.asks {
            return told;
        }
        let found = ask();
        self.asks = found.is_some();
        found.map_or(Poll::Pending, |count| Poll::Ready(Ok(count)))
    }
}

/// Reads available bytes without waiting. End and errors are left to the reactor.
#[cfg(unix)]
pub(super) fn read_now(fd: impl std::os::fd::AsFd, bytes: &mut [u8]) -> Option<usize> {
    let count = rustix::io::read(fd, bytes);
    count.ok().filter(|count| *count > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_line_is_asked_when_nobody_looked_for_a_while_and_until_it_is_empty() {
        let mut away = ReadGap::default();
        let mut there = 0;
        let mut look = async |passed: Duration, came: usize| {
            tokio::time::advance(passed).await;
            there += came;
            let before = there;
            let mut ask = || {
                there = usize::checked_sub(there, 1)?;
                Some(1)
            };
            while away.look(Poll::Pending, &mut ask).is_ready() {}
            before - there
        };
        assert_eq!(look(Duration::ZERO, 2).await, 2, "nobody has looked at all");
        assert_eq!(
            look(Duration::from_millis(1), 2).await,
            0,
            "the reactor tells"
        );
        assert_eq!(look(Duration::from_secs(5), 1).await, 3);
        assert_eq!(look(MAX_READ_GAP / 2, 1).await, 0);
    }
}
