//! Sessions over the network: a [`Channel`] over the WebSocket of a station whose certificate was
//! checked.

use futures_util::{SinkExt, StreamExt};
use magician_station::client::{ClientError, RawSocket};
use tokio_tungstenite::tungstenite::{Bytes, Message};

use crate::channel::{Channel, Closed, FromStation, StationEnd, ToStation, channel};
use crate::site::SiteError;

/// Converts an error of dialling. Errors after the request was sent become `NoAnswer`, because the
/// station may have carried it out.
pub(super) fn failed(error: ClientError) -> SiteError {
    match error {
        ClientError::Untrusted(why) | ClientError::Address(why) => SiteError::Unproved(why),
        ClientError::Busy(why) => SiteError::Refused(why),
        ClientError::Unreachable(why) => SiteError::Network(why),
        _ => SiteError::NoAnswer,
    }
}

/// Creates a session over a fresh socket. `gone` completes when the station has left the site: TCP
/// alone takes minutes to notice a cut cable.
pub(super) fn session(
    socket: RawSocket,
    gone: impl Future<Output = ()> + Send + 'static,
) -> Channel {
    let (client, end) = channel();
    tokio::spawn(async move {
        let to_client = end.to_client.clone();
        let closed = tokio::select! {
            closed = carry(socket, end) => closed,
            () = gone => Some(Closed::broken()),
        };
        if let Some(closed) = closed {
            let _ = to_client.send(FromStation::Closed(closed)).await;
        }
    });
    client
}

/// Moves messages until one side ends. Returns the reason if the station ended first.
async fn carry(socket: RawSocket, mut end: StationEnd) -> Option<Closed> {
    let (mut sink, mut stream) = socket.split();
    let writer = async {
        while let Some(message) = end.from_client.recv().await {
            let message = match message {
                ToStation::Text(text) => Message::text(text),
                ToStation::KeepAlive => Message::Pong(Bytes::new()),
            };
            if sink.send(message).await.is_err() {
                return Some(Closed::broken());
            }
        }
        let _ = sink.close().await;
        None
    };
    let reader = async {
        loop {
            let message = match stream.next().await {
                Some(Ok(Message::Text(text))) => FromStation::Text(text.as_str().to_owned()),
                Some(Ok(Message::Binary(bytes))) => FromStation::Frame(bytes.to_vec()),
                Some(Ok(Message::Close(Some(frame)))) => {
                    return Some(Closed::new(frame.code.into(), frame.reason.as_str()));
                }
                // The library answers pings itself.
                Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_))) => continue,
                Some(Ok(Message::Close(None)) | Err(_)) | None => return Some(Closed::broken()),
            };
            if end.to_client.send(message).await.is_err() {
                return None;
            }
        }
    };
    tokio::select! {
        closed = writer => closed,
        closed = reader => closed,
    }
}
