//! The examination of an arm and its line, in a thread of its own.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use magician::measure::{Attendant, Diagnosis, Finding, Measured, NoArm, QueueTrial, try_queue};
use magician::{Arm, Error, ErrorCode, ErrorKind, LineOptions, Options, RawLine, Target};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use tokio::sync::oneshot;
use tokio::time::timeout;

use crate::call::LOOK;
use crate::core::seconds;
use crate::{errors, runtime, voice};

/// How long the trial of the queue may take to end once it is interrupted.
const LEAVING: Duration = Duration::from_secs(3);

/// What is asked for.
struct Asked {
    given: Option<String>,
    count: u64,
    patience: Duration,
    try_queue: bool,
}

/// Tells what is found.
struct Teller(Sender<Told>);

enum Told {
    Finding(Box<Finding>),
    End(Diagnosis, Result<(), NoArm>),
}

impl Attendant for Teller {
    type Failure = NoArm;

    fn found(&mut self, finding: &Finding) -> Result<(), NoArm> {
        // Whoever does not listen has ended it.
        let _ = self.0.send(Told::Finding(Box::new(finding.clone())));
        Ok(())
    }
}

fn stopped() -> NoArm {
    NoArm::Failed(Error::new(ErrorCode::Stopped, "it was interrupted"))
}

/// Tries the queue. A stop lets it come to its end first, because its commands would be left in the queue.
async fn trial(
    line: &mut RawLine,
    stop: &mut oneshot::Receiver<()>,
) -> Result<magician::Result<QueueTrial>, NoArm> {
    let mut trial = std::pin::pin!(try_queue(line));
    tokio::select! {
        tried = &mut trial => Ok(tried),
        _ = stop => {
            let _ = timeout(LEAVING, trial).await;
            Err(stopped())
        }
    }
}

/// Examines it until it is told to stop.
async fn examine(
    asked: &Asked,
    found: &mut Diagnosis,
    to: &mut Teller,
    stop: &mut oneshot::Receiver<()>,
) -> Result<(), NoArm> {
    let target = found.find(asked.given.as_deref(), to)?;
    let listening = async {
        let mut line = found.open(&target, LineOptions::default(), to).await?;
        let patience = Some(asked.patience);
        found.hear(&mut line, &target, patience, to).await?;
        found.window(&mut line, &target, to).await?;
        Ok::<_, NoArm>(line)
    };
    let mut line = tokio::select! {
        heard = listening => heard?,
        _ = &mut *stop => return Err(stopped()),
    };
    if asked.try_queue {
        let tried = trial(&mut line, stop).await?;
        found.queue(tried, &target, to)?;
    } else {
        found.leave_queue(to)?;
    }
    drop(line);
    let looking = async {
        let known = magician::arms::load()?;
        let options = Options::default().timeout(asked.patience);
        let options = options.for_arm(magician::arms::at(&known, &target));
        let arm = Arm::connect_with(&target, options).await?;
        let serial = matches!(
            target,
            Target::Serial(_) | Target::Usb { .. } | Target::Arm(_)
        );
        let looked = found.examine(&arm, asked.count, serial, to).await;
        arm.close().await;
        looked
    };
    tokio::select! {
        looked = looking => looked,
        _ = stop => Err(stopped()),
    }
}

/// The figure: a number, a text, or a dictionary.
fn figure<'py>(py: Python<'py>, value: &Measured) -> PyResult<Bound<'py, PyAny>> {
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
        _ => Ok(py.None().into_bound(py)),
    }
}

/// A finding: check, ok, value, unit, text, advice.
fn told<'py>(py: Python<'py>, finding: &Finding) -> PyResult<Bound<'py, PyAny>> {
    let advice = finding.advice.as_ref();
    let advice = advice.map(|advice| advice.said(&voice::Python));
    let parts = (
        finding.check,
        finding.ok,
        figure(py, &finding.value)?,
        finding.unit,
        finding.text.as_str(),
        advice,
    );
    parts.into_bound_py_any(py)
}

fn error(none: NoArm) -> Error {
    let (kind, message) = match none {
        NoArm::Failed(error) => return error,
        NoArm::Found(kind, message) => (kind, message),
    };
    let code = match kind {
        ErrorKind::Port => ErrorCode::NoArm,
        ErrorKind::Timeout => ErrorCode::NoAnswer,
        _ => ErrorCode::NotAnArm,
    };
    Error::new(code, message)
}

/// Examines the arm at a port: all findings, the port, the window, the turnaround in ms, and the exception that ended it early.
/// `listener` hears each finding as it comes. Ctrl-C ends it.
#[pyfunction]
pub(crate) fn doctor(
    py: Python<'_>,
    port: Option<String>,
    count: u64,
    patience: f64,
    try_queue: bool,
    listener: Option<&Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let raise = |error: Error| errors::raise(py, &error);
    let environment = std::env::var("MAGICIAN_PORT").ok();
    let given = port.or(environment.filter(|port| !port.is_empty()));
    if let Some(port) = &given {
        port.parse::<Target>().map_err(raise)?;
    }
    let asked = Asked {
        given,
        count,
        patience: seconds(py, "the timeout", patience)?,
        try_queue,
    };
    let (tell, heard) = channel();
    let (stop, mut stopped) = oneshot::channel();
    runtime::apart("magician-doctor", move |runtime| {
        let mut found = Diagnosis::default();
        let mut to = Teller(tell.clone());
        let outcome = runtime.block_on(examine(&asked, &mut found, &mut to, &mut stopped));
        let _ = tell.send(Told::End(found, outcome));
    })
    .map_err(raise)?;
    hear(py, heard, stop, listener)
}

/// Hears the findings. An interrupt, or what the listener raises, ends the examination, and is raised once that has ended.
fn hear(
    py: Python<'_>,
    heard: Receiver<Told>,
    stop: oneshot::Sender<()>,
    listener: Option<&Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let heard = Mutex::new(heard);
    let (mut stop, mut interrupt) = (Some(stop), None);
    let findings = PyList::empty(py);
    loop {
        let told_now = py.detach(|| {
            let heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
            heard.recv_timeout(LOOK)
        });
        let done = match told_now {
            Err(RecvTimeoutError::Timeout) => py.check_signals(),
            Err(RecvTimeoutError::Disconnected) => {
                let error = Error::new(ErrorCode::Closed, "it ended without a result");
                return Err(interrupt.unwrap_or_else(|| errors::raise(py, &error)));
            }
            Ok(Told::Finding(finding)) => {
                let finding = told(py, &finding)?;
                findings.append(&finding)?;
                match listener {
                    Some(listener) if interrupt.is_none() => {
                        listener.call1((finding,)).and_then(|_| py.check_signals())
                    }
                    _ => Ok(()),
                }
            }
            Ok(Told::End(found, outcome)) => {
                if let Some(interrupt) = interrupt {
                    return Err(interrupt);
                }
                let ended = outcome.err().map(|none| errors::raise(py, &error(none)));
                let parts = (
                    findings,
                    found.port,
                    found.window,
                    found.turnaround_ms,
                    ended.map(|error| error.into_value(py)),
                );
                return parts.into_py_any(py);
            }
        };
        if let Err(error) = done {
            // Its end follows; a second interrupt changes nothing.
            interrupt.get_or_insert(error);
            let _ = stop.take().map(|stop| stop.send(()));
        }
    }
}
