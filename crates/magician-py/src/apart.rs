//! Examinations that take long, on a thread of their own, as calls: what they find is heard as it comes, and they end as they would
//! by themselves when they are told to stop.

use std::mem::take;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::{Error, ErrorCode};
use pyo3::prelude::*;
use pyo3::types::PyList;
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

use crate::call::{Call, Reporter};
use crate::{errors, runtime};

/// What makes a Python object of a piece.
type Piece<T> = fn(Python<'_>, &T) -> PyResult<Py<PyAny>>;

/// How an examination tells what it finds, piece by piece. None is lost: who hears late hears several at once.
pub(crate) struct Teller<T> {
    /// Those that were not heard yet.
    pending: Arc<Mutex<Vec<T>>>,
    reporter: Reporter,
    made: Piece<T>,
}

fn locked<T>(inner: &Mutex<T>) -> MutexGuard<'_, T> {
    inner.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + 'static> Teller<T> {
    pub(crate) fn tell(&self, piece: T) {
        locked(&self.pending).push(piece);
        let (pending, made) = (Arc::clone(&self.pending), self.made);
        self.reporter.report(move |py| {
            let heard = take(&mut *locked(&pending));
            let heard = heard.iter().map(|piece| made(py, piece));
            let heard = PyList::new(py, heard.collect::<PyResult<Vec<_>>>()?)?;
            Ok(heard.into_any().unbind())
        });
    }
}

/// An examination that has begun, and its end. Dropping the first tells it to stop; the second is over when the arm has been left
/// as it was and its port is closed, and is only waited for.
pub(crate) fn calls<T, P, W, M>(
    py: Python<'_>,
    name: &str,
    work: W,
    piece: Piece<P>,
    made: M,
) -> PyResult<(Call, Call)>
where
    T: Send + 'static,
    P: Send + 'static,
    W: FnOnce(&Runtime, Teller<P>, oneshot::Receiver<()>) -> Result<T, Error> + Send + 'static,
    M: FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
{
    runtime::ready(py)?;
    let (stop, stopped) = oneshot::channel();
    let (tell, told) = oneshot::channel();
    let (leave, left) = oneshot::channel::<()>();
    let stop = Mutex::new(Some(stop));
    let stop = move || {
        let _ = locked(&stop).take().map(|stop| stop.send(()));
    };
    let mut started = Ok(());
    let task = |reporter| {
        let teller = Teller {
            pending: Arc::default(),
            reporter,
            made: piece,
        };
        started = runtime::apart(name, move |runtime| {
            let outcome = work(runtime, teller, stopped);
            // Both calls may have been let go of.
            let _ = tell.send(outcome);
            let _ = leave.send(());
        })
        .map(drop);
        async {
            let ended = told.await.unwrap_or_else(|_| {
                let message = "it ended without a result";
                Err(Error::new(ErrorCode::Closed, message))
            });
            ended.map_err(Arc::new)
        }
    };
    let call = Call::under_way(stop, task, made);
    started.map_err(|error| errors::raise(py, &error))?;
    let end = Call::lasting(async {
        let _ = left.await;
        Ok(())
    });
    Ok((call, end))
}
