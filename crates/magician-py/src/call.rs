use std::future::Future;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::task::AbortHandle;

use crate::errors;
use crate::runtime;

/// So often a waiting thread looks whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(30);

/// What becomes a Python object once the interpreter is there.
type Made = Box<dyn FnOnce(Python<'_>) -> PyResult<Py<PyAny>> + Send>;

/// Something under way at an arm.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Call {
    shared: Arc<Shared>,
    task: AbortHandle,
}

struct Shared {
    state: Mutex<State>,
    ended: Condvar,
}

#[derive(Default)]
struct State {
    outcome: Option<magician::Result<Made>>,
    over: bool,
    listener: Option<Py<PyAny>>,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self, outcome: magician::Result<Made>) {
        let listener = {
            let mut state = self.state();
            state.outcome = Some(outcome);
            state.over = true;
            state.listener.take()
        };
        self.ended.notify_all();
        if let Some(listener) = listener {
            // An event loop that is closed meanwhile wants to hear nothing more.
            let _ = Python::try_attach(|py| drop(listener.call0(py)));
        }
    }
}

impl Call {
    /// Starts something; `made` turns what it comes to into a Python object.
    pub(crate) fn start<T, F, M>(task: F, made: M) -> Self
    where
        T: Send + 'static,
        F: Future<Output = magician::Result<T>> + Send + 'static,
        M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
    {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            ended: Condvar::new(),
        });
        let told = Arc::clone(&shared);
        let task = runtime::spawn(async move {
            let outcome = task.await;
            told.end(outcome.map(|value| Box::new(move |py: Python<'_>| made(py, value)) as Made));
        });
        Self { shared, task }
    }

    /// Starts something that comes to nothing.
    pub(crate) fn plain<F>(task: F) -> Self
    where
        F: Future<Output = magician::Result<()>> + Send + 'static,
    {
        Self::start(task, |py, ()| Ok(py.None()))
    }
}

#[pymethods]
impl Call {
    /// Waits for the end, with the interpreter free for other threads, and returns what came of it.
    fn wait(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        while !py.detach(|| self.look()) {
            py.check_signals()?;
        }
        self.result(py)
    }

    /// Calls `listener()` from another thread when it has ended; at once, if it has.
    fn on_end(&self, py: Python<'_>, listener: Py<PyAny>) -> PyResult<()> {
        {
            let mut state = self.shared.state();
            if !state.over {
                state.listener = Some(listener);
                return Ok(());
            }
        }
        listener.call0(py).map(drop)
    }

    /// What came of it, once.
    fn result(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let outcome = self.shared.state().outcome.take();
        match outcome {
            None => Err(PyRuntimeError::new_err(
                "it has not ended, or its result was taken",
            )),
            Some(Ok(made)) => made(py),
            Some(Err(error)) => Err(errors::raise(py, &error)),
        }
    }

    /// Lets go of it: what the arm was sent stays sent.
    fn cancel(&self) {
        self.task.abort();
    }
}

impl Call {
    /// Waits for a moment; whether it has ended.
    fn look(&self) -> bool {
        let state = self.shared.state();
        let waited = self
            .shared
            .ended
            .wait_timeout_while(state, LOOK, |state| !state.over);
        waited.unwrap_or_else(PoisonError::into_inner).0.over
    }
}
