use std::io;

use tokio::signal::windows::{CtrlBreak, CtrlC, CtrlClose, CtrlShutdown};
use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_shutdown};

use super::Signal;

/// The console's events, caught from the moment of [`listen`](Self::listen).
pub(super) struct Signals {
    interrupt: CtrlC,
    /// What one program can send another; it cannot send Ctrl-C.
    brake: CtrlBreak,
    /// The window is closed. Windows gives a program 5 s then.
    close: CtrlClose,
    shutdown: CtrlShutdown,
}

impl Signals {
    /// Begins to catch them. Must be called within a runtime.
    pub(super) fn listen() -> io::Result<Self> {
        Ok(Self {
            interrupt: ctrl_c()?,
            brake: ctrl_break()?,
            close: ctrl_close()?,
            shutdown: ctrl_shutdown()?,
        })
    }

    /// Waits for the next.
    pub(super) async fn next(&mut self) -> Signal {
        tokio::select! {
            _ = self.interrupt.recv() => Signal::Interrupt,
            _ = self.brake.recv() => Signal::Terminate,
            _ = self.close.recv() => Signal::HangUp,
            _ = self.shutdown.recv() => Signal::HangUp,
        }
    }
}
