//! One end of a session with a station, whatever carries it: the equal of a WebSocket.

use std::fmt;
use std::time::Duration;

use magician_station::http::{TokenStore, UNCHECKED};
use magician_station::{Client, MESSAGE, Outgoing, Station};
use tokio::sync::mpsc;
use tokio::time::timeout;

/// Messages on their way, in each direction. What is more waits where it comes from; a state that waits there stays new.
pub const WINDOW: usize = 64;
/// Whoever takes nothing for so long is cut off.
const STUCK: Duration = Duration::from_secs(10);

/// What goes to a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToStation {
    /// A message of JSON-RPC; the first is `session.hello`, with the token.
    Text(String),
    /// A sign of life of whoever is behind this end, as the answer to a ping is one. A holder without a word for five seconds
    /// loses its lease: pass on every pong of a browser, and none where there was none.
    Alive,
}

/// What comes from a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FromStation {
    /// A message of JSON-RPC.
    Text(String),
    /// A state as bytes: [`StateFrame`](magician_station::StateFrame).
    Frame(Vec<u8>),
    /// The end, after which nothing comes.
    Closed(Closed),
}

/// Why a channel is at its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closed {
    /// As a WebSocket's: RFC 6455 and [`CloseCode`](magician_station::CloseCode).
    pub code: u16,
    /// For people; often empty.
    pub reason: String,
}

impl Closed {
    /// The other side is gone, or the line to it.
    pub const BROKEN: u16 = 1006;

    pub(crate) fn new(code: u16, reason: impl Into<String>) -> Self {
        Self {
            code,
            reason: reason.into(),
        }
    }

    /// Without a word from the station.
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

/// The client's end of a session with a station: with all of the station's arms, as a WebSocket to it has them. Dropping it is the
/// end of the session's socket, and the station does what it does then: a lease goes back, a jog stops, a job goes by its
/// `on_lost`.
#[derive(Debug)]
pub struct Channel {
    to_station: mpsc::Sender<ToStation>,
    from_station: mpsc::Receiver<FromStation>,
}

/// The station's end: a carrier moves what is in it, or [`carry`] does in the same process.
#[derive(Debug)]
pub struct StationEnd {
    /// What the client sends; at its end the client is gone.
    pub from_client: mpsc::Receiver<ToStation>,
    /// What it is to be sent; closed when the client is gone.
    pub to_client: mpsc::Sender<FromStation>,
}

/// The two ends of a channel.
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
    /// Sends; waits where [`WINDOW`] messages are on their way. Whether it went: not on a channel that is at its end.
    pub async fn send(&self, message: ToStation) -> bool {
        self.to_station.send(message).await.is_ok()
    }

    /// What comes next; waits for it. After the end comes the end again. Dropping the future loses nothing.
    pub async fn receive(&mut self) -> FromStation {
        let next = self.from_station.recv().await;
        next.unwrap_or_else(|| FromStation::Closed(Closed::broken()))
    }

    /// Its two directions, for two tasks. The channel ends when either is dropped.
    #[must_use]
    pub fn split(self) -> (mpsc::Sender<ToStation>, mpsc::Receiver<FromStation>) {
        (self.to_station, self.from_station)
    }
}

/// Carries messages between a client of a station in this process and the station's end of a channel, until one of the two ends.
/// The token of its hello is looked up in these tokens.
pub async fn carry(client: Client, tokens: TokenStore, mut end: StationEnd) {
    let to_client = end.to_client.clone();
    let reader = async {
        // A token is looked up once: a socket has one hello.
        let mut asked = false;
        loop {
            match end.from_client.recv().await {
                Some(ToStation::Text(text)) if text.len() > MESSAGE => {
                    return Some(Closed::new(1009, "a message is 1 MiB at most"));
                }
                Some(ToStation::Text(text)) => {
                    if !asked && let Some(token) = Station::token_of(&text) {
                        asked = true;
                        match tokens.granted(token).await {
                            Ok(grant) => client.vouch(grant),
                            Err(_) => return Some(Closed::new(1013, UNCHECKED)),
                        }
                    }
                    client.send(&text);
                }
                Some(ToStation::Alive) => client.pong(),
                None => return None,
            }
        }
    };
    let writer = async {
        loop {
            // What waits meanwhile stays in the station, where a newer state takes the place of an older one.
            let Ok(Ok(place)) = timeout(STUCK, to_client.reserve()).await else {
                return None;
            };
            let outgoing = tokio::select! {
                outgoing = client.receive() => outgoing,
                () = to_client.closed() => return None,
            };
            match outgoing {
                Outgoing::Text(text) => place.send(FromStation::Text(text)),
                Outgoing::Frame(bytes) => place.send(FromStation::Frame(bytes)),
                Outgoing::Close(code) => return Some(Closed::new(code.0, "")),
            }
        }
    };
    // What waits to be taken does not keep what comes from being heard: a stop above all.
    let last = tokio::select! {
        last = reader => last,
        last = writer => last,
    };
    // The station hears of the end now, not when the last message is taken.
    drop(client);
    if let Some(last) = last {
        let _ = timeout(STUCK, end.to_client.send(FromStation::Closed(last))).await;
    }
}
