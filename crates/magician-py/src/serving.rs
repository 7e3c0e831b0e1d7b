//! A virtual arm for other programs, served by a thread of its own.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use magician::serve::{Discovery, Endpoint, ServeError, Server};
use magician::sim::{Controller, Speed};
use magician::{Error, ErrorCode, ErrorKind};
use pyo3::prelude::*;
use tokio::runtime::Builder;
use tokio::sync::oneshot;

use crate::cell::controller;
use crate::errors;
use crate::runtime::Local;

/// So often a waiting thread looks whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(30);

/// A virtual arm that is served.
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

/// Serves until it is told to end.
fn serve(
    server: Server,
    ready: Sender<Vec<(&'static str, String)>>,
    end: oneshot::Receiver<()>,
) -> Result<(), ServeError> {
    let runtime = Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(ServeError::Timer)?;
    let server = server.on_ready(move |endpoints| {
        // Whoever asked may have gone: then the end is told soon.
        let _ = ready.send(endpoints.iter().map(named).collect());
    });
    runtime.block_on(server.serve_until(async { drop(end.await) }))
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
    let controller: Controller = controller(py, scenario, tool)?;
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
    let (end, told) = oneshot::channel();
    let thread = std::thread::Builder::new().name("magician-sim".to_owned());
    let thread = thread.spawn(move || serve(server, ready, told));
    let thread = thread.map_err(|error| raised(py, &ServeError::Timer(error)))?;
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
