//! The conformance suite on an arm, in a thread of its own.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use magician::{Error, ErrorCode, LineOptions, RawLine, SimSpeed, Target};
use magician_conform::{Case, LineTarget, Outcome, Runner, SimTarget, Suite, SuiteError};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PyTuple};
use tokio::sync::oneshot;

use crate::call::LOOK;
use crate::core::{seconds, target};
use crate::{errors, runtime};

/// How long the restoration of an arm's parameters may take.
const LEAVING: Duration = Duration::from_secs(20);

type Results = Vec<(Case, Outcome)>;

/// The selected cases, and the time for an answer.
struct Asked {
    only: Vec<String>,
    skip: Vec<String>,
    patience: Duration,
}

fn broken(error: &SuiteError) -> Error {
    Error::new(ErrorCode::Closed, error.to_string())
}

/// Runs the cases, until it is told to stop; the arm is left as it was either way.
async fn run<T: magician_conform::Target>(
    arm: T,
    asked: &Asked,
    stopped: oneshot::Receiver<()>,
) -> Result<Results, Error> {
    let suite = Suite::built_in().map_err(|error| broken(&error))?;
    let mut runner = Runner::new(arm, asked.patience).map_err(|error| broken(&error))?;
    let work = async {
        runner.begin().await?;
        let mut results = Vec::new();
        for case in suite.select(&asked.only, &asked.skip) {
            results.push((case.clone(), runner.run(case).await?));
        }
        Ok(results)
    };
    let outcome: Result<Results, Error> = tokio::select! {
        outcome = work => outcome,
        _ = stopped => Ok(Vec::new()),
    };
    let left = tokio::time::timeout(LEAVING, runner.end()).await;
    let results = outcome?;
    left.map_err(|_| {
        let message = "the arm's parameters were not restored in time";
        Error::new(ErrorCode::NoAnswer, message)
    })??;
    Ok(results)
}

/// Runs them on the arm at a port; `None` is a virtual arm whose clock is stepped.
async fn run_at(
    place: Option<&Target>,
    asked: &Asked,
    stopped: oneshot::Receiver<()>,
) -> Result<Results, Error> {
    let Some(place) = place else {
        return run(SimTarget::default(), asked, stopped).await;
    };
    let line = RawLine::open_with(place, LineOptions::default()).await?;
    run(LineTarget::new(line), asked, stopped).await
}

/// A case and its result: id, chapter, title, source, confidence, tags; the outcome in a word, the reason of a skip, and the
/// mismatch of a failure.
fn told<'py>(py: Python<'py>, case: &Case, outcome: &Outcome) -> PyResult<Bound<'py, PyTuple>> {
    let (word, reason, failure) = match outcome {
        Outcome::Passed => ("passed", None, None),
        Outcome::Skipped(reason) => ("skipped", Some(reason), None),
        Outcome::Failed(mismatch) => {
            let parts = (
                mismatch.line,
                &mismatch.step,
                PyBytes::new(py, &mismatch.sent),
                &mismatch.expected,
                &mismatch.got,
                PyBytes::new(py, &mismatch.received),
            );
            ("failed", None, Some(parts))
        }
    };
    let about = (
        &case.id,
        case.chapter(),
        &case.title,
        &case.source,
        case.confidence.to_string(),
        PyTuple::new(py, case.tags())?,
    );
    (about, word, reason, failure).into_pyobject(py)
}

/// Runs the selected cases on the arm at a port; the result of each. Ctrl-C ends it once the arm's parameters are restored.
#[pyfunction]
pub(crate) fn conform(
    py: Python<'_>,
    port: Option<&str>,
    only: Vec<String>,
    skip: Vec<String>,
    patience: f64,
    allow_motion: bool,
) -> PyResult<Py<PyAny>> {
    let raise = |error: Error| errors::raise(py, &error);
    let patience = seconds(py, "the timeout", patience)?;
    let suite = Suite::built_in().map_err(|error| raise(broken(&error)))?;
    if let Some(pattern) = suite.unmatched(only.iter().chain(&skip)) {
        let message = format!("no case matches \"{pattern}\"");
        return Err(raise(Error::invalid(message)));
    }
    let place = match py.detach(|| target(port)).map_err(raise)? {
        Target::Sim(SimSpeed::Max) => None,
        Target::Sim(SimSpeed::Times(_)) => {
            let message = "the clock of a virtual arm is stepped here, and a speed has no effect: \
                give \"sim\"";
            return Err(raise(Error::invalid(message)));
        }
        place => Some(place),
    };
    let cases = suite.select(&only, &skip);
    let moving = cases.iter().filter(|case| case.moves_an_arm()).count();
    if let (Some(place), false, 1..) = (&place, allow_motion, moving) {
        let message = format!(
            "the arm at {place} would move in {moving} cases, and nothing was sent: take its tool off, \
             clear its reach and give allow_motion=True, or leave them out with skip=[\"moves\"]"
        );
        return Err(raise(Error::invalid(message)));
    }
    let asked = Asked {
        only,
        skip,
        patience,
    };
    let (tell, ended) = channel();
    let (stop, stopped) = oneshot::channel();
    runtime::apart("magician-conform", move |runtime| {
        let results = runtime.block_on(run_at(place.as_ref(), &asked, stopped));
        drop(tell.send(results));
    })
    .map_err(raise)?;
    let results = PyList::empty(py);
    for (case, outcome) in waited(py, ended, stop)? {
        results.append(told(py, &case, &outcome)?)?;
    }
    results.into_py_any(py)
}

/// Waits for the results. An interrupt ends the run, and is raised once the arm's parameters are restored.
fn waited(
    py: Python<'_>,
    ended: Receiver<Result<Results, Error>>,
    stop: oneshot::Sender<()>,
) -> PyResult<Results> {
    let ended = Mutex::new(ended);
    let (mut stop, mut interrupted) = (Some(stop), None);
    loop {
        let heard = py.detach(|| {
            let ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
            ended.recv_timeout(LOOK)
        });
        match (heard, interrupted.take()) {
            (Err(RecvTimeoutError::Timeout), before) => {
                interrupted = py.check_signals().err().or(before);
                if interrupted.is_some() {
                    // Its end follows; a second interrupt changes nothing.
                    let _ = stop.take().map(|stop| stop.send(()));
                }
            }
            (_, Some(interrupt)) => return Err(interrupt),
            (Ok(outcome), None) => return outcome.map_err(|error| errors::raise(py, &error)),
            (Err(RecvTimeoutError::Disconnected), None) => {
                let error = Error::new(ErrorCode::Closed, "it ended without a result");
                return Err(errors::raise(py, &error));
            }
        }
    }
}
