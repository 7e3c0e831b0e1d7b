//! Ctrl-C, a wish of the system to end or to suspend, and a terminal that is closed, as something to wait for.

mod control;
#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

use std::io;

pub(crate) use control::{Control, JobControl};
#[cfg(unix)]
use unix as system;
#[cfg(windows)]
use windows as system;

/// What the user or the system wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, the terminal is closed, or what comes nearest.
    Terminate,
}

/// The signals, caught from the moment of [`listen`](Self::listen).
pub(crate) struct Signals {
    caught: system::Signals,
    terminates: bool,
}

impl Signals {
    /// Begins to catch them. Must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        Ok(Self {
            caught: system::Signals::listen()?,
            terminates: false,
        })
    }

    /// Waits for the next.
    pub(crate) async fn next(&mut self) -> Signal {
        let signal = self.caught.next().await;
        self.terminates |= signal == Signal::Terminate;
        signal
    }

    /// Whether one of those that were waited for wants this program to end, more lines or not.
    pub(crate) fn terminates(&self) -> bool {
        self.terminates
    }
}
