//! Client of a station: requests, notifications and frames over a WebSocket that reconnects, and a
//! line to an arm through it.
//!
//! A background task owns the socket. When the connection breaks it reconnects with increasing
//! delays and resumes the session, which keeps its lease if it is back in time. A request whose
//! answer was lost is never sent again, because it may have moved the arm.

mod address;
mod dial;
mod homings;
mod line;
mod request;
mod task;
mod trust;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician::EndNotice;
use serde_json::{Value, json};
use tokio::sync::{broadcast, mpsc, oneshot, watch};

pub use self::address::StationAddress;
pub use self::dial::StationDial;
pub use self::homings::StationHomings;
pub use self::line::{LineEnd, LineLease, StationLine};
use self::task::{Order, Task};
pub use self::trust::{Stream, Trust};
use crate::frame::StateFrame;

/// WebSocket of a station without a hello, for callers that send it themselves.
pub type RawSocket = tokio_tungstenite::WebSocketStream<Box<dyn Stream>>;

/// Capacity of the channels of notifications and frames. A slower reader loses the oldest.
const CHANNEL_CAPACITY: usize = 256;

/// Reason why a request has no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ClientError {
    /// The address is not that of a station.
    Address(String),
    /// No station answers at the address, or it does not admit this client.
    Unreachable(String),
    /// All places of the station are in use. It still carries out a stop by
    /// [`StationClient::call_once`].
    Busy(String),
    /// The station's certificate is not trusted.
    Untrusted(String),
    /// The connection broke before the answer. Whether the request was carried out is unknown; it
    /// is not sent again.
    Lost,
    /// The station has ended after announcing it (`server.ending`), and has stopped all motion.
    Ended,
    /// The station refused the request.
    Refused {
        /// Error code.
        code: i64,
        /// Reason, as a sentence.
        message: String,
        /// Details.
        data: Value,
    },
}

impl ClientError {
    /// Returns the name of the lease's holder and the time until the lease is free, if the holder's
    /// connection has ended. `None` for other errors.
    #[must_use]
    pub fn free_soon(&self) -> Option<(&str, Duration)> {
        let Self::Refused { data, .. } = self else {
            return None;
        };
        let free = Duration::try_from_secs_f64(data.get("free_in_s")?.as_f64()?).ok()?;
        Some((data["holder"]["name"].as_str().unwrap_or_default(), free))
    }

    /// Returns the kind of a refusal: `lease`, `forbidden`, `unreachable`, .. `None` for other
    /// errors.
    #[must_use]
    pub fn kind(&self) -> Option<&str> {
        match self {
            Self::Refused { data, .. } => data.get("kind")?.as_str(),
            _ => None,
        }
    }
}

impl fmt::Display for ClientError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address(why)
            | Self::Unreachable(why)
            | Self::Busy(why)
            | Self::Untrusted(why) => f.write_str(why),
            Self::Lost => f.write_str("the connection to the station broke before its answer"),
            Self::Ended => f.write_str("the station has ended"),
            Self::Refused { message, .. } => f.write_str(message),
        }
    }
}

impl std::error::Error for ClientError {}

/// Notification of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// Method: `arm.state`, `lease.changed`, ..
    pub method: String,
    /// Parameters.
    pub params: Value,
}

/// State of a client's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Connection {
    /// Connected.
    Up,
    /// Broken. Reconnecting after 0.2 s, then with doubled delays up to 5 s.
    Lost,
    /// Ended by the station for good: the token was revoked, or the session has another connection.
    Closed,
}

/// Session at a station. Clones share the session; it ends with the last one.
///
/// A broken connection is made again, and the session resumed with its lease if the station still
/// has it. Requests whose answer was lost are not sent again.
///
/// ```no_run
/// use magician_station::client::StationClient;
/// use serde_json::json;
///
/// # async fn example() -> Result<(), Box<dyn std::error::Error>> {
/// let station = StationClient::connect("http://127.0.0.1:8910", "my program", None).await?;
/// station.call("lease.acquire", json!({})).await?;
/// let state = station.call("arm.move", json!({"to": [220, 0, 50, 0]})).await?;
/// println!("{}", state["x"]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct StationClient {
    orders: mpsc::UnboundedSender<Order>,
    notices: broadcast::Sender<Notice>,
    frames: broadcast::Sender<StateFrame>,
    connection: watch::Receiver<Connection>,
    end_notice: EndNotice,
    /// Answer to the first hello.
    hello: Arc<Value>,
    /// Number of users of each lease in this session.
    leases: Arc<Mutex<BTreeMap<String, usize>>>,
}

impl StationClient {
    /// Connects to `http://HOST:PORT` or `https://HOST:PORT` under a name shown to others, with a
    /// token if one is needed.
    ///
    /// # Errors
    /// [`ClientError::Address`], [`ClientError::Unreachable`], [`ClientError::Untrusted`] if the
    /// system does not trust the certificate, [`ClientError::Refused`] if the token is invalid.
    pub async fn connect(
        address: &str,
        name: &str,
        token: Option<&str>,
    ) -> Result<Self, ClientError> {
        Self::connect_trusting(address, name, token, &Trust::System).await
    }

    /// Connects as [`connect`](Self::connect) does, with a choice of trusted certificates.
    ///
    /// # Errors
    /// The same as [`connect`](Self::connect).
    pub async fn connect_trusting(
        address: &str,
        name: &str,
        token: Option<&str>,
        trust: &Trust,
    ) -> Result<Self, ClientError> {
        let address: StationAddress = address.parse().map_err(ClientError::Address)?;
        let connector = address.encrypted.then(|| trust.connector()).transpose()?;
        let (orders, inbox) = mpsc::unbounded_channel();
        let (notices, _) = broadcast::channel(CHANNEL_CAPACITY);
        let (frames, _) = broadcast::channel(CHANNEL_CAPACITY);
        let (connected, connection) = watch::channel(Connection::Up);
        let end_notice = EndNotice::default();
        let client = json!({"name": name});
        let task = Task::new(
            (address, connector),
            client,
            token,
            inbox,
            (notices.clone(), frames.clone()),
            (connected, end_notice.clone()),
        );
        // Greeted before the task starts, so that a refusal is the caller's error.
        let (task, socket, hello) = task.greet().await?;
        // Ends with the last clone, which closes the connection.
        tokio::spawn(task.run(socket));
        Ok(Self {
            orders,
            notices,
            frames,
            connection,
            end_notice,
            hello: Arc::new(hello),
            leases: Arc::default(),
        })
    }

    /// Calls a method in a single request without a session. A stop is carried out even if all
    /// sessions are in use. A method that needs the lease acquires it for the call, if it is free.
    ///
    /// # Errors
    /// The same as [`connect`](Self::connect); [`ClientError::Busy`] if the station is full and the
    /// method is not a stop; [`ClientError::Lost`] if the connection breaks before the answer.
    pub async fn call_once(
        address: &str,
        token: Option<&str>,
        trust: &Trust,
        method: &str,
        params: Value,
    ) -> Result<Value, ClientError> {
        let address: StationAddress = address.parse().map_err(ClientError::Address)?;
        request::call(&address, token, trust, method, &params).await
    }

    /// Returns the answer to the first hello: `session`, `role`, `arms`, `version`.
    #[must_use]
    pub fn hello(&self) -> &Value {
        &self.hello
    }

    /// Calls a method and waits for its answer.
    ///
    /// # Errors
    /// [`ClientError::Refused`], or [`ClientError::Lost`] if the connection breaks or does not
    /// exist.
    pub async fn call(&self, method: &str, params: Value) -> Result<Value, ClientError> {
        let (reply, answer) = oneshot::channel();
        let order = Order {
            method: method.to_owned(),
            params,
            reply: Some(reply),
        };
        self.orders.send(order).map_err(|_| ClientError::Lost)?;
        answer.await.unwrap_or(Err(ClientError::Lost))
    }

    /// Acquires a lease by `lease.acquire`, `lease.ask` or `lease.take`, and returns its answer.
    ///
    /// All users in this session share the lease, including a [`StationLine`]: the last
    /// [`release`](Self::release) gives it back.
    ///
    /// # Errors
    /// The same as [`call`](Self::call).
    pub async fn lease(&self, method: &str, params: Value) -> Result<Value, ClientError> {
        let granted = self.call(method, params).await?;
        if let Some(lease) = granted["lease"].as_str() {
            let mut leases = self.leases.lock().unwrap_or_else(PoisonError::into_inner);
            *leases.entry(lease.to_owned()).or_default() += 1;
        }
        Ok(granted)
    }

    /// Releases a lease for one of its users.
    ///
    /// # Errors
    /// The same as [`call`](Self::call).
    pub async fn release(&self, lease: &str) -> Result<(), ClientError> {
        let last = {
            let mut leases = self.leases.lock().unwrap_or_else(PoisonError::into_inner);
            // A lease that was not counted is released at once.
            let left = leases.remove(lease).unwrap_or_default().saturating_sub(1);
            if left > 0 {
                leases.insert(lease.to_owned(), left);
            }
            left == 0
        };
        if last {
            self.call("lease.release", json!({"lease": lease})).await?;
        }
        Ok(())
    }

    /// Returns true if the station says that an arm, or the only one, is a virtual arm of its
    /// process.
    ///
    /// # Errors
    /// The same as [`call`](Self::call).
    pub async fn is_virtual(&self, arm: Option<&str>) -> Result<bool, ClientError> {
        let list = self.call("arm.list", json!({})).await?;
        let mut arms = list["arms"].as_array().into_iter().flatten();
        // Without a name the first one, which is the only one: with several the station asks for a
        // name.
        let named = arms.find(|entry| arm.is_none_or(|arm| entry["name"] == arm));
        Ok(named.is_some_and(|entry| entry["virtual"] == true))
    }

    /// Sends a notification, such as `jog.keep` or a stop without waiting. Dropped without a
    /// connection.
    pub fn notify(&self, method: &str, params: Value) {
        let order = Order {
            method: method.to_owned(),
            params,
            reply: None,
        };
        // Fails only if the task has ended, which it does with this session.
        let _ = self.orders.send(order);
    }

    /// Subscribes to notifications from now on. A reader that falls behind by more than 256 loses
    /// the oldest.
    #[must_use]
    pub fn notices(&self) -> broadcast::Receiver<Notice> {
        self.notices.subscribe()
    }

    /// Subscribes to binary frames of this session's subscriptions from now on. A reader that falls
    /// behind by more than 256 loses the oldest.
    #[must_use]
    pub fn frames(&self) -> broadcast::Receiver<StateFrame> {
        self.frames.subscribe()
    }

    /// Returns the notice that the station is about to end or has ended, for
    /// [`Options::end_notice`](magician::Options::end_notice) of a driver behind a [`StationLine`].
    ///
    /// Its jobs then stop within the few seconds that the station waits. Withdrawn when the station
    /// is back.
    #[must_use]
    pub fn end_notice(&self) -> EndNotice {
        self.end_notice.clone()
    }

    /// Returns the state of the connection, as a watch.
    #[must_use]
    pub fn connection(&self) -> watch::Receiver<Connection> {
        self.connection.clone()
    }
}
