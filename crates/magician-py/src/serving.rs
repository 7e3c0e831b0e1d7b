//! A virtual arm for other programs, served by a thread of its own.

use std::sync::mpsc::channel;
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use magician::serve::{Discovery, Endpoint, ServeError, Server};
use magician::sim::Speed;
use magician::{Error, ErrorCode, ErrorKind};
use pyo3::prelude::*;
use tokio::sync::oneshot;

use crate::call::LOOK;
use crate::cell::{controller, scenario_of};
use crate::errors;
use crate::runtime::{self, Local};

/// A virtual arm that other programs can connect to.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Served {
    /// What each endpoint is, and where.
    endpoints: Vec<(&'static str, String)>,
    serving: Local<Mutex<Option<Serving>>>,
}

struct Serving {
    end: oneshot::Sender<()>,
    thread: JoinHandle<Result<(), ServeError>>,
}

fn raised(py: Python<'_>, error: &ServeError) -> PyErr {
    let code = match error.kind() {
        ErrorKind::InvalidInput => ErrorCode::InvalidValue,
        _ => ErrorCode::PortFailed,
    };
    errors::raise(py, &Error::new(code, error.to_string()))
}

fn named(endpoint: &Endpoint) -> (&'static str, String) {
    let kind = match endpoint {
        Endpoint::Udp(_) => "udp",
        Endpoint::Tcp(_) => "tcp",
        Endpoint::Discovery(_) => "discovery",
        _ => "pty",
    };
    (kind, endpoint.to_string())
}

/// Serves a virtual arm at these endpoints; returns when all of them accept connections.
#[pyfunction]
#[pyo3(signature = (scenario, speed, tool, *, pty, udp, tcp))]
pub(crate) fn serve_sim(
    py: Python<'_>,
    scenario: Option<&str>,
    speed: f64,
    tool: Option<[f64; 3]>,
    pty: Option<std::path::PathBuf>,
    udp: Option<String>,
    tcp: Option<String>,
) -> PyResult<Served> {
    let controller = controller(scenario_of(py, scenario)?.as_ref(), tool);
    let speed = if speed == 0.0 {
        Speed::Max
    } else {
        Speed::Times(speed)
    };
    let mut server = Server::new(controller)
        .speed(speed)
        .discovery(Discovery::default());
    if let Some(path) = pty {
        #[cfg(unix)]
        {
            server = server.pty(path);
        }
        #[cfg(not(unix))]
        {
            let error = format!("{}: this system has no pseudo-terminals", path.display());
            return Err(errors::raise(
                py,
                &Error::new(ErrorCode::Unsupported, error),
            ));
        }
    }
    if let Some(address) = udp {
        server = server.udp(address);
    }
    if let Some(address) = tcp {
        server = server.tcp(address);
    }
    let (ready, begun) = channel();
    let (end, told) = oneshot::channel::<()>();
    let server = server.on_ready(move |endpoints| {
        // The caller may have been interrupted: then the end follows.
        let _ = ready.send(endpoints.iter().map(named).collect());
    });
    let thread = runtime::apart("magician-sim", move |runtime| {
        runtime.block_on(server.serve_until(async { drop(told.await) }))
    });
    let thread = thread.map_err(|error| errors::raise(py, &error))?;
    // It has begun, or its end says why not.
    let Ok(endpoints) = py.detach(move || begun.recv()) else {
        return Err(match py.detach(move || thread.join()) {
            Ok(Err(error)) => raised(py, &error),
            _ => {
                let message = "it ended before it was served";
                errors::raise(py, &Error::new(ErrorCode::PortFailed, message))
            }
        });
    };
    let serving = Serving { end, thread };
    Ok(Served {
        endpoints,
        serving: Local::new(Mutex::new(Some(serving))),
    })
}

impl Served {
    fn take(&self) -> Option<Serving> {
        let serving = self.serving.here()?.lock();
        serving.unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[pymethods]
impl Served {
    /// What each endpoint is, `"pty"`, `"udp"`, `"tcp"` or `"discovery"`, and what to connect to.
    fn endpoints(&self) -> Vec<(&'static str, String)> {
        self.endpoints.clone()
    }

    /// Whether it is served.
    fn is_open(&self) -> bool {
        let serving = self.serving.here().map(Mutex::lock);
        serving.is_some_and(|serving| {
            serving
                .unwrap_or_else(PoisonError::into_inner)
                .as_ref()
                .is_some_and(|serving| !serving.thread.is_finished())
        })
    }

    /// Waits until it breaks down or is closed, at most so many seconds; an interrupt ends the wait. Whether it is still served.
    #[pyo3(signature = (timeout))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<bool> {
        let begun = Instant::now();
        while self.is_open() {
            if timeout.is_some_and(|timeout| begun.elapsed().as_secs_f64() >= timeout) {
                return Ok(true);
            }
            py.detach(|| std::thread::sleep(LOOK));
            py.check_signals()?;
        }
        Ok(false)
    }

    /// Ends it: what it made is gone when this returns.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let Some(serving) = self.take() else {
            return Ok(());
        };
        // One that broke down listens no more.
        let _ = serving.end.send(());
        match py.detach(move || serving.thread.join()) {
            Ok(Err(error)) => Err(raised(py, &error)),
            _ => Ok(()),
        }
    }
}
