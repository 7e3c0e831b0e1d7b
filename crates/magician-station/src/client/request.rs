//! Single request by POST, without a session.

use http::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use http::{Request, StatusCode};
use http_body_util::BodyExt;
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use serde_json::{Value, json};
use tokio::time::timeout;

use super::task::{NO_ANSWER, OPEN_TIMEOUT, outcome, refused};
use super::trust::{self, Stream, Trust, no_station};
use super::{ClientError, StationAddress};

pub(super) async fn call(
    address: &StationAddress,
    token: Option<&str>,
    trust: &Trust,
    method: &str,
    params: &Value,
) -> Result<Value, ClientError> {
    let connector = address.encrypted.then(|| trust.connector()).transpose()?;
    let opened = timeout(OPEN_TIMEOUT, trust::open(address, connector.as_ref())).await;
    let stream = opened.unwrap_or_else(|_| Err(no_station(&address.host, NO_ANSWER)))?;
    let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    let host = &address.host;
    let (status, body) = exchange(stream, host, token, message.to_string()).await?;
    // Errors of JSON-RPC come with 200; other statuses are those of HTTP.
    if status != StatusCode::OK {
        return Err(refused(host, status, Some(&body)));
    }
    let answer: Value = serde_json::from_slice(&body).map_err(|_| ClientError::Lost)?;
    outcome(&answer)
}

/// Posts a request on an open connection and reads the whole answer.
pub(super) async fn exchange(
    stream: Box<dyn Stream>,
    host: &str,
    token: Option<&str>,
    text: String,
) -> Result<(StatusCode, Bytes), ClientError> {
    let handshake = http1::handshake(TokioIo::new(stream)).await;
    let (mut sender, connection) = handshake.map_err(|error| no_station(host, error))?;
    let mut request = Request::post("/api/v1/rpc")
        .header(HOST, host)
        .header(CONTENT_TYPE, "application/json");
    if let Some(token) = token {
        request = request.header(AUTHORIZATION, format!("Bearer {token}"));
    }
    let request = request.body(text);
    let request = request.map_err(|error| ClientError::Address(error.to_string()))?;
    let answer = async {
        let response = sender.send_request(request).await.map_err(lost)?;
        let status = response.status();
        let body = response.into_body().collect().await.map_err(lost)?;
        Ok((status, body.to_bytes()))
    };
    // The connection is driven here and dropped with the answer.
    tokio::select! {
        answer = answer => answer,
        Err(error) = connection => Err(lost(error)),
    }
}

fn lost(_: hyper::Error) -> ClientError {
    ClientError::Lost
}
