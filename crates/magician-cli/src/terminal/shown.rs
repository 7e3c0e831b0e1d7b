//! The thread that has the terminal.

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

/// How long a terminal has to take the last frame before it is left as it is.
const PATIENCE: Duration = Duration::from_secs(1);

/// A picture while it is shown. Dropping this ends it, too, and says nothing.
pub(crate) struct Shown {
    thread: Option<JoinHandle<io::Result<()>>>,
    stop: Arc<AtomicBool>,
    /// Closed when the thread is done.
    alive: mpsc::Receiver<()>,
}

impl Shown {
    /// Shows it on a thread, until `work` is done; it looks at the flag now and then, and ends when that is set.
    pub(crate) fn begin(
        work: impl FnOnce(&AtomicBool) -> io::Result<()> + Send + 'static,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (holds, alive) = mpsc::channel();
        let told = Arc::clone(&stop);
        let work = move || {
            // Dropped when this is done, also by a panic.
            let _alive: mpsc::Sender<()> = holds;
            work(&told)
        };
        let thread = thread::Builder::new().name("picture".into()).spawn(work)?;
        Ok(Self {
            thread: Some(thread),
            stop,
            alive,
        })
    }

    /// Ends the picture and gives the terminal back.
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
        if self.alive.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout) {
            // The terminal takes nothing more: what would be written to it now would wait too.
            screen::give_back_mode();
            return None;
        }
        Some(thread.join())
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.end();
    }
}

/// The wish of a shell or the system to suspend this program, which is heard and not followed: the shell would take the terminal's
/// mode, and an arm that was jogging would jog on without end.
pub(crate) struct Suspends(JobControl);

impl Suspends {
    /// Begins to hear it; must be called within a runtime.
    pub(crate) fn listen() -> io::Result<Self> {
        JobControl::listen().map(Self)
    }

    /// Waits for the next one.
    pub(crate) async fn next(&mut self) {
        while self.0.next().await != Control::Suspend {}
    }
}

/// Waits until the terminal that controls this program is gone.
pub(crate) async fn hung_up() {
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
