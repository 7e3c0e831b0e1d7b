//! WebSocket of a client: carries messages between the socket and the station.
//!
//! Reading and writing are separate futures in one task. Otherwise a client that does not read
//! would block its own stop: a blocked write must not block reading.

use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, timeout};

use super::listen::wait_for_end;
use super::options::KeepAliveSource;
use super::pacing::{Lane, Pacer};
use super::server::ApiClient;
use super::tokens::{TOKENS_UNAVAILABLE, TokenStore};
use crate::station::{CloseCode, MAX_MESSAGE_SIZE, Outgoing, Station};

/// Interval of pings. A reply keeps the lease alive, and within the lease timeout of 5 s one may be
/// lost.
const PING_INTERVAL: Duration = Duration::from_secs(2);
/// Longest time that one message may take to be written.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);
/// Time for the close frame.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// Carries messages until client or station ends.
pub(super) async fn carry(
    socket: WebSocket,
    client: impl ApiClient,
    (tokens, loopback): (TokenStore, bool),
    keep_alives: KeepAliveSource,
    mut over: watch::Receiver<bool>,
    pacer: Pacer,
) {
    let (mut sink, mut stream) = socket.split();
    let reader = async {
        // The token is looked up once: a socket has only one hello, and the file may be slow.
        let mut token_checked = false;
        let mut heard = false;
        loop {
            let message = stream.next().await;
            let lane = match &message {
                Some(Ok(Message::Text(text))) => Lane::of(text),
                _ => Lane::Ordinary,
            };
            pacer.turn(lane).await;
            match message {
                Some(Ok(Message::Text(text))) if text.len() > MAX_MESSAGE_SIZE => {
                    return Some(too_large());
                }
                Some(Ok(Message::Text(text))) => {
                    if !std::mem::replace(&mut heard, true) {
                        client.note_message();
                    }
                    if !token_checked && let Some(token) = Station::token_of(&text) {
                        token_checked = true;
                        match tokens.granted_at(token, loopback).await {
                            Ok(grant) => client.set_token_grant(grant),
                            Err(_) => return Some(close(1013, TOKENS_UNAVAILABLE)),
                        }
                    }
                    client.send(&text);
                    // A socket without a hello gets its own turns too, but the station soon closes
                    // it.
                    pacer.begin_session();
                }
                Some(Ok(Message::Pong(_))) => client.pong(),
                // The library answers pings itself.
                Some(Ok(Message::Ping(_))) => {}
                // 1003: unsupported data (RFC 6455, 7.4.1).
                Some(Ok(Message::Binary(_))) => return Some(close(1003, "messages are text")),
                Some(Err(error)) => return broken(&error),
                Some(Ok(Message::Close(_))) | None => return None,
            }
        }
    };
    let writer = async {
        let mut pings = interval(PING_INTERVAL);
        // After a pause of the machine one ping suffices.
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let message = tokio::select! {
                // The end of the station first; then messages before pings.
                biased;
                () = wait_for_end(&mut over) => return Some(close(1001, "the station ends")),
                outgoing = client.receive() => match outgoing {
                    Outgoing::Text(text) => Message::Text(text.into()),
                    Outgoing::Frame(bytes) => Message::Binary(bytes.into()),
                    Outgoing::Close(code) => return Some(close(code.0, "")),
                },
                _ = pings.tick(), if keep_alives == KeepAliveSource::Pings => Message::Ping(Vec::new().into()),
            };
            // Only one message is in flight. The rest waits in the station, where newer states
            // replace older ones.
            match timeout(WRITE_TIMEOUT, sink.send(message)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return None,
            }
        }
    };
    // Side by side: a message that is being written must not delay a stop that arrives.
    let last = tokio::select! {
        last = reader => last,
        last = writer => last,
    };
    // Dropped before the farewell: the station must learn of the end now.
    drop(client);
    if let Some(last) = last {
        let _ = timeout(CLOSE_TIMEOUT, sink.send(last)).await;
    }
}

/// Accepts and closes a socket for which the station has no place.
pub(super) async fn reject(mut socket: WebSocket) {
    let last = close(CloseCode::FULL.0, "the station has all its sessions");
    let _ = timeout(CLOSE_TIMEOUT, socket.send(last)).await;
}

fn too_large() -> Message {
    close(1009, "a message is 1 MiB at most")
}

fn close(code: u16, reason: &'static str) -> Message {
    Message::Close(Some(CloseFrame {
        code,
        reason: reason.into(),
    }))
}

/// Returns the close frame for a message that cannot be read. `None` if the connection itself
/// failed.
fn broken(error: &axum::Error) -> Option<Message> {
    use tokio_tungstenite::tungstenite::Error;
    let source = std::error::Error::source(error)?;
    match source.downcast_ref::<Error>()? {
        Error::Capacity(_) => Some(too_large()),
        Error::Utf8(_) => Some(close(1007, "the message is no UTF-8")),
        Error::Protocol(_) => Some(close(1002, "no WebSocket")),
        // The transport failed: no close frame can be sent.
        _ => None,
    }
}
