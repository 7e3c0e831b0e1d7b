//! Ctrl-C, the system's request to end or to suspend, and a closed terminal, as something to wait for.
//!
//! [`StopRule`] decides which of them count: every verb hears at most a first stop and a second one.

mod control;
#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

use std::io;
use std::time::Instant;

pub(crate) use control::{Control, JobControl};
pub(crate) use magician_job::StopSignal as Signal;
use magician_job::{StopOrder, StopRule};
#[cfg(unix)]
use unix as system;
#[cfg(windows)]
use windows as system;

/// Makes a write beyond the limit for the size of files an error of that write, not the end of the process.
/// For the command alone: in a library the signals are the host program's.
pub(crate) fn survive_file_limit() -> io::Result<()> {
    #[cfg(unix)]
    system::survive_file_limit()?;
    Ok(())
}

/// The signals, caught from the moment of [`listen`](Self::listen).
pub(crate) struct Signals {
    caught: system::Signals,
    rule: StopRule,
    begun: Instant,
    terminates: bool,
}

impl Signals {
    /// Begins to catch them. Must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        Ok(Self {
            caught: system::Signals::listen()?,
            rule: StopRule::default(),
            begun: Instant::now(),
            terminates: false,
        })
    }

    /// Begins to catch them after a signal that was the first stop.
    pub(crate) fn listen_after(first: Signal) -> io::Result<Self> {
        let mut signals = Self::listen()?;
        signals.hears(first);
        Ok(signals)
    }

    /// Waits for the next stop: the first call for the first one, the second call for a second stop, which
    /// moves nothing more. Signals that are neither are heard and change nothing.
    pub(crate) async fn next(&mut self) -> Signal {
        self.next_order().await.0
    }

    /// Waits for the next stop, and returns its signal and its order.
    pub(crate) async fn next_order(&mut self) -> (Signal, StopOrder) {
        loop {
            let signal = self.caught.next().await;
            self.terminates |= signal != Signal::Interrupt;
            if let Some(order) = self.hears(signal) {
                return (signal, order);
            }
        }
    }

    /// Order that follows from a signal that comes now, or from a key that stands for one.
    pub(crate) fn hears(&mut self, signal: Signal) -> Option<StopOrder> {
        self.rule.hears(signal, self.begun.elapsed())
    }

    /// True if one of the signals asks this program to end, more lines or not.
    pub(crate) fn terminates(&self) -> bool {
        self.terminates
    }
}
