//! `fleet expect`: the roster of arms that belong to a site.

use std::sync::Arc;
use std::time::Duration;

use magician::ErrorKind;
use magician_site::carrier::ZenohSite;
use magician_site::{Caller, Roster, Site};
use serde_json::json;
use tokio::time::timeout;

use super::hub::request;
use super::stop::no_token;
use super::{Expect, Known, gather};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::{Failure, Kind};

/// Longest wait for an expected arm that has not appeared yet, after the site was gathered. A
/// choice.
const LATE_ARM_TIMEOUT: Duration = Duration::from_millis(600);

impl Expect {
    pub(super) fn run(
        self,
        context: &mut Context,
        caller: Caller,
        join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
    ) -> Result<(), Failure> {
        if caller.token.is_none() && !self.show {
            return Err(no_token());
        }
        let (expected, missing) = context.run_with_own_line(async |_| {
            let site = Arc::new(join().await?);
            let known = gather(&site).await?;
            if !self.show {
                let roster = if self.none {
                    Roster::default()
                } else {
                    present_roster(&known)
                };
                let token = caller.token.ok_or_else(no_token)?;
                request(Arc::clone(&site), token, "site.expect", roster.to_value()).await?;
            }
            let expected = site.roster().await;
            wait_for(&site, &expected).await;
            let missing = missing(&site, &expected);
            Ok((expected, missing))
        })?;
        let is_there = |arm: &str| !missing.iter().any(|(name, _)| name == arm);
        let rows: Vec<_> = { expected.arms() }
            .map(|(arm, machine)| json!({"name": arm, "machine": machine, "there": is_there(arm)}))
            .collect();
        context.show(&json!({ "expected": rows }), |out| {
            if expected.is_empty() {
                return out.line("no arms are expected");
            }
            let mut columns = Columns::default();
            for (arm, machine) in expected.arms() {
                let state = if is_there(arm) { "" } else { "missing" };
                columns.row([arm, machine, state]);
            }
            columns.write(out)
        })?;
        if missing.is_empty() {
            return Ok(());
        }
        let missing = missing.iter().map(|(arm, place)| format!("{arm}{place}"));
        let missing: Vec<_> = missing.collect();
        Err(absent(format!(
            "expected but not on the site: {}",
            missing.join(", ")
        )))
    }
}

/// Returns a roster of all arms that are present.
pub(super) fn present_roster(known: &Known) -> Roster {
    let mut roster = Roster::default();
    for (at, report) in known {
        let machine = report.as_ref().map_or("", |report| &report.machine);
        roster.expect(at.arm.clone(), machine);
    }
    roster
}

/// Returns the expected arms that are absent, each with ` on MACHINE` if the machine is known.
pub(super) fn missing(site: &ZenohSite, expected: &Roster) -> Vec<(String, String)> {
    let there = site.arms();
    let is_there = |arm: &str| there.keys().any(|at| at.arm == arm);
    let missing = expected.arms().filter(|(arm, _)| !is_there(arm));
    let place = |machine: &str| match machine {
        "" => String::new(),
        machine => format!(" on {machine}"),
    };
    missing
        .map(|(arm, machine)| (arm.to_owned(), place(machine)))
        .collect()
}

/// Returns the sentence about an absent arm. `place` comes from [`missing`].
pub(super) fn why_missing(place: &str) -> String {
    format!("expected{place}, but not on the site")
}

/// Gives expected arms time to appear.
pub(super) async fn wait_for(site: &ZenohSite, expected: &Roster) {
    let mut events = site.watch();
    let all_there = async {
        while !missing(site, expected).is_empty() {
            events.next().await;
        }
    };
    // A timeout is not an error here: the caller names the arms that are still missing.
    let _ = timeout(LATE_ARM_TIMEOUT, all_there).await;
}

/// Failure because expected arms are absent.
pub(super) fn absent(message: String) -> Failure {
    Failure::new(Kind::Driver(ErrorKind::Timeout), message)
}
