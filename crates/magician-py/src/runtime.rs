//! The threads of this process that belong to the package: one on which all connections live, one that speaks to Python.
//!
//! The first never takes the interpreter's lock: however long Python code holds it, a stop goes out in time. What
//! Python is to hear meanwhile (an event loop that a call has ended, `logging` of a warning) the second one says.
//!
//! A fork leaves the child without these threads, so each process has its own, and what was connected before a fork is of no
//! use after it.

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

/// What Python is to hear.
pub(crate) enum News {
    /// This has a waiter.
    Call(Arc<Py<PyAny>>),
    /// A line for the log.
    Log(logging::Record),
    /// The interpreter ends: nothing may be said any more.
    Last,
}

struct Process {
    id: u32,
    handle: Handle,
    news: Sender<News>,
    speaker: thread::JoinHandle<()>,
    next: OnceLock<Box<Process>>,
}

/// The processes from the one that loaded this to the present one. It grows with the interpreter's lock held, so no fork
/// sees it half done.
static FIRST: OnceLock<Box<Process>> = OnceLock::new();

fn failed(error: io::Error) -> Error {
    let message = format!("the system cannot create a timer, poller or thread: {error}");
    Error::new(ErrorCode::PortFailed, message)
}

fn runtime() -> Result<Runtime, Error> {
    let runtime = Builder::new_current_thread().enable_all().build();
    runtime.map_err(failed)
}

/// Starts work on a thread and a runtime of its own: what would hold up the connections.
///
/// # Errors
/// The system has no thread, timer or poller left.
pub(crate) fn apart<T: Send + 'static>(
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
        let (news, told) = channel();
        let serve = move || runtime.block_on(std::future::pending::<()>());
        let thread = |name: &str| thread::Builder::new().name(name.to_owned());
        thread("magician").spawn(serve).map_err(failed)?;
        let speaker = thread("magician-news").spawn(move || speak(&told));
        let speaker = speaker.map_err(failed)?;
        Ok(Self {
            id,
            handle,
            news,
            speaker,
            next: OnceLock::new(),
        })
    }

    /// The present process, if it has its threads already.
    fn known() -> Option<&'static Self> {
        let id = std::process::id();
        let mut slot = &FIRST;
        while let Some(process) = slot.get() {
            if process.id == id {
                return Some(process);
            }
            slot = &process.next;
        }
        None
    }
}

/// Calls what waits in this process until the interpreter ends.
fn speak(told: &Receiver<News>) {
    for news in told {
        match news {
            News::Last => return,
            // An event loop that is closed meanwhile wants to hear nothing more.
            News::Call(listener) => Python::attach(|py| drop(listener.call0(py))),
            News::Log(record) => Python::attach(|py| record.write(py)),
        }
    }
}

/// Lets one interpreter of a process in, the first that comes: what the package remembers is that one's.
///
/// # Errors
/// `ImportError` for any other.
pub(crate) fn first_interpreter(py: Python<'_>) -> PyResult<()> {
    static FIRST: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    // Every interpreter has its own.
    let modules = py.import("sys")?.getattr("modules")?;
    if modules.is(FIRST.get_or_init(py, || modules.clone().unbind())) {
        Ok(())
    } else {
        Err(PyImportError::new_err(
            "magician works in one interpreter of a process, and another one uses it",
        ))
    }
}

/// Makes sure that this process has its threads.
///
/// # Errors
/// `magician.errors.PortError` when the system gives none.
pub(crate) fn ready(py: Python<'_>) -> PyResult<()> {
    if Process::known().is_some() {
        return Ok(());
    }
    // Not as the module is imported: where the command runs, the log is the command's.
    logging::begin();
    let process = Process::start(std::process::id()).map_err(|error| errors::raise(py, &error))?;
    let mut slot = &FIRST;
    while let Some(before) = slot.get() {
        slot = &before.next;
    }
    let _ = slot.set(Box::new(process));
    Ok(())
}

/// Lets something run where the connections of this process live; `None` if it has no such place.
pub(crate) fn spawn(task: impl Future<Output = ()> + Send + 'static) -> Option<AbortHandle> {
    let process = Process::known()?;
    Some(process.handle.spawn(task).abort_handle())
}

/// Does something where the connections of this process live, which may start tasks there; `None` if it has no such place.
pub(crate) fn within<T>(act: impl FnOnce() -> T) -> Option<T> {
    let process = Process::known()?;
    let _inside = process.handle.enter();
    Some(act())
}

/// Lets Python hear something, soon.
pub(crate) fn tell(news: News) {
    if let Some(process) = Process::known() {
        let _ = process.news.send(news);
    }
}

/// The interpreter ends: what is to be said has been said when this returns, and nothing more will be.
pub(crate) fn end(py: Python<'_>) {
    let Some(process) = Process::known() else {
        return;
    };
    let _ = process.news.send(News::Last);
    py.detach(|| {
        while !process.speaker.is_finished() {
            thread::yield_now();
        }
    });
}

/// Something that lives in the process that made it; a fork's child lets it be.
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

    /// The thing, in its own process.
    pub(crate) fn here(&self) -> Option<&T> {
        let own = self.process == std::process::id();
        self.inner.as_ref().filter(|_| own)
    }

    /// The thing.
    ///
    /// # Errors
    /// `magician.errors.ClosedError` after a fork.
    pub(crate) fn get(&self, py: Python<'_>) -> PyResult<&T> {
        self.here().ok_or_else(|| {
            let message = "this arm was connected before the process was forked, and belongs to \
                the parent: connect again here";
            errors::raise(py, &Error::new(ErrorCode::Closed, message))
        })
    }
}

impl<T> Drop for Local<T> {
    /// Locks of the other process may be held for ever here.
    fn drop(&mut self) {
        if self.process != std::process::id() {
            std::mem::forget(self.inner.take());
        }
    }
}
