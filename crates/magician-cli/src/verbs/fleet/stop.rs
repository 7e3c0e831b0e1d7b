//! `fleet stop`: stops arms on any machine of the site.

use std::collections::BTreeMap;
use std::time::Duration;

use magician::ErrorKind;
use magician_site::carrier::ZenohSite;
use magician_site::{ArmAt, Caller, Site, SiteError, StationId};
use serde_json::{Value, json};
use tokio::task::JoinSet;
use tokio::time::timeout;

use super::expect::{missing, wait_for, why_missing};
use super::{Stop, gather};
use crate::context::Context;
use crate::failure::{Failure, Kind};

/// Longest wait for an arm to confirm that it stands.
pub(super) const STOP_CONFIRM_TIMEOUT: Duration = Duration::from_secs(5);

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
        context.run_with_own_line(async |out| {
            let site = std::sync::Arc::new(join().await?);
            let known = gather(&site).await?;
            let meant = |at: &&ArmAt| self.all || self.names.contains(&at.arm);
            let arms: Vec<_> = known.keys().filter(meant).cloned().collect();
            let is_there = |name: &&String| arms.iter().any(|at| at.arm == **name);
            let absent = self.names.iter().filter(|name| !is_there(name));
            let mut absent: Vec<_> = absent
                .map(|name| (name.clone(), "it is not on the site".to_owned()))
                .collect();
            let mut stops = JoinSet::new();
            let mut begin = |arms| {
                for arms in requests(arms, self.all) {
                    let (site, caller) = (std::sync::Arc::clone(&site), caller.clone());
                    stops.spawn(async move { stop(&site, arms, self.all, &caller).await });
                }
            };
            begin(arms);
            if self.all {
                // Arms that were found first are being stopped already while late ones appear.
                let expected = site.roster().await;
                wait_for(&site, &expected).await;
                let there = site.arms().into_keys();
                begin(there.filter(|at| !known.contains_key(at)).collect());
                let missing = missing(&site, &expected).into_iter();
                absent.extend(missing.map(|(name, place)| (name, why_missing(&place))));
            }
            let mut failed = Vec::new();
            for (name, why) in absent {
                if json {
                    out.event(&json!({"arm": name, "stood": false, "error": why}))?;
                } else {
                    out.line(format_args!("{name}: {why}"))?;
                }
                failed.push(name);
            }
            while let Some(ended) = stops.join_next().await {
                for (at, why) in ended.unwrap_or_default() {
                    match (json, &why) {
                        (true, why) => out.event(&json!({
                            "arm": at.arm,
                            "station": at.station.to_string(),
                            "stood": why.is_none(),
                            "error": why,
                        }))?,
                        (false, None) => out.line(format_args!("{}: stands", at.arm))?,
                        (false, Some(why)) => out.line(format_args!("{}: {why}", at.arm))?,
                    }
                    if why.is_some() {
                        failed.push(at.arm);
                    }
                }
                out.flush()?;
            }
            failed.sort();
            if failed.is_empty() {
                return Ok(());
            }
            let message = format!("may not have stopped: {}", failed.join(", "));
            Err(Failure::new(Kind::Driver(ErrorKind::Timeout), message)
                .hint("stop them on site: each arm has a power switch"))
        })
    }
}

/// Groups arms into requests: with `all` one request per station, otherwise one per arm.
fn requests(arms: Vec<ArmAt>, all: bool) -> Vec<Vec<ArmAt>> {
    if !all {
        return arms.into_iter().map(|at| vec![at]).collect();
    }
    let mut stations: BTreeMap<StationId, Vec<ArmAt>> = BTreeMap::new();
    for at in arms {
        stations.entry(at.station).or_default().push(at);
    }
    stations.into_values().collect()
}

/// Stops arms of one station. Returns the reason for each arm not known to have stopped.
async fn stop(
    site: &ZenohSite,
    arms: Vec<ArmAt>,
    all: bool,
    caller: &Caller,
) -> Vec<(ArmAt, Option<String>)> {
    let Some(first) = arms.first() else {
        return Vec::new();
    };
    // Without an arm the station stops all of its arms.
    let params = if all {
        json!({})
    } else {
        json!({"arm": first.arm})
    };
    let request = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.stop", "params": params});
    let asked = timeout(
        STOP_CONFIRM_TIMEOUT,
        site.call(first, caller, request.to_string()),
    )
    .await;
    let answer = asked.unwrap_or(Err(SiteError::NoAnswer));
    // An empty or malformed answer does not confirm a stop.
    let answer = answer.map(|answer| answer.unwrap_or_default());
    let answer = answer.map(|answer| serde_json::from_str::<Value>(&answer).unwrap_or_default());
    let why = |at: &ArmAt| {
        let answer = match &answer {
            Ok(answer) => answer,
            Err(error) => return Some(error.to_string()),
        };
        let error = &answer["error"];
        // An error also lists the arms that did stop.
        let told = [&answer["result"], &error["data"]].map(|told| told["arms"].as_array());
        let mut told = told.into_iter().flatten().flatten();
        if told.any(|told| told["arm"] == at.arm.as_str() && told["stood"] == true) {
            return None;
        }
        let unsaid = "a stop was requested, but not confirmed";
        Some(error["message"].as_str().unwrap_or(unsaid).to_owned())
    };
    let outcome: Vec<_> = arms.iter().map(why).collect();
    arms.into_iter().zip(outcome).collect()
}

pub(super) fn no_token() -> Failure {
    Failure::usage("a token is needed").hint(
        "set MAGICIAN_TOKEN to a token that all stations accept: a token in the file of each \
                station's `serve --token-file`",
    )
}
