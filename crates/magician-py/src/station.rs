//! A session at a station, and arms through it.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician::{Arm, Error, ErrorCode, HomingRecord, Options};
use magician_station::client::{
    ClientError, Connection, Notice, StationAddress, StationClient, StationHomings, StationLine,
};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use serde_json::Value;
use tokio::sync::{Mutex as Turn, broadcast, watch};

use crate::call::Call;
use crate::core::{Core, StationLines, options, with_fence};
use crate::errors;
use crate::runtime::{self, Local};

/// Longest time for the end of a session.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// A session at a station.
#[pyclass(frozen, weakref, module = "magician._magician")]
pub(crate) struct Station {
    client: Local<Mutex<Option<StationClient>>>,
    /// Leases of the session, without those of its arms.
    leases: Arc<Mutex<Vec<String>>>,
    hello: String,
}

/// The notifications of a station, and whether it is connected.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Notices {
    inner: Local<Arc<Turn<NoticeReceiver>>>,
}

struct NoticeReceiver {
    notices: broadcast::Receiver<Notice>,
    connection: watch::Receiver<Connection>,
}

/// Next message: method and parameters of a notification, or a change of the connection.
type NextMessage = Option<(String, String)>;

impl NoticeReceiver {
    async fn next(&mut self) -> NextMessage {
        use broadcast::error::RecvError;
        tokio::select! {
            // Deliver pending notifications before the change of the connection that followed them.
            biased;
            notice = self.notices.recv() => match notice {
                Ok(notice) => Some((notice.method, notice.params.to_string())),
                Err(RecvError::Lagged(count)) => Some(("missed".to_owned(), count.to_string())),
                Err(RecvError::Closed) => None,
            },
            changed = self.connection.changed() => {
                changed.ok()?;
                let state = name(*self.connection.borrow_and_update());
                Some(("connection".to_owned(), format!("\"{state}\"")))
            }
        }
    }
}

fn name(connection: Connection) -> &'static str {
    match connection {
        Connection::Up => "up",
        Connection::Lost => "lost",
        _ => "closed",
    }
}

/// Creates the exception of a failed request.
fn to_exception(py: Python<'_>, error: &ClientError) -> PyErr {
    let made = || -> PyResult<PyErr> {
        let refused = py.import("magician._conversion")?.getattr("refused")?;
        let (code, data) = match error {
            // "Invalid params" of JSON-RPC 2.0.
            ClientError::Address(_) => (-32602, None),
            ClientError::Refused { code, data, .. } => (*code, Some(data.to_string())),
            // There was no reply, so no code.
            _ => (0, None),
        };
        let exception = refused.call1((code, error.to_string(), data))?;
        Ok(PyErr::from_value(exception))
    };
    made().unwrap_or_else(|failed| failed)
}

/// Converts a client error to an error of the driver.
fn failed(error: &ClientError) -> Error {
    match error {
        ClientError::Address(why) => Error::invalid(why.clone()),
        error => Error::new(ErrorCode::PortFailed, error.to_string()),
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Converts a result to JSON text.
fn to_json(py: Python<'_>, outcome: Result<Value, ClientError>) -> PyResult<Py<PyAny>> {
    match outcome {
        Ok(value) => value.to_string().into_py_any(py),
        Err(error) => Err(to_exception(py, &error)),
    }
}

/// Starts a request to a station.
fn request_call<F>(task: F) -> Call
where
    F: Future<Output = Result<Value, ClientError>> + Send + 'static,
{
    Call::start(async move { Ok::<_, Error>(task.await) }, to_json)
}

/// Parses parameters from JSON.
fn parameters(py: Python<'_>, text: &str) -> PyResult<Value> {
    let invalid = |error: serde_json::Error| errors::raise(py, &Error::invalid(error.to_string()));
    serde_json::from_str(text).map_err(invalid)
}

/// Returns the station that the port names, or `MAGICIAN_PORT` if no port is given. `None` if it is
/// not a URL.
pub(crate) fn url_of(port: Option<&str>) -> Option<String> {
    let environment = std::env::var("MAGICIAN_PORT").ok();
    let port = port.or(environment.as_deref())?;
    let schemes = ["http://", "https://", "ws://", "wss://"];
    { schemes.iter() }
        .any(|scheme| port.starts_with(scheme))
        .then(|| port.to_owned())
}

/// Connects to an arm at `http://HOST:PORT/ARM`, in a new session.
pub(crate) fn arm_at(py: Python<'_>, url: String, options: Options) -> PyResult<Call> {
    let ends = StationLines::default();
    let lines = Arc::clone(&ends);
    let opening = async move {
        let address: StationAddress = url.parse().map_err(Error::invalid)?;
        let token = std::env::var("MAGICIAN_TOKEN").ok();
        let token = token.as_deref().filter(|token| !token.is_empty());
        let client = StationClient::connect(&url, "magician", token).await;
        let client = client.map_err(|error| failed(&error))?;
        open(client, address.arm, options, lines).await
    };
    Core::connecting_by(py, opening, ends)
}

/// Connects to an arm of a session. A lost connection is searched for again, like a lost line.
async fn open(
    client: StationClient,
    arm: Option<String>,
    options: Options,
    ends: StationLines,
) -> magician::Result<Arm> {
    let arms = client.hello()["arms"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let known = |arm: &String| arms.iter().any(|name| name == arm);
    if !arm.as_ref().map_or(arms.len() == 1, known) {
        let names: Vec<_> = arms.iter().filter_map(Value::as_str).collect();
        let message = format!("the station has the arms {}: name one", names.join(", "));
        return Err(Error::invalid(message));
    }
    let is_virtual = client.is_virtual(arm.as_deref()).await;
    let options = options.virtual_arm(is_virtual.map_err(|error| failed(&error))?);
    let homings = Arc::new(StationHomings::default());
    let options = options.homings(Arc::clone(&homings) as Arc<dyn HomingRecord>);
    let options = options.end_notice(client.end_notice());
    let opener = move || {
        let (client, arm, ends) = (client.clone(), arm.clone(), Arc::clone(&ends));
        let homings = Arc::clone(&homings);
        async move {
            if *client.connection().borrow() != Connection::Up {
                return Err(io::Error::other("there is no connection to the station"));
            }
            let asked = homings.read_from(&client, arm.as_deref()).await;
            asked.map_err(|error| io::Error::other(error.to_string()))?;
            // Permissions for laser and danger are checked by this process, and by the role at the
            // station.
            let (line, end) = StationLine::open(&client, arm.as_deref(), true);
            let mut ends = locked(&ends);
            ends.retain(|end| !end.is_finished());
            ends.push(end);
            Ok(line)
        }
    };
    Arm::over_with(opener, options).await
}

impl Station {
    fn held(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Option<StationClient>>> {
        Ok(locked(self.client.get(py)?))
    }

    fn client(&self, py: Python<'_>) -> PyResult<StationClient> {
        self.held(py)?.clone().ok_or_else(|| {
            let message = "the session has been closed";
            errors::raise(py, &Error::new(ErrorCode::Closed, message))
        })
    }
}

#[pymethods]
impl Station {
    /// Starts a session.
    #[staticmethod]
    fn connect(py: Python<'_>, url: String, name: String, token: Option<String>) -> PyResult<Call> {
        runtime::ready(py)?;
        let connecting = async move {
            Ok::<_, Error>(StationClient::connect(&url, &name, token.as_deref()).await)
        };
        Ok(Call::start(connecting, |py, client| {
            let client = client.map_err(|error| to_exception(py, &error))?;
            let hello = client.hello().to_string();
            let client = Local::new(Mutex::new(Some(client)));
            let leases = Arc::default();
            Self {
                client,
                leases,
                hello,
            }
            .into_py_any(py)
        }))
    }

    /// Greeting of the station, in JSON.
    fn hello(&self) -> &str {
        &self.hello
    }

    /// `up`, `lost` or `closed`.
    fn connection(&self, py: Python<'_>) -> PyResult<&'static str> {
        let client = self.held(py)?;
        Ok({ client.as_ref() }.map_or("closed", |client| name(*client.connection().borrow())))
    }

    /// Calls a method. Parameters and result are JSON.
    fn call(&self, py: Python<'_>, method: String, params: &str) -> PyResult<Call> {
        let (client, params) = (self.client(py)?, parameters(py, params)?);
        Ok(request_call(
            async move { client.call(&method, params).await },
        ))
    }

    /// Calls a method that acquires a lease, as `call`.
    fn lease(&self, py: Python<'_>, method: String, params: &str) -> PyResult<Call> {
        let (client, params) = (self.client(py)?, parameters(py, params)?);
        let leases = Arc::clone(&self.leases);
        Ok(request_call(async move {
            let granted = client.lease(&method, params).await?;
            let lease = granted["lease"].as_str().map(str::to_owned);
            locked(&leases).extend(lease);
            Ok(granted)
        }))
    }

    /// Releases a lease.
    fn release(&self, py: Python<'_>, lease: String) -> PyResult<Call> {
        let client = self.client(py)?;
        let mut leases = locked(&self.leases);
        if let Some(at) = leases.iter().position(|held| *held == lease) {
            leases.swap_remove(at);
        }
        drop(leases);
        let releasing = async move { client.release(&lease).await.map(|()| Value::Null) };
        Ok(request_call(releasing))
    }

    /// Sends a notification, which has no reply.
    fn notify(&self, py: Python<'_>, method: &str, params: &str) -> PyResult<()> {
        let params = parameters(py, params)?;
        self.client(py)?.notify(method, params);
        Ok(())
    }

    /// Subscribes to notifications from now on.
    fn notices(&self, py: Python<'_>) -> PyResult<Notices> {
        let client = self.client(py)?;
        let heard = NoticeReceiver {
            notices: client.notices(),
            connection: client.connection(),
        };
        let inner = Local::new(Arc::new(Turn::new(heard)));
        Ok(Notices { inner })
    }

    /// Opens an arm of the session.
    #[pyo3(signature = (arm, *, timeout, window, probe, reconnect, echo, fence = None))]
    // Each Python keyword is an argument.
    #[allow(clippy::too_many_arguments)]
    fn open(
        &self,
        py: Python<'_>,
        arm: Option<String>,
        timeout: f64,
        window: usize,
        probe: bool,
        reconnect: bool,
        echo: f64,
        fence: Option<&str>,
    ) -> PyResult<Call> {
        let options = options(py, timeout, window, probe, reconnect, echo)?;
        let options = with_fence(py, options, fence)?;
        let (client, ends) = (self.client(py)?, StationLines::default());
        let lines = Arc::clone(&ends);
        Core::connecting_by(py, open(client, arm, options, lines), ends)
    }

    /// Releases the leases and ends the session. If an arm of the session is open, the session ends
    /// with that arm.
    fn close(&self, py: Python<'_>) -> PyResult<Call> {
        let client = self.held(py)?.take();
        let leases = std::mem::take(&mut *locked(&self.leases));
        Ok(Call::lasting(async move {
            if let Some(client) = client {
                let giving_back = async {
                    for lease in &leases {
                        // Fails for a lease that has expired or a station that is gone; neither
                        // matters here.
                        let _ = client.release(lease).await;
                    }
                };
                let _ = tokio::time::timeout(CLOSE_TIMEOUT, giving_back).await;
                let mut connection = client.connection();
                drop(client);
                let over = async { while connection.changed().await.is_ok() {} };
                let _ = tokio::time::timeout(CLOSE_TIMEOUT, over).await;
            }
            Ok(())
        }))
    }

    /// True if it was created in this process, False in a forked child.
    fn is_here(&self) -> bool {
        self.client.here().is_some()
    }
}

#[pymethods]
impl Notices {
    /// Waits for the next notification. Returns its method and parameters in JSON, or `None` when
    /// the session has ended.
    fn next(&self, py: Python<'_>) -> PyResult<Call> {
        let inner = Arc::clone(self.inner.get(py)?);
        let next = async move { Ok::<_, Error>(inner.lock().await.next().await) };
        Ok(Call::start(next, |py, news: NextMessage| {
            news.into_py_any(py)
        }))
    }
}
