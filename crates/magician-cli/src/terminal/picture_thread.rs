//! Thread that owns the terminal, and the signals that concern it.

use std::future::pending;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use magician::ErrorKind;

use super::screen;
use crate::failure::{Failure, Kind};
use crate::interrupt::{Control, JobControl};

/// Longest wait for the terminal to accept the last frame. A choice: a stalled terminal (Ctrl-S, a
/// dead SSH session) must not keep the program from ending.
const LAST_FRAME_TIMEOUT: Duration = Duration::from_secs(1);

/// Picture on its own thread. Dropping it ends the picture without reporting errors.
pub(crate) struct PictureThread {
    thread: Option<JoinHandle<io::Result<()>>>,
    stop: Arc<AtomicBool>,
    /// Disconnected when the thread ends, also by a panic.
    alive: mpsc::Receiver<()>,
}

impl PictureThread {
    /// Starts `work` on a thread. It must check the flag regularly and return once it is set.
    pub(crate) fn begin(
        work: impl FnOnce(&AtomicBool) -> io::Result<()> + Send + 'static,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (holds, alive) = mpsc::channel();
        let stopping = Arc::clone(&stop);
        let work = move || {
            // Dropped when `work` returns or panics, which wakes the receiver.
            let _alive: mpsc::Sender<()> = holds;
            work(&stopping)
        };
        let thread = thread::Builder::new().name("picture".into()).spawn(work)?;
        Ok(Self {
            thread: Some(thread),
            stop,
            alive,
        })
    }

    /// Ends the picture and restores the terminal.
    pub(crate) fn finish(mut self) -> Result<(), Failure> {
        match self.end() {
            None | Some(Ok(Ok(()))) => Ok(()),
            Some(Ok(Err(error))) => {
                let message = format!("cannot draw on the terminal: {error}");
                Err(Failure::new(Kind::Driver(ErrorKind::Closed), message))
            }
            Some(Err(panic)) => std::panic::resume_unwind(panic),
        }
    }

    fn end(&mut self) -> Option<thread::Result<io::Result<()>>> {
        let thread = self.thread.take()?;
        self.stop.store(true, Ordering::Relaxed);
        if self.alive.recv_timeout(LAST_FRAME_TIMEOUT) == Err(mpsc::RecvTimeoutError::Timeout) {
            // A terminal that accepts no output would block escape sequences too, so only its mode
            // is restored.
            screen::restore_mode();
            return None;
        }
        Some(thread.join())
    }
}

impl Drop for PictureThread {
    fn drop(&mut self) {
        self.end();
    }
}

/// Requests to suspend this program, caught and not obeyed: a stopped process could not end a jog,
/// and the shell would change the terminal's mode.
pub(crate) struct SuspendRequests(JobControl);

impl SuspendRequests {
    /// Begins to listen; must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        JobControl::listen().map(Self)
    }

    /// Waits for the next request.
    pub(crate) async fn next(&mut self) {
        while self.0.next().await != Control::Suspend {}
    }
}

/// Waits until the controlling terminal is gone.
pub(crate) async fn wait_for_hangup() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut signal) = signal(SignalKind::hangup()) {
            signal.recv().await;
            return;
        }
    }
    pending().await
}
