//! Long examinations as calls, each on a separate thread.
//!
//! Findings are reported as they come. On request, an examination restores the arm as at its
//! regular end, so that stopping is not immediate: a second call waits for that.

use std::mem::take;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Error, ErrorCode};
use pyo3::prelude::*;
use pyo3::types::PyList;
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

use crate::call::{Call, Reporter};
use crate::{errors, runtime};

/// Converts a finding to a Python object.
type Converter<T> = fn(Python<'_>, &T) -> PyResult<Py<PyAny>>;

/// Reports the findings of an examination. None is lost: a slow listener gets several in one
/// report.
pub(crate) struct FindingReporter<T> {
    /// Findings that were not delivered yet.
    pending: Arc<Mutex<Vec<T>>>,
    reporter: Reporter,
    convert: Converter<T>,
}

fn locked<T>(inner: &Mutex<T>) -> MutexGuard<'_, T> {
    inner.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + 'static> FindingReporter<T> {
    pub(crate) fn report(&self, finding: T) {
        locked(&self.pending).push(finding);
        let (pending, convert) = (Arc::clone(&self.pending), self.convert);
        self.reporter.report(move |py| {
            let heard = take(&mut *locked(&pending));
            let heard = heard.iter().map(|finding| convert(py, finding));
            let heard = PyList::new(py, heard.collect::<PyResult<Vec<_>>>()?)?;
            Ok(heard.into_any().unbind())
        });
    }
}

/// Starts an examination. Returns the call itself, and a call for its end.
///
/// Dropping the first stops the examination. The second ends when the arm is restored and
/// its port closed.
pub(crate) fn start_examination<T, P, W, M>(
    py: Python<'_>,
    name: &str,
    work: W,
    finding: Converter<P>,
    convert: M,
) -> PyResult<(Call, Call)>
where
    T: Send + 'static,
    P: Send + 'static,
    W: FnOnce(&Runtime, FindingReporter<P>, oneshot::Receiver<()>) -> Result<T, Error>
        + Send
        + 'static,
    M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
{
    runtime::ready(py)?;
    let (stop, stopped) = oneshot::channel();
    let (outcome_sender, outcome_receiver) = oneshot::channel();
    let (leave, left) = oneshot::channel::<()>();
    let stop = Mutex::new(Some(stop));
    let stop = move || {
        let _ = locked(&stop).take().map(|stop| stop.send(()));
    };
    let mut started = Ok(());
    let task = |reporter| {
        let reporter = FindingReporter {
            pending: Arc::default(),
            reporter,
            convert: finding,
        };
        started = runtime::spawn_separately(name, move |runtime| {
            let outcome = work(runtime, reporter, stopped);
            // The receivers may have been dropped with both calls.
            let _ = outcome_sender.send(outcome);
            let _ = leave.send(());
        })
        .map(drop);
        async {
            let ended = outcome_receiver.await.unwrap_or_else(|_| {
                let message = "it ended without a result";
                Err(Error::new(ErrorCode::Closed, message))
            });
            ended.map_err(Arc::new)
        }
    };
    let call = Call::under_way(stop, task, convert);
    started.map_err(|error| errors::raise(py, &error))?;
    let end = Call::lasting(async {
        let _ = left.await;
        Ok(())
    });
    Ok((call, end))
}
