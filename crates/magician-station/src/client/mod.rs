//! A client of a station: requests and notifications over a WebSocket that comes back, and a line to an arm through it.

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

/// A WebSocket of a station, for those who say hello themselves.
pub type RawSocket = tokio_tungstenite::WebSocketStream<Box<dyn Stream>>;

/// Notifications that are kept for a slow reader.
const KEPT: usize = 256;

/// Why a request has no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ClientError {
    /// The address is no station's.
    Address(String),
    /// There is no station at the address, or it does not let this client in.
    Unreachable(String),
    /// The station serves nobody more now. A stop by [`StationClient::call_once`] is carried out all the same.
    Busy(String),
    /// Its certificate is not trusted.
    Untrusted(String),
    /// The connection broke before the answer came: whether it was done is not known. It is not sent again.
    Lost,
    /// The station has ended, as it had announced (`server.ending`): it has stopped what moved.
    Ended,
    /// The station refuses it.
    Refused {
        /// The code.
        code: i64,
        /// Why, in a sentence.
        message: String,
        /// What it is about.
        data: Value,
    },
}

impl ClientError {
    /// Name of the holder of a lease that was refused and will be free soon, and the time until then,
    /// if the holder's connection has ended and it does not come back.
    #[must_use]
    pub fn free_soon(&self) -> Option<(&str, Duration)> {
        let Self::Refused { data, .. } = self else {
            return None;
        };
        let free = Duration::try_from_secs_f64(data.get("free_in_s")?.as_f64()?).ok()?;
        Some((data["holder"]["name"].as_str().unwrap_or_default(), free))
    }

    /// The kind of a refusal: `lease`, `forbidden`, `unreachable`, ..
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

/// A notification of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// Its method: `arm.state`, `lease.changed`, ..
    pub method: String,
    /// What it tells.
    pub params: Value,
}

/// Whether a client is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Connection {
    /// It is.
    Up,
    /// It broke, and is tried again: after 0.2 s, then less and less often, every 5 s at last.
    Lost,
    /// The station has ended it for good: its token was revoked, or its session has another connection.
    Closed,
}

/// A session at a station. Clones are of the same session; with the last one it ends.
///
/// A connection that breaks is made again, and the session with its lease is resumed if the station still has it. Requests
/// whose answer was lost are not sent again.
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
    /// What the first hello was answered with.
    hello: Arc<Value>,
    /// How many have each lease of the session.
    leases: Arc<Mutex<BTreeMap<String, usize>>>,
}

impl StationClient {
    /// Connects to `http://HOST:PORT` or `https://HOST:PORT`, under a name that others see, with a token where one is needed.
    ///
    /// # Errors
    /// [`ClientError::Address`], [`ClientError::Unreachable`], [`ClientError::Untrusted`] for a certificate that is not of the
    /// system's, and [`ClientError::Refused`] for a token that is not good.
    pub async fn connect(
        address: &str,
        name: &str,
        token: Option<&str>,
    ) -> Result<Self, ClientError> {
        Self::connect_trusting(address, name, token, &Trust::System).await
    }

    /// As [`connect`](Self::connect), with a say in whose certificates are trusted.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn connect_trusting(
        address: &str,
        name: &str,
        token: Option<&str>,
        trust: &Trust,
    ) -> Result<Self, ClientError> {
        let address: StationAddress = address.parse().map_err(ClientError::Address)?;
        let connector = address.encrypted.then(|| trust.connector()).transpose()?;
        let (orders, inbox) = mpsc::unbounded_channel();
        let (notices, _) = broadcast::channel(KEPT);
        let (frames, _) = broadcast::channel(KEPT);
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
        let (task, socket, hello) = task.greet().await?;
        // It ends with the last clone, and closes the connection then.
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

    /// Calls a method by one request of its own, without a session: a stop is carried out even while the station has as many
    /// sessions as it takes. What needs the lease has it for the call, if it is free.
    ///
    /// # Errors
    /// As [`connect`](Self::connect), [`ClientError::Busy`] if it is no stop and the station has as many requests as it takes,
    /// and [`ClientError::Lost`] if the connection breaks before the answer.
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

    /// What the station said at first: `session`, `role`, `arms`, `version`.
    #[must_use]
    pub fn hello(&self) -> &Value {
        &self.hello
    }

    /// Calls a method, and waits for its answer.
    ///
    /// # Errors
    /// [`ClientError::Refused`], and [`ClientError::Lost`] when the connection breaks meanwhile, or is not there.
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

    /// Gets a lease by `lease.acquire`, `lease.ask` or `lease.take`; the answer is theirs. All that have it in this session
    /// share it, a [`StationLine`] among them: the last [`release`](Self::release) gives it back.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    pub async fn lease(&self, method: &str, params: Value) -> Result<Value, ClientError> {
        let granted = self.call(method, params).await?;
        if let Some(lease) = granted["lease"].as_str() {
            let mut leases = self.leases.lock().unwrap_or_else(PoisonError::into_inner);
            *leases.entry(lease.to_owned()).or_default() += 1;
        }
        Ok(granted)
    }

    /// Gives a lease back, as far as this one of its holders goes.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    pub async fn release(&self, lease: &str) -> Result<(), ClientError> {
        let last = {
            let mut leases = self.leases.lock().unwrap_or_else(PoisonError::into_inner);
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

    /// Whether an arm, or the only one, is a virtual arm of the station's own, as the station says.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    pub async fn is_virtual(&self, arm: Option<&str>) -> Result<bool, ClientError> {
        let list = self.call("arm.list", json!({})).await?;
        let mut arms = list["arms"].as_array().into_iter().flatten();
        let named = arms.find(|entry| arm.is_none_or(|arm| entry["name"] == arm));
        Ok(named.is_some_and(|entry| entry["virtual"] == true))
    }

    /// Sends a notification: `jog.keep`, or a stop that waits for nothing. Without a connection it is dropped.
    pub fn notify(&self, method: &str, params: Value) {
        let order = Order {
            method: method.to_owned(),
            params,
            reply: None,
        };
        // Its task ends with it.
        let _ = self.orders.send(order);
    }

    /// The notifications from now on. A reader may fall 256 behind; then it misses the oldest.
    #[must_use]
    pub fn notices(&self) -> broadcast::Receiver<Notice> {
        self.notices.subscribe()
    }

    /// The frames of its subscriptions with `frame: "binary"` from now on. A reader may fall 256 behind; then it misses the oldest.
    #[must_use]
    pub fn frames(&self) -> broadcast::Receiver<StateFrame> {
        self.frames.subscribe()
    }

    /// Notice that the station is about to end, or has ended, for
    /// [`Options::end_notice`](magician::Options::end_notice) of a driver behind a [`StationLine`]:
    /// its jobs then stop in the few seconds that the station waits. It is taken back when the
    /// station is there again.
    #[must_use]
    pub fn end_notice(&self) -> EndNotice {
        self.end_notice.clone()
    }

    /// Whether it is connected, and news of that.
    #[must_use]
    pub fn connection(&self) -> watch::Receiver<Connection> {
        self.connection.clone()
    }
}
