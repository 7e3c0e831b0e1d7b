//! A connected arm: connecting, options, and the end of a connection.

mod belt;
mod feed;
mod found;
mod motion;
mod program;
mod verbs;
mod watches;

use std::future::Future;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use magician::{Arm, Error, Link, Options, Target, Tracer};
use magician_job::files::WholeFile;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use tokio::task::JoinHandle;

use crate::call::Call;
use crate::runtime::{self, Local};
use crate::{errors, station};

pub(crate) use feed::Feed;
pub(crate) use found::{discover, ports};
pub(crate) use program::Program;
pub(crate) use watches::{Events, Jog, StateWatch};

/// Number of dropped connections that have not shut down yet. The end of the interpreter waits for
/// them.
static PENDING_SHUTDOWNS: AtomicUsize = AtomicUsize::new(0);
/// Longest wait for the shutdown of a connection. A choice: a program should end quickly even if an
/// arm does not answer.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(1);

/// A connected arm.
#[pyclass(frozen, weakref, module = "magician._magician")]
pub(crate) struct Core {
    arm: Local<Arm>,
    /// Lines to the arm through a station.
    station_lines: StationLines,
}

/// Lines that end shortly after their connection.
pub(crate) type StationLines = Arc<Mutex<Vec<JoinHandle<()>>>>;

/// Converts a number of seconds from Python.
///
/// # Errors
/// `magician.errors.InvalidInputError` if it is negative, NaN or too large.
pub(crate) fn seconds(py: Python<'_>, what: &str, seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds).map_err(|_| {
        let message = format!("{what} is {seconds}; it must be a number of seconds, 0 or more");
        errors::raise(py, &Error::invalid(message))
    })
}

/// Builds the options of a connection.
///
/// # Errors
/// `magician.errors.InvalidInputError` for an invalid duration.
pub(crate) fn options(
    py: Python<'_>,
    timeout: f64,
    window: usize,
    probe: bool,
    reconnect: bool,
    echo: f64,
) -> PyResult<Options> {
    Ok(Options::default()
        .timeout(seconds(py, "the timeout", timeout)?)
        .window(window)
        .probe(probe)
        .reconnect(reconnect)
        .echo(seconds(py, "the echo", echo)?)
        .homings(magician_job::homings()))
}

/// Sets a given fence in place of the one in the settings file.
pub(crate) fn with_fence(
    py: Python<'_>,
    options: Options,
    fence: Option<&str>,
) -> PyResult<Options> {
    let Some(text) = fence else {
        return Ok(options);
    };
    let fence = magician::arms::fence(text);
    let fence = fence.map_err(|error| errors::raise(py, &error))?;
    Ok(options.fence(fence))
}

/// Opens a trace file of the line, if one is wanted.
///
/// # Errors
/// `OSError` if the file cannot be written.
pub(crate) fn with_trace(options: Options, trace: Option<PathBuf>) -> PyResult<Options> {
    let Some(path) = trace else {
        return Ok(options);
    };
    let file = WholeFile::grow(&path).and_then(Tracer::new);
    let tracer = file.map_err(|why| {
        let message = format!("{} cannot be written: {why}", path.display());
        std::io::Error::new(why.kind(), message)
    })?;
    Ok(options.trace(tracer))
}

/// Resolves the target: the given port, otherwise `MAGICIAN_PORT`, otherwise the only arm that is
/// plugged in.
pub(crate) fn target(port: Option<&str>) -> magician::Result<Target> {
    let environment = std::env::var("MAGICIAN_PORT").ok();
    let named = environment.as_deref().filter(|port| !port.is_empty());
    match port.or(named) {
        Some(port) => port.parse(),
        None => Target::discover(),
    }
}

impl Core {
    /// Connects; the result of the call is the `Core`.
    ///
    /// # Errors
    /// `magician.errors.PortError` if the system provides no thread.
    pub(crate) fn connecting<F>(py: Python<'_>, connecting: F) -> PyResult<Call>
    where
        F: Future<Output = magician::Result<Arm>> + Send + 'static,
    {
        Self::connecting_by(py, connecting, StationLines::default())
    }

    /// Like [`connecting`](Self::connecting), for an arm behind station lines, whose ends `close`
    /// waits for.
    ///
    /// # Errors
    /// Those of [`connecting`](Self::connecting).
    pub(crate) fn connecting_by<F>(
        py: Python<'_>,
        connecting: F,
        station_lines: StationLines,
    ) -> PyResult<Call>
    where
        F: Future<Output = magician::Result<Arm>> + Send + 'static,
    {
        runtime::ready(py)?;
        Ok(Call::start(connecting, |py, arm| {
            let arm = Local::new(arm);
            Ok(Py::new(py, Core { arm, station_lines })?.into_any())
        }))
    }

    /// Returns the arm, in the process that connected it.
    ///
    /// # Errors
    /// `magician.errors.ClosedError` in a forked child.
    pub(crate) fn arm(&self, py: Python<'_>) -> PyResult<Arm> {
        self.arm.get(py).cloned()
    }

    /// Returns the arm, with permission to use the laser for this call if `allow_laser` is set.
    ///
    /// # Errors
    /// Those of [`arm`](Self::arm).
    pub(crate) fn burning(&self, py: Python<'_>, allow_laser: bool) -> PyResult<Arm> {
        let arm = self.arm(py)?;
        Ok(if allow_laser {
            arm.allowing_laser()
        } else {
            arm
        })
    }
}

#[pymethods]
impl Core {
    /// Connects to the arm at a port.
    #[staticmethod]
    #[pyo3(signature = (port, *, timeout, window, probe, reconnect, echo, fence = None, trace = None))]
    // Each Python keyword is an argument.
    #[allow(clippy::too_many_arguments)]
    fn connect(
        py: Python<'_>,
        port: Option<&str>,
        timeout: f64,
        window: usize,
        probe: bool,
        reconnect: bool,
        echo: f64,
        fence: Option<&str>,
        trace: Option<PathBuf>,
    ) -> PyResult<Call> {
        let options = options(py, timeout, window, probe, reconnect, echo)?;
        if let Some(url) = station::url_of(port) {
            let options = with_trace(with_fence(py, options, fence)?, trace)?;
            return station::arm_at(py, url, options);
        }
        let target = py.detach(|| target(port));
        let target = target.map_err(|error| errors::raise(py, &error))?;
        let known = py.detach(magician::arms::load);
        let known = known.map_err(|error| errors::raise(py, &error))?;
        let options = options.for_arm(magician::arms::at(&known, &target));
        let options = with_trace(with_fence(py, options, fence)?, trace)?;
        Self::connecting(py, async move { Arm::connect_with(&target, options).await })
    }

    /// Closes the connection.
    fn close(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        let station_lines = std::mem::take(
            &mut *self
                .station_lines
                .lock()
                .unwrap_or_else(PoisonError::into_inner),
        );
        Ok(Call::lasting(async move {
            let closing = async {
                arm.clone().close().await;
                for end in station_lines {
                    let _ = end.await;
                }
            };
            let _ = tokio::time::timeout(SHUTDOWN_TIMEOUT, closing).await;
            arm.front_end().end_trace();
            Ok(())
        }))
    }

    /// True if it was created in this process, False in a forked child.
    fn is_here(&self) -> bool {
        self.arm.here().is_some()
    }

    fn detach(&self, py: Python<'_>) -> PyResult<()> {
        self.arm.get(py).map(Arm::detach)
    }

    /// Switches off what the connection left on: a laser that it lit, unless its program is still
    /// running, and motors that it started.
    fn let_go(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::lasting(async move {
            arm.laser().switch_off_after().await?;
            arm.motors().stop().await
        }))
    }

    /// True if the laser is on; `None` if unknown.
    fn laser(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::start(
            async move { arm.laser().is_on().await },
            |py, on| Ok(on.into_pyobject(py)?.into_any().unbind()),
        ))
    }

    fn name(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.arm.get(py)?.name().to_owned())
    }

    fn timeout(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.arm.get(py)?.timeout().as_secs_f64())
    }

    fn set_timeout(&self, py: Python<'_>, timeout: f64) -> PyResult<()> {
        let timeout = seconds(py, "the timeout", timeout)?;
        self.arm.get(py)?.set_timeout(timeout);
        Ok(())
    }

    fn moving(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.arm.get(py)?.moving())
    }

    /// State of the line, reason of a loss, true if it reconnects, and seconds since the loss.
    fn link(&self, py: Python<'_>) -> PyResult<LinkParts> {
        Ok(link(&self.arm.get(py)?.link()))
    }

    /// Traffic counters, and capacity of the queue.
    fn stats(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::start(
            async move { arm.stats().await },
            |py, (stats, capacity)| {
                let counts = (
                    stats.sent,
                    stats.resent,
                    stats.bytes,
                    stats.frames,
                    stats.late,
                    stats.unsolicited,
                    stats.noise,
                    capacity,
                );
                Ok(counts.into_pyobject(py)?.into_any().unbind())
            },
        ))
    }

    /// Waits until a lost line is reconnected.
    fn reconnected(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::plain(async move { arm.reconnected().await }))
    }
}

impl Drop for Core {
    /// Lets the last handle shut the connection down in the background. The end of the interpreter
    /// waits for it.
    fn drop(&mut self) {
        let Some(arm) = self.arm.here() else { return };
        let mut events = arm.events();
        PENDING_SHUTDOWNS.fetch_add(1, Ordering::SeqCst);
        let leaving = async move {
            let ended = async { while events.next().await.is_some() {} };
            let _ = tokio::time::timeout(SHUTDOWN_TIMEOUT, ended).await;
            PENDING_SHUTDOWNS.fetch_sub(1, Ordering::SeqCst);
        };
        if runtime::spawn(leaving).is_none() {
            PENDING_SHUTDOWNS.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

/// `"up"`, `"lost"` or `"closed"`; and for a lost line the reason, true if it is searched for, and
/// the seconds since the loss.
pub(crate) type LinkParts = (&'static str, Option<String>, bool, f64);

fn link(link: &Link) -> LinkParts {
    match link {
        Link::Lost { since, why, sought } => (
            "lost",
            Some(why.to_string()),
            *sought,
            since.elapsed().as_secs_f64(),
        ),
        Link::Closed => ("closed", None, false, 0.0),
        _ => ("up", None, false, 0.0),
    }
}

/// Shuts down before the interpreter ends. Connections are closed and the log is flushed when this
/// returns; Python is not called any more.
#[pyfunction]
pub(crate) fn end(py: Python<'_>) {
    let begun = Instant::now();
    py.detach(|| {
        while PENDING_SHUTDOWNS.load(Ordering::SeqCst) > 0 && begun.elapsed() < SHUTDOWN_TIMEOUT {
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    runtime::end(py);
}

/// Resets the state in a forked child: the parent closes the connections.
#[pyfunction]
pub(crate) fn forked() {
    PENDING_SHUTDOWNS.store(0, Ordering::SeqCst);
}

/// Finds the class of `magician.commands` for a name. `form` is `"get"` or `"set"`.
#[pyfunction]
pub(crate) fn find(py: Python<'_>, name: &str, form: &str) -> PyResult<&'static str> {
    use magician::protocol::Row;
    let found = match form {
        "get" => Row::find_readable(name).ok().and_then(|row| {
            let asks = row.query.filter(|query| !query.fields.is_empty());
            asks.or(row.value)
        }),
        "set" => Row::find_writable(name).ok().and_then(|row| row.set),
        _ => return Err(PyTypeError::new_err("the form is \"get\" or \"set\"")),
    };
    found.map(|layout| layout.name).ok_or_else(|| {
        let message = format!("unknown command `{name}` to {form}");
        errors::raise(py, &Error::invalid(message))
    })
}

/// Known tools: bias x, y, z in mm by name.
#[pyfunction]
pub(crate) fn tools() -> Vec<(&'static str, (f64, f64, f64))> {
    let tools = magician::ToolBias::NAMED.iter();
    let tools = tools.map(|(name, at)| (*name, (at.x, at.y, at.z)));
    tools.collect()
}

/// Encodes the parameters of a command.
#[pyfunction]
pub(crate) fn encode<'py>(command: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let kind = crate::values::kind(command)?;
    let params = crate::values::encode(kind.row, kind.layout, command)?;
    Ok(PyBytes::new(command.py(), &params))
}

/// Decodes a set command from its id and parameters.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, id: u8, params: &[u8]) -> PyResult<Py<PyAny>> {
    let command = magician::Set::decode(id, params);
    let command = command.map_err(|error| errors::raise(py, &error.into()))?;
    crate::values::object(py, &command)
}

/// Decodes a command of a class from its parameters.
#[pyfunction]
pub(crate) fn decode(class_: &Bound<'_, PyAny>, params: &[u8]) -> PyResult<Py<PyAny>> {
    let kind = crate::values::kind(class_)?;
    crate::values::decode(class_, kind.layout, params)
}
