//! Sends one request to all stations of a site through a temporary hub, which merges their answers
//! into one.

use std::sync::Arc;

use magician_site::Caller;
use magician_site::carrier::ZenohSite;
use magician_site::hub::{HubConfig, RunningHub};
use magician_station::client::ClientError;
use magician_station::http::ApiServer;
use magician_station::{Grant, Peer, Role, StationConfig};
use serde_json::{Value, json};

use super::stop::no_token;
use super::{expect, gather};
use crate::context::Context;
use crate::failure::Failure;
use crate::serving::unix_time;

/// Returns a function that joins the site and makes one request to its stations.
pub(super) fn requester(
    caller: Caller,
    join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
) -> impl FnOnce(&mut Context, &str, Value) -> Result<Value, Failure> {
    move |context, method, params| {
        let token = caller.token.ok_or_else(no_token)?;
        context.run_without_arm(async |_, signals| {
            let asked = async {
                let site = Arc::new(join().await?);
                gather(&site).await?;
                request(site, token, method, params).await
            };
            tokio::select! {
                answer = asked => answer,
                _ = signals.next() => Err(Failure::interrupted()),
            }
        })
    }
}

/// Makes a request through a hub that knows the roster. Equal answers are shown once, with the arms
/// that differ.
pub(super) async fn request(
    site: Arc<ZenohSite>,
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
        // No journal here: the stations keep one of the requests they receive.
        journal: Box::new(|_| {}),
    };
    let hub = RunningHub::start(hub, Arc::clone(&site) as _);
    expect::wait_for(&site, &hub.read_roster().await).await;
    let mut answer = call(&hub, method, params).await?;
    if method == "class.get" {
        let schedule = call(&hub, "schedule.get", json!({})).await?;
        answer["differ_in_schedule"] = schedule["differ"].clone();
    }
    Ok(answer)
}

async fn call(hub: &RunningHub, method: &str, params: Value) -> Result<Value, Failure> {
    // The stations decide about permissions, by the token.
    let grant = Grant {
        role: Role::Teacher,
        token: None,
    };
    let lost = |_| Failure::from(ClientError::Lost);
    let peer = Peer::elsewhere(Some(grant), "console".to_owned()).map_err(lost)?;
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
    let answer = hub.call(peer, None, &request.to_string()).await;
    let mut answer: Value = answer
        // A malformed answer becomes an empty result.
        .and_then(|answer| serde_json::from_str(&answer).ok())
        .unwrap_or_default();
    match answer.get_mut("error").map(Value::take) {
        None => Ok(answer["result"].take()),
        // An absent station may come back; the request itself was correct.
        Some(error)
            if error["data"]["missing"]
                .as_array()
                .is_some_and(|arms| !arms.is_empty()) =>
        {
            let mut message = error["message"].as_str().unwrap_or_default().to_owned();
            let done = error["data"]["arms"].as_array().into_iter().flatten();
            let done: Vec<_> = done.filter_map(Value::as_str).collect();
            if !done.is_empty() {
                message.push_str(&format!("; done at {}", done.join(", ")));
            }
            Err(expect::absent(message))
        }
        Some(mut error) => Err(Failure::from(ClientError::Refused {
            code: error["code"].as_i64().unwrap_or_default(),
            message: error["message"].as_str().unwrap_or_default().to_owned(),
            data: error["data"].take(),
        })),
    }
}
