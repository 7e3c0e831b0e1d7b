//! Virtual and shared arms for other programs, each served on a separate thread.

use std::io::{self, BufWriter};
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use magician::proxy::Settings;
use magician::serve::{
    Discovery, Endpoint, Endpoints, Notice, ProxyNotice, ProxyServer, ServeError, ServedArm, Server,
};
use magician::sim::Speed;
use magician::{Error, ErrorCode, ErrorKind, LineOptions, RawLine, SimSpeed, Target, VirtualArm};
use magician_job::files::WholeFile;
use pyo3::prelude::*;
use tokio::sync::oneshot;
use tracing::{info, warn};

use crate::call::SIGNAL_CHECK_INTERVAL;
use crate::cell::{Cell, controller, scenario_of};
use crate::core::{seconds, target};
use crate::errors;
use crate::runtime::{self, Local};

/// Name of the Python logger.
pub(crate) const LOGGER: &str = "magician";

/// Something that other programs can connect to.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Served {
    /// Kind and address of each endpoint.
    endpoints: Vec<(&'static str, String)>,
    serving: Local<Mutex<Option<Serving>>>,
}

struct Serving {
    end: oneshot::Sender<()>,
    thread: JoinHandle<Result<(), ServeFailure>>,
}

/// Reason why serving failed.
enum ServeFailure {
    Arm(Error),
    File(io::Error),
}

impl From<Error> for ServeFailure {
    fn from(error: Error) -> Self {
        Self::Arm(error)
    }
}

impl From<ServeError> for ServeFailure {
    fn from(error: ServeError) -> Self {
        let code = match error.kind() {
            ErrorKind::InvalidInput => ErrorCode::InvalidValue,
            _ => ErrorCode::PortFailed,
        };
        Error::new(code, error.to_string()).into()
    }
}

impl ServeFailure {
    fn into_exception(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Arm(error) => errors::raise(py, &error),
            Self::File(error) => error.into(),
        }
    }
}

fn endpoint_parts(endpoint: &Endpoint) -> (&'static str, String) {
    let kind = match endpoint {
        Endpoint::Udp(_) => "udp",
        Endpoint::Tcp(_) => "tcp",
        Endpoint::Discovery(_) => "discovery",
        // The only other kind, on systems with pseudo-terminals.
        _ => "pty",
    };
    (kind, endpoint.to_string())
}

/// Endpoints to serve: paths of pseudo-terminals, an address for UDP, one for TCP.
#[derive(FromPyObject)]
pub(crate) struct EndpointAddresses(Vec<PathBuf>, Option<String>, Option<String>);

impl EndpointAddresses {
    fn endpoints(self, py: Python<'_>) -> PyResult<Endpoints> {
        let Self(paths, udp, tcp) = self;
        // Unused on systems without pseudo-terminals.
        #[cfg_attr(not(unix), allow(unused_mut))]
        let mut endpoints = Endpoints::new();
        for path in paths {
            #[cfg(unix)]
            {
                endpoints = endpoints.pty(path);
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
        let _ = py;
        let endpoints = udp.into_iter().fold(endpoints, Endpoints::udp);
        Ok(tcp.into_iter().fold(endpoints, Endpoints::tcp))
    }
}

/// Sends the endpoints once all of them accept connections.
type Ready = Sender<Vec<(&'static str, String)>>;

fn send_ready(ready: &Ready, endpoints: &[Endpoint]) {
    // The receiver may be gone: the caller was interrupted, and the end follows.
    let _ = ready.send(endpoints.iter().map(endpoint_parts).collect());
}

/// Serves a virtual arm at these endpoints; returns when all of them accept connections.
#[pyfunction]
pub(crate) fn serve_sim(
    py: Python<'_>,
    scenario: Option<&str>,
    speed: f64,
    tool: Option<[f64; 3]>,
    addresses: EndpointAddresses,
) -> PyResult<Served> {
    let controller = controller(scenario_of(py, scenario)?.as_ref(), tool);
    let speed = if speed == 0.0 {
        Speed::Max
    } else {
        Speed::Times(speed)
    };
    let server = Server::new(controller)
        .speed(speed)
        .endpoints(addresses.endpoints(py)?)
        .discovery(Discovery::default());
    Served::start(py, "magician-sim", async move |ready, stopped| {
        let server = server.on_ready(move |endpoints| send_ready(&ready, endpoints));
        Ok(server.serve_until(async { drop(stopped.await) }).await?)
    })
}

/// Serves an arm of this process at these endpoints. Returns once all of them accept connections.
pub(crate) fn serve_arm(
    py: Python<'_>,
    arm: VirtualArm,
    addresses: EndpointAddresses,
) -> PyResult<Served> {
    let endpoints = addresses.endpoints(py)?;
    Served::start(py, "magician-arm", async move |ready, stopped| {
        let served = ServedArm::open(arm, &endpoints)?;
        send_ready(&ready, &served.endpoints());
        served.serve_until(stopped).await?.ok();
        Ok(())
    })
}

/// Logs a notice of the proxy.
fn log(notice: ProxyNotice<'_>) {
    match notice {
        ProxyNotice::Client(Notice::Connected(who)) => info!(target: LOGGER, "{who} connected"),
        ProxyNotice::Client(Notice::Left(who)) => info!(target: LOGGER, "{who} left"),
        ProxyNotice::Client(Notice::Refused(who)) => {
            warn!(target: LOGGER, "{who} refused: too many connections");
        }
        ProxyNotice::LineLost(why) => {
            warn!(target: LOGGER, "{why}; looking for the line, no replies until it is back");
        }
        ProxyNotice::LineFound => warn!(target: LOGGER, "the line to the arm is back"),
        ProxyNotice::TraceEnded(error) => {
            warn!(target: LOGGER, "the trace of the proxy ends here: {error}");
        }
        ProxyNotice::JogNotConfirmed => {
            warn!(target: LOGGER, "the arm did not confirm that the jog has ended");
        }
        _ => {}
    }
}

/// Shares the arm at a port, or a virtual one of this process, between programs; returns when all endpoints accept connections.
#[pyfunction]
#[pyo3(signature = (port, arm, addresses, *, faults, trace, fresh, transparent, keep_going))]
// Each Python keyword is an argument.
#[allow(clippy::too_many_arguments)]
pub(crate) fn serve_proxy(
    py: Python<'_>,
    port: Option<&str>,
    arm: Option<&Bound<'_, Cell>>,
    addresses: EndpointAddresses,
    faults: &str,
    trace: Option<PathBuf>,
    fresh: f64,
    transparent: bool,
    keep_going: bool,
) -> PyResult<Served> {
    runtime::ready(py)?;
    let raise = |error: Error| errors::raise(py, &error);
    let endpoints = addresses.endpoints(py)?;
    let fresh = seconds(py, "fresh", fresh)?;
    let settings = Settings {
        max_reply_age: u64::try_from(fresh.as_micros()).unwrap_or(u64::MAX),
        transparent,
        keep_going,
        ..Settings::default()
    };
    let options = LineOptions::default().faults(faults.parse().map_err(raise)?);
    let arm = arm.map(|cell| cell.get().arm.clone());
    let place = match arm {
        Some(_) => Target::Sim(SimSpeed::Max),
        None => py.detach(|| target(port)).map_err(raise)?,
    };
    Served::start(py, "magician-proxy", async move |ready, mut stopped| {
        let opening = async {
            match arm {
                Some(arm) => RawLine::simulated(arm, options).await,
                None => RawLine::open_with(&place, options).await,
            }
        };
        let line = tokio::select! {
            line = opening => line?,
            _ = &mut stopped => return Ok(()),
        };
        let name = line.name().to_owned();
        let mut proxy = ProxyServer::open(line, &endpoints, settings)?.observed(log);
        if let Some(path) = trace {
            let with_path = |error: io::Error| {
                let message = format!("{} cannot be written: {error}", path.display());
                ServeFailure::File(io::Error::new(error.kind(), message))
            };
            let file = BufWriter::new(WholeFile::grow(&path).map_err(with_path)?);
            proxy = proxy.traced(file).map_err(with_path)?;
        }
        let endpoints = proxy.endpoints();
        for endpoint in endpoints.iter().filter(|endpoint| endpoint.is_exposed()) {
            if !matches!(place, Target::Sim(_)) {
                warn!(
                    target: LOGGER,
                    "every computer that reaches {endpoint} can move the arm at {name} without a password; serve \
                     127.0.0.1 to allow only programs on this computer"
                );
            }
        }
        send_ready(&ready, &endpoints);
        proxy.serve_until(stopped).await?.ok();
        Ok(())
    })
}

impl Served {
    /// Starts a thread that serves until it is closed. Returns once all endpoints accept
    /// connections.
    fn start(
        py: Python<'_>,
        name: &str,
        serve: impl AsyncFnOnce(Ready, oneshot::Receiver<()>) -> Result<(), ServeFailure>
        + Send
        + 'static,
    ) -> PyResult<Self> {
        let (ready, begun) = channel();
        let (end, stopped) = oneshot::channel();
        let thread =
            runtime::spawn_separately(name, move |runtime| runtime.block_on(serve(ready, stopped)));
        let thread = thread.map_err(|error| errors::raise(py, &error))?;
        let begun = Mutex::new(begun);
        let begun = || {
            let begun = begun.lock().unwrap_or_else(PoisonError::into_inner);
            begun.recv_timeout(SIGNAL_CHECK_INTERVAL)
        };
        // Wait until it serves, or until its thread ends with the reason. An interrupt drops the
        // sender and so ends the thread.
        let endpoints = loop {
            match py.detach(begun) {
                Ok(endpoints) => break endpoints,
                Err(RecvTimeoutError::Timeout) => py.check_signals()?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(match py.detach(move || thread.join()) {
                        Ok(Err(error)) => error.into_exception(py),
                        _ => {
                            let message = "it ended before it was served";
                            errors::raise(py, &Error::new(ErrorCode::PortFailed, message))
                        }
                    });
                }
            }
        };
        let serving = Serving { end, thread };
        Ok(Self {
            endpoints,
            serving: Local::new(Mutex::new(Some(serving))),
        })
    }

    fn take(&self) -> Option<Serving> {
        let serving = self.serving.here()?.lock();
        serving.unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[pymethods]
impl Served {
    /// Kind (`"pty"`, `"udp"`, `"tcp"` or `"discovery"`) and address of each endpoint.
    fn endpoints(&self) -> Vec<(&'static str, String)> {
        self.endpoints.clone()
    }

    /// True while it is served.
    fn is_open(&self) -> bool {
        let serving = self.serving.here().map(Mutex::lock);
        serving.is_some_and(|serving| {
            serving
                .unwrap_or_else(PoisonError::into_inner)
                .as_ref()
                .is_some_and(|serving| !serving.thread.is_finished())
        })
    }

    /// Waits until it fails or is closed, at most for a time in seconds. Returns true if it is
    /// still served. An interrupt ends the wait.
    #[pyo3(signature = (timeout))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<bool> {
        let begun = Instant::now();
        while self.is_open() {
            if timeout.is_some_and(|timeout| begun.elapsed().as_secs_f64() >= timeout) {
                return Ok(true);
            }
            py.detach(|| std::thread::sleep(SIGNAL_CHECK_INTERVAL));
            py.check_signals()?;
        }
        Ok(false)
    }

    /// Stops the server and removes what it created before it returns.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let Some(serving) = self.take() else {
            return Ok(());
        };
        // Fails if serving has already ended by itself.
        let _ = serving.end.send(());
        match py.detach(move || serving.thread.join()) {
            Ok(Err(error)) => Err(error.into_exception(py)),
            _ => Ok(()),
        }
    }
}
