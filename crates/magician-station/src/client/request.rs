//! One request by POST, without a session.

use http::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use http::{Request, StatusCode};
use http_body_util::BodyExt;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use serde_json::{Value, json};
use tokio::time::timeout;

use super::task::{OPENING, SILENT, outcome, refused};
use super::trust::{self, Trust, no_station};
use super::{ClientError, StationAddress};

pub(super) async fn call(
    address: &StationAddress,
    token: Option<&str>,
    trust: &Trust,
    method: &str,
    params: &Value,
) -> Result<Value, ClientError> {
    let connector = address.encrypted.then(|| trust.connector()).transpose()?;
    let opening = async {
        let stream = trust::open(address, connector.as_ref()).await?;
        let handshake = http1::handshake(TokioIo::new(stream)).await;
        handshake.map_err(|error| no_station(address, error))
    };
    let opened = timeout(OPENING, opening).await;
    let (mut sender, connection) = opened.unwrap_or_else(|_| Err(no_station(address, SILENT)))?;
    let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    let mut request = Request::post("/api/v1/rpc")
        .header(HOST, &address.host)
        .header(CONTENT_TYPE, "application/json");
    if let Some(token) = token {
        request = request.header(AUTHORIZATION, format!("Bearer {token}"));
    }
    let request = request.body(message.to_string());
    let request = request.map_err(|error| ClientError::Address(error.to_string()))?;
    let answer = async {
        let response = sender.send_request(request).await.map_err(lost)?;
        let status = response.status();
        let body = response.into_body().collect().await.map_err(lost)?;
        Ok((status, body.to_bytes()))
    };
    // The connection ends with the answer.
    let (status, body) = tokio::select! {
        answer = answer => answer?,
        Err(error) = connection => return Err(lost(error)),
    };
    if status != StatusCode::OK {
        return Err(refused(address, status, Some(&body)));
    }
    let answer: Value = serde_json::from_slice(&body).map_err(|_| ClientError::Lost)?;
    outcome(&answer)
}

fn lost(_: hyper::Error) -> ClientError {
    ClientError::Lost
}
