//! A session with a station over any transport, the equivalent of a WebSocket.
//!
//! [`channel`] creates both ends. The client end is a [`Channel`]. The station end is moved over
//! the network by a transport, or connected to a station in this process by [`carry`]. Both
//! directions are bounded, so a slow peer blocks its sender instead of growing a queue.

use std::fmt;
use std::time::Duration;

use magician_station::http::{TOKENS_UNAVAILABLE, TokenStore};
use magician_station::{Client, MAX_MESSAGE_SIZE, Outgoing, Station};
use tokio::sync::mpsc;
use tokio::time::timeout;

/// Most messages in flight in each direction. Further messages wait at their source, where a newer
/// state still replaces an older one.
pub const WINDOW: usize = 64;
/// Time without an accepted message after which the session of a client is closed. A choice: long
/// enough for a stalled network and short enough to free the session of a hung client.
const MAX_SEND_WAIT: Duration = Duration::from_secs(10);

/// Message from the client to the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToStation {
    /// JSON-RPC message. The first one is `session.hello` with the token.
    Text(String),
    /// Keep-alive of the program behind this end, like the pong of a WebSocket. A holder that sends
    /// nothing for five seconds loses its lease, so a gateway must forward each pong of its client
    /// and must not make up any.
    KeepAlive,
}

/// Message from the station to the client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FromStation {
    /// JSON-RPC message.
    Text(String),
    /// Binary state, encoded as [`StateFrame`](magician_station::StateFrame).
    Frame(Vec<u8>),
    /// End of the session. No message follows.
    Closed(Closed),
}

/// Reason why a channel was closed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closed {
    /// Close code of a WebSocket: RFC 6455, or [`CloseCode`](magician_station::CloseCode).
    pub code: u16,
    /// Text for people. Often empty.
    pub reason: String,
}

impl Closed {
    /// Close code 1006: the peer or the connection to it disappeared without a close message.
    pub const BROKEN: u16 = 1006;

    pub(crate) fn new(code: u16, reason: impl Into<String>) -> Self {
        Self {
            code,
            reason: reason.into(),
        }
    }

    /// Returns the reason for a connection that broke without a close message.
    #[must_use]
    pub fn broken() -> Self {
        Self::new(Self::BROKEN, "the station cannot be reached any more")
    }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.reason.is_empty() {
            write!(f, "closed with {}", self.code)
        } else {
            write!(f, "{} ({})", self.reason, self.code)
        }
    }
}

/// Client end of a session with a station. It reaches all arms of that station, as a WebSocket
/// does.
///
/// Dropping it closes the session. The station then releases the leases, stops jogs and treats jobs
/// as their `on_lost` says.
#[derive(Debug)]
pub struct Channel {
    to_station: mpsc::Sender<ToStation>,
    from_station: mpsc::Receiver<FromStation>,
}

/// Station end of a channel. A transport moves its messages over the network; [`carry`] does so
/// within one process.
#[derive(Debug)]
pub struct StationEnd {
    /// Messages of the client. Ends when the client is gone.
    pub from_client: mpsc::Receiver<ToStation>,
    /// Messages to the client. Closed when the client is gone.
    pub to_client: mpsc::Sender<FromStation>,
}

/// Creates both ends of a channel.
#[must_use]
pub fn channel() -> (Channel, StationEnd) {
    let (to_station, from_client) = mpsc::channel(WINDOW);
    let (to_client, from_station) = mpsc::channel(WINDOW);
    let client = Channel {
        to_station,
        from_station,
    };
    let station = StationEnd {
        from_client,
        to_client,
    };
    (client, station)
}

impl Channel {
    /// Sends a message, waiting while [`WINDOW`] messages are in flight. Returns false if the
    /// channel is closed.
    pub async fn send(&self, message: ToStation) -> bool {
        self.to_station.send(message).await.is_ok()
    }

    /// Waits for the next message. After the end it returns [`FromStation::Closed`] again and
    /// again. Cancel safe: dropping the future loses no message.
    pub async fn receive(&mut self) -> FromStation {
        let next = self.from_station.recv().await;
        next.unwrap_or_else(|| FromStation::Closed(Closed::broken()))
    }

    /// Splits the channel into its two directions, for two tasks. Dropping either one closes the
    /// channel.
    #[must_use]
    pub fn split(self) -> (mpsc::Sender<ToStation>, mpsc::Receiver<FromStation>) {
        (self.to_station, self.from_station)
    }
}

/// Connects the station end of a channel to a client of a station in this process, until one of
/// them ends. The token in `session.hello` is checked against `tokens`.
pub async fn carry(client: Client, tokens: TokenStore, mut end: StationEnd) {
    let to_client = end.to_client.clone();
    let reader = async {
        // Only the first hello is checked: the station refuses a second one on a socket.
        let mut asked = false;
        loop {
            match end.from_client.recv().await {
                Some(ToStation::Text(text)) if text.len() > MAX_MESSAGE_SIZE => {
                    return Some(Closed::new(1009, "a message is 1 MiB at most"));
                }
                Some(ToStation::Text(text)) => {
                    if !asked && let Some(token) = Station::token_of(&text) {
                        asked = true;
                        match tokens.granted(token).await {
                            Ok(grant) => client.set_token_grant(grant),
                            Err(_) => return Some(Closed::new(1013, TOKENS_UNAVAILABLE)),
                        }
                    }
                    client.send(&text);
                }
                Some(ToStation::KeepAlive) => client.pong(),
                None => return None,
            }
        }
    };
    let writer = async {
        loop {
            // Reserve room first: until then the message stays in the station, where a newer state
            // still replaces an older one.
            let Ok(Ok(permit)) = timeout(MAX_SEND_WAIT, to_client.reserve()).await else {
                return None;
            };
            let outgoing = tokio::select! {
                outgoing = client.receive() => outgoing,
                () = to_client.closed() => return None,
            };
            match outgoing {
                Outgoing::Text(text) => permit.send(FromStation::Text(text)),
                Outgoing::Frame(bytes) => permit.send(FromStation::Frame(bytes)),
                Outgoing::Close(code) => return Some(Closed::new(code.0, "")),
            }
        }
    };
    // Reader and writer run side by side, so that a client that reads nothing can still send a
    // stop.
    let last = tokio::select! {
        last = reader => last,
        last = writer => last,
    };
    // Drop before the close message: the station must learn of the end at once, even if the peer
    // takes no message for `MAX_SEND_WAIT`.
    drop(client);
    if let Some(last) = last {
        let _ = timeout(MAX_SEND_WAIT, end.to_client.send(FromStation::Closed(last))).await;
    }
}
