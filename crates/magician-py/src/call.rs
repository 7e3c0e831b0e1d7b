//! Calls: operations in progress, which a thread or an event loop waits for.
//!
//! A call runs as a task on the package's runtime and ends with a value, which is converted to a
//! Python object by the waiter, under the interpreter's lock. A call that moves the arm starts only
//! when it is waited for, and stops the arm when it is dropped before its end, so that an interrupt
//! (Ctrl-C) at any time leaves the arm at rest.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician::{Arm, Error, ErrorCode};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::task::AbortHandle;

use crate::errors;
use crate::runtime::{self, Local, Notification};

/// Interval at which a waiting thread checks for signals such as Ctrl-C. A choice: short to a
/// person, and little work.
pub(crate) const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(30);

/// Stops an operation without waiting.
type Stop = Box<dyn Fn() + Send + Sync>;

/// Deferred conversion to a Python object, run while the interpreter's lock is held.
type Conversion = Box<dyn FnOnce(Python<'_>) -> PyResult<Py<PyAny>> + Send>;

/// Something under way at an arm.
#[pyclass(frozen, generic, module = "magician._magician")]
pub(crate) struct Call {
    inner: Local<Inner>,
}

struct Inner {
    shared: Arc<Shared>,
    work: Mutex<Work>,
    /// Stops the operation if its waiter is gone. `None` if it does not move the arm.
    stop: Option<Stop>,
}

/// Execution state of an operation.
enum Work {
    /// Not started: starts when it is waited for. An interrupt before that leaves the arm at rest.
    Waiting(Pin<Box<dyn Future<Output = ()> + Send>>),
    Going(AbortHandle),
    /// Cannot be aborted, and runs to its end.
    Lasting,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    outcome: Option<Result<Conversion, Arc<Error>>>,
    over: bool,
    taken: bool,
    report: Option<Conversion>,
    listener: Option<Arc<Py<PyAny>>>,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state and wakes all waiters: threads at once, an event loop through the news
    /// thread.
    fn change(&self, change: impl FnOnce(&mut State)) {
        let listener = {
            let mut state = self.state();
            change(&mut state);
            state.listener.clone()
        };
        self.changed.notify_all();
        if let Some(listener) = listener {
            runtime::notify(Notification::Call(listener));
        }
    }

    /// Waits up to [`SIGNAL_CHECK_INTERVAL`]. Returns true if the operation has ended, and the newest report.
    fn look(&self) -> (bool, Option<Conversion>) {
        let quiet = |state: &mut State| !state.over && state.report.is_none();
        let waited = self
            .changed
            .wait_timeout_while(self.state(), SIGNAL_CHECK_INTERVAL, quiet)
            .unwrap_or_else(PoisonError::into_inner);
        let mut state = waited.0;
        (state.over, state.report.take())
    }
}

/// Reports the progress of an operation. Only the newest unread report is kept.
pub(crate) struct Reporter(Arc<Shared>);

impl Reporter {
    pub(crate) fn report(
        &self,
        convert: impl FnOnce(Python<'_>) -> PyResult<Py<PyAny>> + Send + 'static,
    ) {
        self.0
            .change(|state| state.report = Some(Box::new(convert) as Conversion));
    }
}

impl Call {
    /// Starts an operation. `made` converts its result to a Python object.
    pub(crate) fn start<T, E, F, M>(task: F, convert: M) -> Self
    where
        T: Send + 'static,
        E: Into<Arc<Error>> + Send + 'static,
        F: Future<Output = Result<T, E>> + Send + 'static,
        M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
    {
        let shared = Arc::new(Shared::default());
        let going = runtime::spawn(deliver(&shared, task, convert));
        Self::of(shared, going.map_or(Work::Lasting, Work::Going), None)
    }

    /// Creates a motion with progress reports. It starts when it is waited for; dropping it before
    /// its end stops the arm.
    pub(crate) fn moving<T, F, M>(arm: &Arm, task: impl FnOnce(Reporter) -> F, convert: M) -> Self
    where
        T: Send + 'static,
        F: Future<Output = magician::Result<T>> + Send + 'static,
        M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
    {
        let shared = Arc::new(Shared::default());
        let task = task(Reporter(Arc::clone(&shared)));
        let work = Work::Waiting(Box::pin(deliver(&shared, task, convert)));
        let stopper = arm.stopper();
        // Fails without a connection; then there is no motion to stop.
        let stop = move || drop(stopper.request_stop());
        Self::of(shared, work, Some(Box::new(stop)))
    }

    /// Like [`moving`](Self::moving), for an operation that is already running and is stopped by
    /// `stop`.
    pub(crate) fn under_way<T, F, M>(
        stop: impl Fn() + Send + Sync + 'static,
        task: impl FnOnce(Reporter) -> F,
        convert: M,
    ) -> Self
    where
        T: Send + 'static,
        F: Future<Output = Result<T, Arc<Error>>> + Send + 'static,
        M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
    {
        let shared = Arc::new(Shared::default());
        let task = task(Reporter(Arc::clone(&shared)));
        let work = Work::Waiting(Box::pin(deliver(&shared, task, convert)));
        Self::of(shared, work, Some(Box::new(stop)))
    }

    /// Starts an operation without a result.
    pub(crate) fn plain<F>(task: F) -> Self
    where
        F: Future<Output = magician::Result<()>> + Send + 'static,
    {
        Self::start(task, |py, ()| Ok(py.None()))
    }

    /// Creates an operation that starts when it is waited for, with an optional text as its result.
    pub(crate) fn waiting<F>(task: F) -> Self
    where
        F: Future<Output = magician::Result<Option<String>>> + Send + 'static,
    {
        let shared = Arc::new(Shared::default());
        let task = deliver(&shared, task, |py, text: Option<String>| {
            Ok(text.into_pyobject(py)?.into_any().unbind())
        });
        Self::of(shared, Work::Waiting(Box::pin(task)), None)
    }

    /// Starts an operation without a result that continues without a waiter, such as a stop.
    pub(crate) fn lasting<F>(task: F) -> Self
    where
        F: Future<Output = magician::Result<()>> + Send + 'static,
    {
        let shared = Arc::new(Shared::default());
        runtime::spawn(deliver(&shared, task, |py, ()| Ok(py.None())));
        Self::of(shared, Work::Lasting, None)
    }

    fn of(shared: Arc<Shared>, work: Work, stop: Option<Stop>) -> Self {
        let work = Mutex::new(work);
        let inner = Inner { shared, work, stop };
        Self {
            inner: Local::new(inner),
        }
    }

    fn shared(&self, py: Python<'_>) -> PyResult<&Arc<Shared>> {
        self.inner.get(py).map(|inner| &inner.shared)
    }
}

impl Inner {
    fn work(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the operation when its first waiter arrives.
    fn begin(&self) {
        let mut work = self.work();
        *work = match std::mem::replace(&mut *work, Work::Lasting) {
            Work::Waiting(task) => runtime::spawn(task).map_or(Work::Lasting, Work::Going),
            other => other,
        };
    }

    /// Stops and aborts the operation, because its waiter is gone.
    fn abandon(&self) {
        let over = {
            let mut state = self.shared.state();
            state.listener = None;
            state.over
        };
        if let (Work::Going(task), false) = (&*self.work(), over) {
            // Stop before the abort: a virtual arm that is only let go of finishes its queue at
            // once.
            if let Some(stop) = &self.stop {
                stop();
            }
            task.abort();
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if self.stop.is_some() {
            self.abandon();
        }
    }
}

/// Wraps a task so that its result goes to the waiter.
fn deliver<T, E, F, M>(
    shared: &Arc<Shared>,
    task: F,
    convert: M,
) -> impl Future<Output = ()> + Send + use<T, E, F, M>
where
    T: Send + 'static,
    E: Into<Arc<Error>> + Send + 'static,
    F: Future<Output = Result<T, E>> + Send + 'static,
    M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
{
    let ending = EndGuard(Arc::clone(shared));
    async move {
        let outcome = task.await;
        ending.0.change(|state| {
            let outcome = outcome.map_err(Into::into);
            state.outcome = Some(
                outcome
                    .map(|value| Box::new(move |py: Python<'_>| convert(py, value)) as Conversion),
            );
            state.over = true;
        });
    }
}

/// Ends a call even if its task is dropped or panics, so that no waiter waits forever.
struct EndGuard(Arc<Shared>);

impl Drop for EndGuard {
    fn drop(&mut self) {
        if !self.0.state().over {
            self.0.change(|state| {
                let message = "it was dropped before its end";
                state.outcome = Some(Err(Error::new(ErrorCode::Closed, message).into()));
                state.over = true;
            });
        }
    }
}

#[pymethods]
impl Call {
    /// Waits for the end with the interpreter's lock released, and returns the result. `listener`
    /// is called with each report. An interrupt, or an exception of the listener, ends the wait and
    /// abandons the operation.
    #[pyo3(signature = (listener=None))]
    fn wait(&self, py: Python<'_>, listener: Option<&Bound<'_, PyAny>>) -> PyResult<Py<PyAny>> {
        let inner = self.inner.get(py)?;
        inner.begin();
        let shared = &inner.shared;
        loop {
            let (over, report) = py.detach(|| shared.look());
            let heard = match (report, listener) {
                (Some(report), Some(listener)) => {
                    report(py).and_then(|report| listener.call1((report,)).map(drop))
                }
                _ => Ok(()),
            };
            if over && heard.is_ok() {
                return self.result(py);
            }
            if let Err(error) = heard.and_then(|()| py.check_signals()) {
                inner.abandon();
                return Err(error);
            }
        }
    }

    /// Calls `listener()` from another thread at each report and at the end, and once immediately.
    fn listen(&self, py: Python<'_>, listener: Py<PyAny>) -> PyResult<()> {
        let inner = self.inner.get(py)?;
        let listener = Arc::new(listener);
        (inner.shared).change(|state| state.listener = Some(listener));
        inner.begin();
        Ok(())
    }

    /// Latest undelivered report, or `None`.
    fn report(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let report = self.shared(py)?.state().report.take();
        report.map(|report| report(py)).transpose()
    }

    /// True if the operation has ended.
    fn over(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.shared(py)?.state().over)
    }

    /// True if the result was delivered.
    fn taken(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.shared(py)?.state().taken)
    }

    /// Returns the result. May be called once.
    fn result(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let outcome = {
            let mut state = self.shared(py)?.state();
            state.listener = None;
            state.taken = state.outcome.is_some();
            state.outcome.take()
        };
        match outcome {
            None => Err(PyRuntimeError::new_err(
                "it has not ended, or its result was taken",
            )),
            Some(Ok(convert)) => convert(py),
            Some(Err(error)) => Err(errors::raise(py, &error)),
        }
    }

    /// Abandons the operation. Sent frames stay sent, a stop continues, and a motion is stopped.
    fn cancel(&self) {
        if let Some(inner) = self.inner.here() {
            inner.abandon();
        }
    }
}
