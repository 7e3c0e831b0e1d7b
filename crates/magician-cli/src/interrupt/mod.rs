//! Ctrl-C, a wish of the system to end or to suspend, and a terminal that is closed, as something to wait for.

mod control;
#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

pub(crate) use control::{Control, JobControl};
#[cfg(unix)]
pub(crate) use unix::Signals;
#[cfg(windows)]
pub(crate) use windows::Signals;

/// What the user or the system wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, the terminal is closed, or what comes nearest.
    Terminate,
}
