//! Job control: the wish of a terminal, a shell or the system to suspend this program (Ctrl-Z, SIGTSTP), and its going on
//! (SIGCONT).

use std::io;

/// What job control wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Control {
    /// This program is to be suspended, when it is ready for that.
    Suspend,
    /// It runs, or is to run again.
    Continue,
}

/// While it lasts, a wish to suspend this program is heard and not followed. Before and afterwards the system follows it.
pub(crate) struct JobControl {
    #[cfg(unix)]
    heard: Option<unix::Heard>,
}

impl JobControl {
    /// Begins to hear; must be called within a runtime. A program whose parent had it ignore the wish goes on ignoring it.
    pub(crate) fn listen() -> io::Result<Self> {
        #[cfg(unix)]
        {
            let heard = unix::Heard::listen()?;
            Ok(Self { heard })
        }
        #[cfg(not(unix))]
        Ok(Self {})
    }

    /// Waits for the next wish; for ever where there is no job control.
    pub(crate) async fn next(&mut self) -> Control {
        #[cfg(unix)]
        if let Some(heard) = &mut self.heard {
            return heard.next().await;
        }
        std::future::pending().await
    }

    /// What has come already, if anything: the going on where both have.
    pub(crate) fn take(&mut self) -> Option<Control> {
        #[cfg(unix)]
        return self.heard.as_mut()?.take();
        #[cfg(not(unix))]
        None
    }

    /// Stops this program, until it is continued: [`next`](Self::next) tells that.
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

    /// The current listeners.
    static LISTENERS: AtomicUsize = AtomicUsize::new(0);
    /// Whether the system's default is followed, because there is no listener. None where the signal was ignored from the
    /// start.
    static FOLLOWED: OnceLock<Option<Arc<AtomicBool>>> = OnceLock::new();

    /// What follows the wish while there is no listener: a handler that was set once stays for good.
    fn followed() -> Option<&'static AtomicBool> {
        let followed = FOLLOWED.get_or_init(|| {
            if is_ignored(SIGTSTP) {
                return None;
            }
            let followed = Arc::new(AtomicBool::new(true));
            let kept = flag::register_conditional_default(SIGTSTP, Arc::clone(&followed));
            kept.ok().map(|_| followed)
        });
        followed.as_deref()
    }

    pub(super) struct Heard {
        suspend: Wake,
        goes_on: Wake,
    }

    impl Heard {
        pub(super) fn listen() -> io::Result<Option<Self>> {
            let Some(followed) = followed() else {
                return Ok(None);
            };
            let goes_on = Wake::of(SIGCONT)?;
            let suspend = Wake::of(SIGTSTP)?;
            LISTENERS.fetch_add(1, Ordering::SeqCst);
            followed.store(false, Ordering::SeqCst);
            // A wish that came in between has been followed by the system, and this program has been continued since.
            if goes_on.take() {
                suspend.take();
            }
            Ok(Some(Self { suspend, goes_on }))
        }

        pub(super) async fn next(&mut self) -> Control {
            tokio::select! {
                // If both have come their order is unknown: a program that runs on can be suspended again.
                biased;
                () = self.suspend.next() => Control::Suspend,
                () = self.goes_on.next() => Control::Continue,
            }
        }

        pub(super) fn take(&mut self) -> Option<Control> {
            let suspend = self.suspend.take().then_some(Control::Suspend);
            let goes_on = self.goes_on.take().then_some(Control::Continue);
            goes_on.or(suspend)
        }
    }

    impl Drop for Heard {
        fn drop(&mut self) {
            if LISTENERS.fetch_sub(1, Ordering::SeqCst) == 1
                && let Some(followed) = followed()
            {
                followed.store(true, Ordering::SeqCst);
            }
        }
    }

    /// A signal that is waited for. A signal from before the wait began is not heard.
    struct Wake {
        pipe: UnixStream,
        id: SigId,
    }

    impl Wake {
        fn of(signal: i32) -> io::Result<Self> {
            let (read, write) = Pipe::pair()?;
            read.set_nonblocking(true)?;
            let id = low_level::pipe::register(signal, write)?;
            let pipe = UnixStream::from_std(read).inspect_err(|_| {
                low_level::unregister(id);
            })?;
            Ok(Self { pipe, id })
        }

        /// Waits for it. Several that came meanwhile are one.
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

    impl Drop for Wake {
        fn drop(&mut self) {
            low_level::unregister(self.id);
        }
    }

    pub(super) fn stop_process() {
        // A process that cannot be stopped runs on, and still waits to be continued.
        let _ = kill_process(getpid(), Signal::STOP);
    }
}
