//! The conformance suite on an arm, run on a separate thread.

use std::time::Duration;

use magician::{Error, ErrorCode, LineOptions, RawLine, SimSpeed, Target};
use magician_conform::{Case, LineTarget, Outcome, Runner, SimTarget, Suite, SuiteError};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

use crate::call::Call;
use crate::core::{seconds, target};
use crate::errors;
use crate::examinations::{self, FindingReporter};

/// Longest time for restoring the parameters of an arm. A choice: long enough for a slow arm,
/// and an end if the arm is gone.
const RESTORE_TIMEOUT: Duration = Duration::from_secs(20);

type CaseResult = (Case, Outcome);

/// Selected cases, and the timeout of a reply.
struct CaseSelection {
    only: Vec<String>,
    skip: Vec<String>,
    timeout: Duration,
}

fn suite_error(error: &SuiteError) -> Error {
    Error::new(ErrorCode::Closed, error.to_string())
}

/// Runs the cases to the end or until stopped. The arm's parameters are restored in either case.
async fn run<T: magician_conform::Target>(
    arm: T,
    selection: &CaseSelection,
    to: &FindingReporter<CaseResult>,
    stopped: oneshot::Receiver<()>,
) -> Result<(), Error> {
    let suite = Suite::built_in().map_err(|error| suite_error(&error))?;
    let mut runner = Runner::new(arm, selection.timeout).map_err(|error| suite_error(&error))?;
    let work = async {
        runner.begin().await?;
        for case in suite.select(&selection.only, &selection.skip) {
            to.report((case.clone(), runner.run(case).await?));
            // Cases on a virtual arm never wait. Yield, so that a stop is noticed between them.
            tokio::task::yield_now().await;
        }
        Ok(())
    };
    let outcome: Result<(), Error> = tokio::select! {
        outcome = work => outcome,
        _ = stopped => Ok(()),
    };
    let restored = tokio::time::timeout(RESTORE_TIMEOUT, runner.end()).await;
    outcome?;
    restored.map_err(|_| {
        let message = "the arm's parameters were not restored in time";
        Error::new(ErrorCode::NoAnswer, message)
    })??;
    Ok(())
}

/// Runs the cases on the arm at a port. `None` is a virtual arm in virtual time.
async fn run_at(
    place: Option<&Target>,
    selection: &CaseSelection,
    to: &FindingReporter<CaseResult>,
    stopped: oneshot::Receiver<()>,
) -> Result<(), Error> {
    let Some(place) = place else {
        return run(SimTarget::default(), selection, to, stopped).await;
    };
    let line = RawLine::open_with(place, LineOptions::default()).await?;
    run(LineTarget::new(line), selection, to, stopped).await
}

/// Converts a case and its result: id, chapter, title, source, confidence and tags; outcome as a
/// word, reason of a skip, mismatch of a failure.
fn case_parts(py: Python<'_>, (case, outcome): &CaseResult) -> PyResult<Py<PyAny>> {
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
    (about, word, reason, failure).into_py_any(py)
}

/// Runs the selected cases on the arm at a port. Returns the call that reports results, the number
/// of cases, and the call that ends when the arm's parameters are restored.
#[pyfunction]
pub(crate) fn conform(
    py: Python<'_>,
    port: Option<&str>,
    only: Vec<String>,
    skip: Vec<String>,
    timeout: f64,
    allow_motion: bool,
) -> PyResult<(Call, usize, Call)> {
    let raise = |error: Error| errors::raise(py, &error);
    let timeout = seconds(py, "the timeout", timeout)?;
    let suite = Suite::built_in().map_err(|error| raise(suite_error(&error)))?;
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
    let count = cases.len();
    let selection = CaseSelection {
        only,
        skip,
        timeout,
    };
    let work = move |runtime: &Runtime, to: FindingReporter<CaseResult>, stopped| {
        runtime.block_on(run_at(place.as_ref(), &selection, &to, stopped))
    };
    let (call, left) =
        examinations::start_examination(py, "magician-conform", work, case_parts, |py, ()| {
            Ok(py.None())
        })?;
    Ok((call, count, left))
}
