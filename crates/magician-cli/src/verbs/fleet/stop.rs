//! `fleet stop`: arms stand, wherever they are.

use std::time::Duration;

use magician::ErrorKind;
use magician_site::carrier::ZenohSite;
use magician_site::{ArmAt, Caller, Site, SiteError};
use serde_json::{Value, json};
use tokio::task::JoinSet;
use tokio::time::timeout;

use super::{Stop, gather};
use crate::context::Context;
use crate::failure::{Failure, Kind};

/// An arm that has not stood by then has not answered.
const PATIENCE: Duration = Duration::from_secs(5);

impl Stop {
    pub(super) fn run(
        self,
        context: &mut Context,
        caller: Caller,
        join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
    ) -> Result<(), Failure> {
        if caller.token.is_none() {
            return Err(no_token());
        }
        let json = context.global.json;
        context.attending(async |out| {
            let site = std::sync::Arc::new(join().await?);
            let known = gather(&site).await?;
            let meant = |at: &&ArmAt| self.all || self.names.contains(&at.arm);
            let arms: Vec<_> = known.keys().filter(meant).cloned().collect();
            let absent = self.names.iter();
            let absent: Vec<_> = absent
                .filter(|name| arms.iter().all(|at| at.arm != **name))
                .cloned()
                .collect();
            let mut stops = JoinSet::new();
            for at in arms {
                let (site, caller) = (std::sync::Arc::clone(&site), caller.clone());
                stops.spawn(async move {
                    let outcome = stop(&site, &at, &caller).await;
                    (at, outcome)
                });
            }
            let mut failed = absent.clone();
            for name in absent {
                let why = "it is not on the site";
                match json {
                    true => out.event(&json!({"arm": name, "stood": false, "error": why}))?,
                    false => out.line(format_args!("{name}: {why}"))?,
                }
            }
            while let Some(ended) = stops.join_next().await {
                let Ok((at, outcome)) = ended else { continue };
                let (stood, why) = match outcome {
                    Ok(()) => (true, None),
                    Err(why) => (false, Some(why)),
                };
                if !stood {
                    failed.push(at.arm.clone());
                }
                match (json, why) {
                    (true, why) => out.event(&json!({
                        "arm": at.arm,
                        "station": at.station.to_string(),
                        "stood": stood,
                        "error": why,
                    }))?,
                    (false, None) => out.line(format_args!("{}: stands", at.arm))?,
                    (false, Some(why)) => out.line(format_args!("{}: {why}", at.arm))?,
                }
                out.flush()?;
            }
            failed.sort();
            if failed.is_empty() {
                return Ok(());
            }
            let message = format!("not stopped for certain: {}", failed.join(", "));
            Err(Failure::new(Kind::Driver(ErrorKind::Timeout), message)
                .hint("stop them where they are: the arm has a power switch"))
        })
    }
}

/// Stops one arm; it stands when this is well.
pub(super) async fn stop(site: &ZenohSite, at: &ArmAt, caller: &Caller) -> Result<(), String> {
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.stop",
        "params": {"arm": at.arm}});
    let asked = timeout(PATIENCE, site.call(at, caller, request.to_string())).await;
    let answer = asked.unwrap_or(Err(SiteError::NoAnswer));
    let answer = answer
        .map_err(|error| error.to_string())?
        .unwrap_or_default();
    let answer: Value = serde_json::from_str(&answer).unwrap_or_default();
    if let Some(error) = answer["error"]["message"].as_str() {
        return Err(error.to_owned());
    }
    match answer["result"]["arms"][0]["stood"].as_bool() {
        Some(true) => Ok(()),
        _ => Err("it was told to stop, and has not said that it stands".to_owned()),
    }
}

pub(super) fn no_token() -> Failure {
    Failure::usage("a token is needed")
        .hint("set MAGICIAN_TOKEN to a token of the stations; `magician station token` makes one")
}
