//! One request to all stations of a site, answered as by one station: by a hub that lasts as long as that.

use std::sync::Arc;

use magician_site::Caller;
use magician_site::carrier::ZenohSite;
use magician_site::hub::{HubConfig, RunningHub};
use magician_station::client::ClientError;
use magician_station::http::Served;
use magician_station::{Grant, Peer, Role, StationConfig};
use serde_json::{Value, json};

use super::gather;
use super::stop::no_token;
use crate::context::Context;
use crate::failure::Failure;
use crate::serving::unix_time;

/// Asks the stations of the site that is joined, once.
pub(super) fn asks(
    caller: Caller,
    join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
) -> impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure> {
    move |context, method, params| {
        let token = caller.token.ok_or_else(no_token)?;
        context.alone(async |_, signals| {
            let asked = async {
                let site = join().await?;
                gather(&site).await?;
                ask(site, token, method, params).await
            };
            tokio::select! {
                answer = asked => answer,
                _ = signals.next() => Err(Failure::interrupted()),
            }
        })
    }
}

async fn ask(
    site: ZenohSite,
    token: String,
    method: &str,
    params: Value,
) -> Result<Value, Failure> {
    let since = unix_time();
    let mut station = StationConfig::new(Vec::new(), format!("{:x}", since.as_millis()));
    station.unix_zero = since.as_secs_f64();
    let hub = HubConfig {
        station,
        token: Some(token),
        // Stations write down what is asked of them.
        journal: Box::new(|_| {}),
    };
    let hub = RunningHub::start(hub, Arc::new(site));
    // What it may do the stations decide, by its token.
    let grant = Grant {
        role: Role::Teacher,
        token: None,
    };
    let lost = |_| Failure::from(ClientError::Lost);
    let peer = Peer::elsewhere(Some(grant), "console".to_owned()).map_err(lost)?;
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    let answer = hub.call(peer, None, &request.to_string()).await;
    let mut answer: Value = answer
        .and_then(|answer| serde_json::from_str(&answer).ok())
        .unwrap_or_default();
    match answer.get_mut("error").map(Value::take) {
        None => Ok(answer["result"].take()),
        Some(mut error) => Err(Failure::from(ClientError::Refused {
            code: error["code"].as_i64().unwrap_or_default(),
            message: error["message"].as_str().unwrap_or_default().to_owned(),
            data: error["data"].take(),
        })),
    }
}
