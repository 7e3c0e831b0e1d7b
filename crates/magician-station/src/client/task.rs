//! Background task of a client: owns the connection and restores it.

use std::collections::BTreeMap;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use http::StatusCode;
use magician::EndNotice;
use serde_json::{Value, json};
use tokio::sync::{broadcast, mpsc, oneshot, watch};
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsConnector;
use tokio_tungstenite::client_async_with_config;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Error, Message};

use super::trust::{self, Stream, no_station};
use super::{ClientError, Connection, Notice, RawSocket, StationAddress};
use crate::READ_BUFFER;
use crate::api::RpcError;
use crate::frame::StateFrame;
use crate::station::CloseCode;

type Reply = oneshot::Sender<Result<Value, ClientError>>;

/// Time for opening a connection, including the hello.
pub(super) const OPEN_TIMEOUT: Duration = Duration::from_secs(5);
/// Reason in an error if the station does not answer within `OPEN_TIMEOUT`.
pub(super) const NO_ANSWER: &str = "it does not answer";
/// First and largest delay before reconnecting. The delay doubles with each failure.
const FIRST_RECONNECT_DELAY: Duration = Duration::from_millis(200);
const MAX_RECONNECT_DELAY: Duration = Duration::from_secs(5);
/// Error code of a hello when all sessions are in use.
const TOO_MANY: i64 = RpcError::TOO_MANY as i64;
/// Close code of a station that ends (RFC 6455, 7.4.1).
const GOING_AWAY: u16 = 1001;

/// Message to send. Without `reply` it is a notification.
#[derive(Debug)]
pub(super) struct Order {
    pub(super) method: String,
    pub(super) params: Value,
    pub(super) reply: Option<Reply>,
}

pub(super) struct Task {
    address: StationAddress,
    /// TLS connector, for encrypted connections.
    connector: Option<TlsConnector>,
    client: Value,
    token: Option<String>,
    /// Secret for resuming the session.
    resume: Option<String>,
    inbox: mpsc::UnboundedReceiver<Order>,
    notices: broadcast::Sender<Notice>,
    frames: broadcast::Sender<StateFrame>,
    connected: watch::Sender<Connection>,
    /// Set when the station announces its end, and cleared once the station is back.
    end_notice: EndNotice,
    waiting: BTreeMap<u64, Reply>,
    last_id: u64,
}

/// End of a connection.
enum End {
    Broken,
    /// Closed by the station, for good.
    Closed,
    /// All clones of the client are gone.
    ClientGone,
}

impl Task {
    pub(super) fn new(
        (address, connector): (StationAddress, Option<TlsConnector>),
        client: Value,
        token: Option<&str>,
        inbox: mpsc::UnboundedReceiver<Order>,
        (notices, frames): (broadcast::Sender<Notice>, broadcast::Sender<StateFrame>),
        (connected, end_notice): (watch::Sender<Connection>, EndNotice),
    ) -> Self {
        Self {
            address,
            connector,
            client,
            token: token.map(str::to_owned),
            resume: None,
            inbox,
            notices,
            frames,
            connected,
            end_notice,
            waiting: BTreeMap::new(),
            last_id: 0,
        }
    }

    /// Opens a connection and says hello. Returns the answer.
    pub(super) async fn greet(mut self) -> Result<(Self, RawSocket, Value), ClientError> {
        let (socket, hello) = self.open().await?;
        Ok((self, socket, hello))
    }

    async fn open(&mut self) -> Result<(RawSocket, Value), ClientError> {
        let (host, address) = (&self.address.host, &self.address);
        let unreachable = |error: Error| no_station(host, error);
        let opening = async {
            let stream = trust::open(address, self.connector.as_ref()).await?;
            let scheme = match self.connector {
                Some(_) => "wss",
                None => "ws",
            };
            let mut socket = upgrade(stream, scheme, host).await?;
            // The token is sent in the hello and not in the address, which may be logged.
            let mut params = json!({"client": self.client});
            for (name, value) in [("token", &self.token), ("resume", &self.resume)] {
                if let Some(value) = value {
                    params[name] = json!(value);
                }
            }
            let hello = message(Some(0), "session.hello", &params);
            socket.send(hello).await.map_err(unreachable)?;
            loop {
                match socket.next().await {
                    Some(Ok(Message::Text(text))) => {
                        let answer: Value = serde_json::from_str(&text).unwrap_or_default();
                        // Notifications may arrive before the answer.
                        if answer.get("id") == Some(&json!(0)) {
                            let hello = outcome(&answer).map_err(|error| match error {
                                ClientError::Refused { code, message, .. } if code == TOO_MANY => {
                                    busy(host, &message)
                                }
                                error => error,
                            })?;
                            return Ok((socket, hello));
                        }
                    }
                    Some(Ok(Message::Close(Some(end))))
                        if u16::from(end.code) == CloseCode::FULL.0 =>
                    {
                        return Err(busy(host, &end.reason));
                    }
                    Some(Ok(_)) => {}
                    // Closed or broken before the answer.
                    _ => return Err(no_station(host, "it hung up")),
                }
            }
        };
        let opened = timeout(OPEN_TIMEOUT, opening).await;
        let (socket, hello) = opened.unwrap_or_else(|_| Err(no_station(host, NO_ANSWER)))?;
        // Each hello gives a new secret.
        self.resume = hello["resume"].as_str().map(str::to_owned);
        Ok((socket, hello))
    }

    /// Carries messages until the client is dropped or the station closes the session for good.
    pub(super) async fn run(mut self, mut socket: RawSocket) {
        loop {
            let end = self.exchange(&mut socket).await;
            drop(socket);
            for (_, reply) in std::mem::take(&mut self.waiting) {
                // Some callers no longer wait.
                let _ = reply.send(Err(self.loss_error()));
            }
            match end {
                End::Broken => {}
                End::Closed => {
                    self.connected.send_replace(Connection::Closed);
                    return;
                }
                End::ClientGone => return,
            }
            // Broken: reconnect and resume.
            self.connected.send_replace(Connection::Lost);
            let Some(again) = self.reconnect().await else {
                return;
            };
            self.connected.send_replace(Connection::Up);
            socket = again;
        }
    }

    async fn reconnect(&mut self) -> Option<RawSocket> {
        let mut delay = FIRST_RECONNECT_DELAY;
        loop {
            let timer = sleep(delay);
            tokio::pin!(timer);
            loop {
                tokio::select! {
                    () = &mut timer => break,
                    order = self.inbox.recv() => match order {
                        // Refused and not queued: by the time of the reconnect the command may be
                        // dangerous.
                        Some(order) => self.refuse(order),
                        None => return None,
                    },
                }
            }
            match self.open().await {
                Ok((socket, _)) => {
                    self.end_notice.set(false);
                    return Some(socket);
                }
                // Retrying does not lift a refusal.
                Err(ClientError::Refused { .. } | ClientError::Untrusted(_)) => {
                    self.connected.send_replace(Connection::Closed);
                    return None;
                }
                Err(_) => delay = (delay * 2).min(MAX_RECONNECT_DELAY),
            }
        }
    }

    async fn exchange(&mut self, socket: &mut RawSocket) -> End {
        loop {
            tokio::select! {
                order = self.inbox.recv() => {
                    let Some(order) = order else {
                        // Bounded, so that a stuck connection does not keep the task alive.
                        let _ = timeout(FIRST_RECONNECT_DELAY, socket.close(None)).await;
                        return End::ClientGone;
                    };
                    let id = order.reply.map(|reply| {
                        self.last_id += 1;
                        self.waiting.insert(self.last_id, reply);
                        self.last_id
                    });
                    if socket.send(message(id, &order.method, &order.params)).await.is_err() {
                        return End::Broken;
                    }
                }
                received = socket.next() => match received {
                    Some(Ok(Message::Text(text))) => self.handle_text(&text),
                    Some(Ok(Message::Binary(bytes))) => self.handle_frame(&bytes),
                    Some(Ok(Message::Close(frame))) => {
                        let code = frame.map_or(0, |frame| u16::from(frame.code));
                        // A station that ends comes back later. Codes for a client that was too
                        // slow or sent too much allow reconnecting; codes of a refusal do not.
                        if code == GOING_AWAY {
                            self.end_notice.set(true);
                        }
                        // Bad hello, no token, token revoked, session taken over.
                        let is_final = [4400, 4401, 4403, 4409].contains(&code);
                        return if is_final { End::Closed } else { End::Broken };
                    }
                    Some(Ok(_)) => {}
                    Some(Err(_)) | None => return End::Broken,
                },
            }
        }
    }

    /// Returns the error for requests without an answer.
    fn loss_error(&self) -> ClientError {
        if self.end_notice.is_given() {
            ClientError::Ended
        } else {
            ClientError::Lost
        }
    }

    fn refuse(&self, order: Order) {
        if let Some(reply) = order.reply {
            let _ = reply.send(Err(self.loss_error()));
        }
    }

    fn handle_frame(&self, bytes: &[u8]) {
        if let Ok(frame) = StateFrame::read(bytes) {
            // Fails if there are no readers.
            let _ = self.frames.send(frame);
        }
    }

    fn handle_text(&mut self, text: &str) {
        let Ok(message) = serde_json::from_str::<Value>(text) else {
            return;
        };
        if let Some(method) = message["method"].as_str() {
            if method == "server.ending" {
                self.end_notice.set(true);
            }
            let notice = Notice {
                method: method.to_owned(),
                params: message["params"].clone(),
            };
            // Fails if there are no readers.
            let _ = self.notices.send(notice);
        } else if let Some(reply) = message["id"]
            .as_u64()
            .and_then(|id| self.waiting.remove(&id))
        {
            let _ = reply.send(outcome(&message));
        }
    }
}

fn message(id: Option<u64>, method: &str, params: &Value) -> Message {
    let mut message = json!({"jsonrpc": "2.0", "method": method, "params": params});
    if let Some(id) = id {
        message["id"] = json!(id);
    }
    Message::text(message.to_string())
}

/// Upgrades a connection to a WebSocket.
pub(super) async fn upgrade(
    stream: Box<dyn Stream>,
    scheme: &str,
    host: &str,
) -> Result<RawSocket, ClientError> {
    let unreachable = |error: Error| no_station(host, error);
    let request = format!("{scheme}://{host}/api/v1/ws").into_client_request();
    let config = WebSocketConfig::default().read_buffer_size(READ_BUFFER);
    let request = request.map_err(unreachable)?;
    let opened = client_async_with_config(request, stream, Some(config)).await;
    let (socket, _) = opened.map_err(|error| match error {
        Error::Http(response) => refused(host, response.status(), response.body().as_deref()),
        error => unreachable(error),
    })?;
    Ok(socket)
}

/// Returns the error for an HTTP status other than success, with the station's explanation.
pub(super) fn refused(at: &str, status: StatusCode, body: Option<&[u8]>) -> ClientError {
    let body = body.map(String::from_utf8_lossy).unwrap_or_default();
    let why = match body.trim() {
        "" => status.to_string(),
        why => why.to_owned(),
    };
    match status {
        StatusCode::SERVICE_UNAVAILABLE => busy(at, &why),
        // No station serves this address, or it does not know the path.
        _ => no_station(at, why),
    }
}

fn busy(at: &str, why: &str) -> ClientError {
    ClientError::Busy(format!("the station at {at} serves nobody more now: {why}"))
}

/// Returns the result of an answer.
pub(super) fn outcome(answer: &Value) -> Result<Value, ClientError> {
    match answer.get("error") {
        None => Ok(answer["result"].clone()),
        Some(error) => Err(ClientError::Refused {
            code: error["code"].as_i64().unwrap_or_default(),
            message: error["message"].as_str().unwrap_or_default().to_owned(),
            data: error["data"].clone(),
        }),
    }
}
