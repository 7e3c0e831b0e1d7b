//! Ctrl-C, the system's requests to end or to suspend, and a closed terminal, as events to await.
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

/// Makes a write beyond the file size limit (`ulimit -f`) fail instead of ending the process. Only
/// for the command: in a library the signals belong to the host program.
pub(crate) fn survive_file_limit() -> io::Result<()> {
    #[cfg(unix)]
    system::survive_file_limit()?;
    Ok(())
}

/// Signals, caught from [`listen`](Self::listen) on.
pub(crate) struct Signals {
    caught: system::Signals,
    rule: StopRule,
    begun: Instant,
    terminates: bool,
}

impl Signals {
    /// Begins to catch signals. Must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        Ok(Self {
            caught: system::Signals::listen()?,
            rule: StopRule::default(),
            begun: Instant::now(),
            terminates: false,
        })
    }

    /// Begins to catch signals after `first`, which counts as the first stop.
    pub(crate) fn listen_after(first: Signal) -> io::Result<Self> {
        let mut signals = Self::listen()?;
        signals.next_stop(first);
        Ok(signals)
    }

    /// Waits for the next stop: the first call for the first stop, the second call for a second
    /// stop, which moves nothing more. Other signals have no effect.
    pub(crate) async fn next(&mut self) -> Signal {
        self.next_order().await.0
    }

    /// Waits for the next stop, and returns its signal and its order.
    pub(crate) async fn next_order(&mut self) -> (Signal, StopOrder) {
        loop {
            let signal = self.caught.next().await;
            self.terminates |= signal != Signal::Interrupt;
            if let Some(order) = self.next_stop(signal) {
                return (signal, order);
            }
        }
    }

    /// Returns the order that follows from a signal now, or from a key that stands for one; `None`
    /// if the rule ignores it.
    pub(crate) fn next_stop(&mut self, signal: Signal) -> Option<StopOrder> {
        self.rule.order_for(signal, self.begun.elapsed())
    }

    /// True if one of the signals asks the program to end, even a shell.
    pub(crate) fn terminates(&self) -> bool {
        self.terminates
    }
}
