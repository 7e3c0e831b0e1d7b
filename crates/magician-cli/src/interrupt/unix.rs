use std::future::pending;
use std::io::{self, IsTerminal};

use tokio::signal::unix::{self, SignalKind, signal};

use super::Signal;

/// The signals, caught from the moment of [`listen`](Self::listen).
pub(crate) struct Signals {
    interrupt: unix::Signal,
    terminate: unix::Signal,
    /// Only at a terminal: who is to outlive one has been started with `nohup`, which leaves none on stderr.
    hangup: Option<unix::Signal>,
}

impl Signals {
    /// Begins to catch them. Must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        let at_terminal = io::stderr().is_terminal();
        let hangup = at_terminal.then(|| signal(SignalKind::hangup()));
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hangup: hangup.transpose()?,
        })
    }

    /// Waits for the next.
    pub(crate) async fn next(&mut self) -> Signal {
        let hung_up = async {
            match &mut self.hangup {
                Some(hangup) => hangup.recv().await,
                None => pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.recv() => Signal::Interrupt,
            _ = self.terminate.recv() => Signal::Terminate,
            _ = hung_up => Signal::Terminate,
        }
    }
}
