//! Diagnosis of an arm and its line, run on a separate thread.

use std::time::Duration;

use magician::{Arm, Error, ErrorCode, ErrorKind, LineOptions, Options, RawLine, Target};
use magician_measure::{
    Diagnosis, DiagnosisObserver, Finding, Measured, NoArm, QueueTrial, try_queue,
};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tokio::runtime::Runtime;
use tokio::sync::oneshot;
use tokio::time::timeout;

use crate::call::Call;
use crate::core::seconds;
use crate::examinations::{self, FindingReporter};
use crate::{errors, voice};

/// Longest time for the trial of the queue to end after an interrupt.
const TRIAL_TIMEOUT: Duration = Duration::from_secs(3);

/// Options of the diagnosis.
struct DiagnosisOptions {
    given: Option<String>,
    count: u64,
    timeout: Duration,
    try_queue: bool,
}

/// Reports each finding.
impl DiagnosisObserver for FindingReporter<Finding> {
    type Failure = NoArm;

    fn found(&mut self, finding: &Finding) -> Result<(), NoArm> {
        self.report(finding.clone());
        Ok(())
    }
}

fn interruption() -> NoArm {
    NoArm::Failed(Error::new(ErrorCode::Stopped, "it was interrupted"))
}

/// Tries the queue. A stop lets the trial end first, because its commands would stay in the queue
/// otherwise.
async fn trial(
    line: &mut RawLine,
    stop: &mut oneshot::Receiver<()>,
) -> Result<magician::Result<QueueTrial>, NoArm> {
    let mut trial = std::pin::pin!(try_queue(line));
    tokio::select! {
        tried = &mut trial => Ok(tried),
        _ = stop => {
            let _ = timeout(TRIAL_TIMEOUT, trial).await;
            Err(interruption())
        }
    }
}

/// Runs the diagnosis until it is stopped.
async fn examine(
    options: &DiagnosisOptions,
    found: &mut Diagnosis,
    to: &mut FindingReporter<Finding>,
    stop: &mut oneshot::Receiver<()>,
) -> Result<(), NoArm> {
    let target = found.find(options.given.as_deref(), to)?;
    let listening = async {
        let mut line = found.open(&target, LineOptions::default(), to).await?;
        let timeout = Some(options.timeout);
        found.hear(&mut line, &target, timeout, to).await?;
        found.window(&mut line, &target, to).await?;
        Ok::<_, NoArm>(line)
    };
    let mut line = tokio::select! {
        heard = listening => heard?,
        _ = &mut *stop => return Err(interruption()),
    };
    if options.try_queue {
        let tried = trial(&mut line, stop).await?;
        found.queue(tried, &target, to)?;
    } else {
        found.leave_queue(to)?;
    }
    drop(line);
    let looking = async {
        let known = magician::arms::load()?;
        let arm_options = Options::default().timeout(options.timeout);
        let arm_options = arm_options.homings(magician_job::homings());
        let arm_options = arm_options.for_arm(magician::arms::at(&known, &target));
        let arm = Arm::connect_with(&target, arm_options).await?;
        let serial = matches!(
            target,
            Target::Serial(_) | Target::Usb { .. } | Target::Arm(_)
        );
        let looked = found.examine(&arm, options.count, serial, to).await;
        arm.close().await;
        looked
    };
    tokio::select! {
        looked = looking => looked,
        _ = stop => Err(interruption()),
    }
}

/// Converts the measured value: a number, a text or a dictionary.
fn measured_value<'py>(py: Python<'py>, value: &Measured) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Measured::Text(text) => text.into_bound_py_any(py),
        Measured::Count(count) => count.into_bound_py_any(py),
        Measured::Number(number) => number.into_bound_py_any(py),
        Measured::Identity {
            name,
            serial_number,
            firmware,
            uptime_s,
        } => {
            let parts = PyDict::new(py);
            parts.set_item("name", name)?;
            parts.set_item("serial_number", serial_number)?;
            parts.set_item("firmware", firmware)?;
            parts.set_item("uptime_s", uptime_s)?;
            Ok(parts.into_any())
        }
        Measured::Fence(fence) => fence.to_string().into_bound_py_any(py),
        // A finding without a value.
        _ => Ok(py.None().into_bound(py)),
    }
}

/// Converts a finding: check, ok, value, unit, text, advice.
fn finding_parts(py: Python<'_>, finding: &Finding) -> PyResult<Py<PyAny>> {
    let advice = finding.advice.as_ref();
    let advice = advice.map(|advice| advice.said(&voice::Python));
    let parts = (
        finding.check,
        finding.ok,
        measured_value(py, &finding.value)?,
        finding.unit,
        finding.text.as_str(),
        advice,
    );
    parts.into_py_any(py)
}

fn error(none: NoArm) -> Error {
    let (kind, message) = match none {
        NoArm::Failed(error) => return error,
        NoArm::FailedCheck(kind, message) => (kind, message),
    };
    let code = match kind {
        ErrorKind::Port => ErrorCode::NoArm,
        ErrorKind::Timeout => ErrorCode::NoAnswer,
        _ => ErrorCode::NotAnArm,
    };
    Error::new(code, message)
}

/// Diagnoses the arm at a port. Returns two calls: the first reports findings and results in port,
/// window, turnaround in ms, and the exception of an early end; the second ends when the port is
/// closed.
#[pyfunction]
pub(crate) fn doctor(
    py: Python<'_>,
    port: Option<String>,
    count: u64,
    timeout: f64,
    try_queue: bool,
) -> PyResult<(Call, Call)> {
    let raise = |error: Error| errors::raise(py, &error);
    let environment = std::env::var("MAGICIAN_PORT").ok();
    let given = port.or(environment.filter(|port| !port.is_empty()));
    if let Some(port) = &given {
        port.parse::<Target>().map_err(raise)?;
    }
    let options = DiagnosisOptions {
        given,
        count,
        timeout: seconds(py, "the timeout", timeout)?,
        try_queue,
    };
    let work = move |runtime: &Runtime,
                     mut to: FindingReporter<Finding>,
                     mut stopped: oneshot::Receiver<()>| {
        let mut found = Diagnosis::default();
        let outcome = runtime.block_on(examine(&options, &mut found, &mut to, &mut stopped));
        Ok((found, outcome.err().map(error)))
    };
    examinations::start_examination(
        py,
        "magician-doctor",
        work,
        finding_parts,
        |py, (found, ended)| {
            let ended = ended.map(|error| errors::raise(py, &error).into_value(py));
            (found.port, found.window, found.turnaround_ms, ended).into_py_any(py)
        },
    )
}
