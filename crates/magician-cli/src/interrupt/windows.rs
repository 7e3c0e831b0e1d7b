//! Signals on Windows: the console's control events as tokio streams.

use std::io;

use tokio::signal::windows::{CtrlBreak, CtrlC, CtrlClose, CtrlShutdown};
use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_shutdown};

use super::Signal;

/// Console events, caught from [`listen`](Self::listen) on.
pub(super) struct Signals {
    interrupt: CtrlC,
    /// Ctrl-Break: the only event that one program can send to another.
    brake: CtrlBreak,
    /// Window closed. Windows ends the process about 5 s later.
    close: CtrlClose,
    shutdown: CtrlShutdown,
}

impl Signals {
    /// Begins to catch events. Must be called within a runtime.
    pub(super) fn listen() -> io::Result<Self> {
        Ok(Self {
            interrupt: ctrl_c()?,
            brake: ctrl_break()?,
            close: ctrl_close()?,
            shutdown: ctrl_shutdown()?,
        })
    }

    /// Waits for the next event.
    pub(super) async fn next(&mut self) -> Signal {
        tokio::select! {
            _ = self.interrupt.recv() => Signal::Interrupt,
            _ = self.brake.recv() => Signal::Terminate,
            _ = self.close.recv() => Signal::HangUp,
            _ = self.shutdown.recv() => Signal::HangUp,
        }
    }
}
