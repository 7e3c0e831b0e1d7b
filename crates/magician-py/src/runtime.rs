//! Threads of the package in this process: one runs all connections, the other calls Python.
//!
//! The first never takes the interpreter's lock, so that a stop is sent in time however long Python
//! code holds it. Notifications for Python (an event loop that a call has ended, `logging` of a
//! warning) are delivered by the second.
//!
//! A fork does not copy threads to the child. Each process therefore has its own pair, and objects
//! that were connected before a fork are unusable in the child.

use std::future::Future;
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::thread;

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use tokio::runtime::{Builder, Handle, Runtime};
use tokio::task::AbortHandle;

use magician::{Error, ErrorCode};

use crate::{errors, logging};

/// Notification for Python.
pub(crate) enum Notification {
    /// A call has changed: invoke its listener.
    Call(Arc<Py<PyAny>>),
    /// Log record.
    Log(logging::Record),
    /// The interpreter is ending: the last notification.
    Last,
}

struct Process {
    id: u32,
    handle: Handle,
    news: Sender<Notification>,
    speaker: thread::JoinHandle<()>,
    next: OnceLock<Box<Process>>,
}

/// Linked list of processes, from the one with the first import to the current one. It is only
/// extended while the interpreter's lock is held, so that no fork copies it half done.
static FIRST_PROCESS: OnceLock<Box<Process>> = OnceLock::new();

fn failed(error: io::Error) -> Error {
    let message = format!("the system cannot create a timer, poller or thread: {error}");
    Error::new(ErrorCode::PortFailed, message)
}

fn runtime() -> Result<Runtime, Error> {
    let runtime = Builder::new_current_thread().enable_all().build();
    runtime.map_err(failed)
}

/// Runs work on a separate thread and runtime, if it would delay the connections otherwise.
///
/// # Errors
/// The system provides no thread, timer or poller.
pub(crate) fn spawn_separately<T: Send + 'static>(
    name: &str,
    work: impl FnOnce(&Runtime) -> T + Send + 'static,
) -> Result<thread::JoinHandle<T>, Error> {
    let runtime = runtime()?;
    let thread = thread::Builder::new().name(name.to_owned());
    thread.spawn(move || work(&runtime)).map_err(failed)
}

impl Process {
    fn start(id: u32) -> Result<Self, Error> {
        let runtime = runtime()?;
        let handle = runtime.handle().clone();
        let (news, notifications) = channel();
        // Drives the runtime until the process ends.
        let serve = move || runtime.block_on(std::future::pending::<()>());
        let thread = |name: &str| thread::Builder::new().name(name.to_owned());
        thread("magician").spawn(serve).map_err(failed)?;
        let speaker = thread("magician-news").spawn(move || deliver_notifications(&notifications));
        let speaker = speaker.map_err(failed)?;
        Ok(Self {
            id,
            handle,
            news,
            speaker,
            next: OnceLock::new(),
        })
    }

    /// Returns the entry of the current process. `None` before its threads are started.
    fn known() -> Option<&'static Self> {
        let id = std::process::id();
        let mut slot = &FIRST_PROCESS;
        while let Some(process) = slot.get() {
            if process.id == id {
                return Some(process);
            }
            slot = &process.next;
        }
        None
    }
}

/// Delivers notifications until the interpreter ends.
fn deliver_notifications(notifications: &Receiver<Notification>) {
    for news in notifications {
        match news {
            Notification::Last => return,
            // Errors are dropped: an event loop that was closed meanwhile needs no notification.
            Notification::Call(listener) => Python::attach(|py| drop(listener.call0(py))),
            Notification::Log(record) => Python::attach(|py| record.write(py)),
        }
    }
}

/// Admits the first interpreter of a process and refuses others, because the package has global
/// state.
///
/// # Errors
/// `ImportError` for any other interpreter.
pub(crate) fn first_interpreter(py: Python<'_>) -> PyResult<()> {
    static FIRST_PROCESS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    // Identifies the interpreter: each has its own `sys.modules`.
    let modules = py.import("sys")?.getattr("modules")?;
    if modules.is(FIRST_PROCESS.get_or_init(py, || modules.clone().unbind())) {
        Ok(())
    } else {
        Err(PyImportError::new_err(
            "magician works in one interpreter of a process, and another one uses it",
        ))
    }
}

/// Starts the threads of this process if necessary.
///
/// # Errors
/// `magician.errors.PortError` if the system provides no threads.
pub(crate) fn ready(py: Python<'_>) -> PyResult<()> {
    if Process::known().is_some() {
        return Ok(());
    }
    // Not at import: if the `magician` command runs in this process, it installs its own log.
    logging::begin();
    let process = Process::start(std::process::id()).map_err(|error| errors::raise(py, &error))?;
    let mut slot = &FIRST_PROCESS;
    while let Some(before) = slot.get() {
        slot = &before.next;
    }
    let _ = slot.set(Box::new(process));
    Ok(())
}

/// Spawns a task on the runtime of the connections. Returns `None` if this process has none.
pub(crate) fn spawn(task: impl Future<Output = ()> + Send + 'static) -> Option<AbortHandle> {
    let process = Process::known()?;
    Some(process.handle.spawn(task).abort_handle())
}

/// Runs `act` inside the runtime context of the connections, so that it may spawn tasks. Returns
/// `None` if this process has none.
pub(crate) fn within<T>(act: impl FnOnce() -> T) -> Option<T> {
    let process = Process::known()?;
    let _inside = process.handle.enter();
    Some(act())
}

/// Queues a notification for Python.
pub(crate) fn notify(news: Notification) {
    if let Some(process) = Process::known() {
        let _ = process.news.send(news);
    }
}

/// Delivers all pending notifications at the end of the interpreter. None follow.
pub(crate) fn end(py: Python<'_>) {
    let Some(process) = Process::known() else {
        return;
    };
    let _ = process.news.send(Notification::Last);
    py.detach(|| {
        // Polled, because the process keeps the join handle.
        while !process.speaker.is_finished() {
            thread::yield_now();
        }
    });
}

/// Value that belongs to the process that created it. A forked child leaks it instead of dropping
/// it.
#[derive(Debug)]
pub(crate) struct Local<T> {
    process: u32,
    inner: Option<T>,
}

impl<T> Local<T> {
    pub(crate) fn new(inner: T) -> Self {
        Self {
            process: std::process::id(),
            inner: Some(inner),
        }
    }

    /// Returns the value, or `None` in another process.
    pub(crate) fn here(&self) -> Option<&T> {
        let own = self.process == std::process::id();
        self.inner.as_ref().filter(|_| own)
    }

    /// Returns the value.
    ///
    /// # Errors
    /// `magician.errors.ClosedError` in a forked child.
    pub(crate) fn get(&self, py: Python<'_>) -> PyResult<&T> {
        self.here().ok_or_else(|| {
            let message = "this arm was connected before the process was forked, and belongs to \
                the parent: connect again here";
            errors::raise(py, &Error::new(ErrorCode::Closed, message))
        })
    }
}

impl<T> Drop for Local<T> {
    /// Leaks the value in a forked child: threads of the parent may have held its locks during the
    /// fork.
    fn drop(&mut self) {
        if self.process != std::process::id() {
            std::mem::forget(self.inner.take());
        }
    }
}
