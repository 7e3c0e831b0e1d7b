//! Job control: requests to suspend this program (Ctrl-Z, SIGTSTP) and its continuation (SIGCONT).
//!
//! A program that is suspended in the middle of a motion leaves the arm without its host, so a verb
//! with a running job catches the request, brings the arm to rest and then suspends itself. While
//! no such verb listens, the system's default applies.

use std::io;

/// Event of job control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Control {
    /// This program shall suspend itself once it is ready.
    Suspend,
    /// This program continues or shall continue.
    Continue,
}

/// Listener for job control. While it exists, a request to suspend is reported and not obeyed;
/// otherwise the system obeys it.
pub(crate) struct JobControl {
    #[cfg(unix)]
    pipes: Option<unix::SignalPipes>,
}

impl JobControl {
    /// Begins to listen; must be called within a runtime. If the parent process set SIGTSTP to be
    /// ignored, it stays ignored.
    pub(crate) fn listen() -> io::Result<Self> {
        #[cfg(unix)]
        {
            let pipes = unix::SignalPipes::listen()?;
            Ok(Self { pipes })
        }
        #[cfg(not(unix))]
        Ok(Self {})
    }

    /// Waits for the next event. Never completes where there is no job control.
    pub(crate) async fn next(&mut self) -> Control {
        #[cfg(unix)]
        if let Some(pipes) = &mut self.pipes {
            return pipes.next().await;
        }
        std::future::pending().await
    }

    /// Returns an event that has already come, if any; the continuation if both have.
    pub(crate) fn take(&mut self) -> Option<Control> {
        #[cfg(unix)]
        return self.pipes.as_mut()?.take();
        #[cfg(not(unix))]
        None
    }

    /// Suspends this process until it is continued, which [`next`](Self::next) then reports.
    pub(crate) fn stop_process() {
        #[cfg(unix)]
        unix::stop_process();
    }
}

#[cfg(unix)]
mod unix {
    use std::future::pending;
    use std::io;
    use std::os::unix::net::UnixStream as Pipe;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::sync::{Arc, OnceLock};

    use rustix::process::{Signal, getpid, kill_process};
    use signal_hook::SigId;
    use signal_hook::consts::{SIGCONT, SIGTSTP};
    use signal_hook::{flag, low_level};
    use tokio::net::UnixStream;

    use super::Control;
    use crate::interrupt::unix::is_ignored;

    /// Number of current listeners.
    static LISTENERS: AtomicUsize = AtomicUsize::new(0);
    /// True while there is no listener, so that the system's default applies. `None` inside if the
    /// signal was ignored from the start.
    static DEFAULT_APPLIES: OnceLock<Option<Arc<AtomicBool>>> = OnceLock::new();

    /// Returns the flag of the default handler, installed at the first call: a handler stays for
    /// the life of the process.
    fn default_applies() -> Option<&'static AtomicBool> {
        let default_applies = DEFAULT_APPLIES.get_or_init(|| {
            if is_ignored(SIGTSTP) {
                return None;
            }
            let default_applies = Arc::new(AtomicBool::new(true));
            let kept = flag::register_conditional_default(SIGTSTP, Arc::clone(&default_applies));
            kept.ok().map(|_| default_applies)
        });
        default_applies.as_deref()
    }

    pub(super) struct SignalPipes {
        suspend: SignalPipe,
        resume: SignalPipe,
    }

    impl SignalPipes {
        pub(super) fn listen() -> io::Result<Option<Self>> {
            let Some(default_applies) = default_applies() else {
                return Ok(None);
            };
            let resume = SignalPipe::of(SIGCONT)?;
            let suspend = SignalPipe::of(SIGTSTP)?;
            LISTENERS.fetch_add(1, Ordering::SeqCst);
            default_applies.store(false, Ordering::SeqCst);
            // The system has already obeyed a request from before the listener, and this program
            // has been continued since.
            if resume.take() {
                suspend.take();
            }
            Ok(Some(Self { suspend, resume }))
        }

        pub(super) async fn next(&mut self) -> Control {
            tokio::select! {
                // If both have come their order is unknown. Reporting the suspension first leaves
                // the program running, and a running program can be suspended again.
                biased;
                () = self.suspend.next() => Control::Suspend,
                () = self.resume.next() => Control::Continue,
            }
        }

        pub(super) fn take(&mut self) -> Option<Control> {
            let suspend = self.suspend.take().then_some(Control::Suspend);
            let resume = self.resume.take().then_some(Control::Continue);
            resume.or(suspend)
        }
    }

    impl Drop for SignalPipes {
        fn drop(&mut self) {
            if LISTENERS.fetch_sub(1, Ordering::SeqCst) == 1
                && let Some(default_applies) = default_applies()
            {
                default_applies.store(true, Ordering::SeqCst);
            }
        }
    }

    /// A signal to wait for. Signals from before its creation do not count.
    struct SignalPipe {
        pipe: UnixStream,
        id: SigId,
    }

    impl SignalPipe {
        fn of(signal: i32) -> io::Result<Self> {
            let (read, write) = Pipe::pair()?;
            read.set_nonblocking(true)?;
            let id = low_level::pipe::register(signal, write)?;
            let pipe = UnixStream::from_std(read).inspect_err(|_| {
                low_level::unregister(id);
            })?;
            Ok(Self { pipe, id })
        }

        /// Waits for the signal. Several that came meanwhile count as one.
        async fn next(&mut self) {
            loop {
                if self.pipe.readable().await.is_err() {
                    return pending().await;
                }
                if self.take() {
                    return;
                }
            }
        }

        fn take(&self) -> bool {
            matches!(self.pipe.try_read(&mut [0; 64]), Ok(1..))
        }
    }

    impl Drop for SignalPipe {
        fn drop(&mut self) {
            low_level::unregister(self.id);
        }
    }

    pub(super) fn stop_process() {
        // A failure leaves the process running: it then only waits for SIGCONT.
        let _ = kill_process(getpid(), Signal::STOP);
    }
}
