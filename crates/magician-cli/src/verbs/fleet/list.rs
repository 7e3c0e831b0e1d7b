//! `fleet list`: lists the arms on the site.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_site::carrier::ZenohSite;
use magician_site::{Site, StationId};
use serde_json::json;

use super::expect::{missing, wait_for, why_missing};
use super::{Known, as_json, condition, gather, job_of, twins};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;

/// Longest wait for a station to present its certificate. A choice.
const PROOF_TIMEOUT: Duration = Duration::from_secs(1);

pub(super) fn run(
    context: &mut Context,
    join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
) -> Result<(), Failure> {
    let (site, known, proved_stations, missing) = context.run_with_own_line(async |_| {
        let site = join().await?;
        gather(&site).await?;
        let expected = site.roster().await;
        wait_for(&site, &expected).await;
        let proved_stations = site.proved_stations(PROOF_TIMEOUT).await;
        let (known, missing) = (site.arms(), missing(&site, &expected));
        Ok((site, known, proved_stations, missing))
    })?;
    let twins = twins(&known);
    let arms: Vec<_> = { known.iter() }
        .map(|(at, report)| {
            let mut arm = as_json(at, report.as_ref(), twins.contains(&at.arm));
            arm["proved"] = json!(proved_stations.contains(&at.station));
            arm
        })
        .collect();
    let absent: Vec<_> = missing.iter().map(|(arm, _)| arm).collect();
    let shown = json!({
        "site": site.name(), "proved": site.is_proved(), "arms": arms, "missing": absent,
    });
    // On a machine without a certificate no station can be verified, which is reported once.
    let proved_stations = site.is_proved().then_some(&proved_stations);
    context.show(&shown, |out| {
        rows(&known, proved_stations).write(out)?;
        for (arm, place) in &missing {
            out.line(format_args!("{arm}: {}", why_missing(place)))?;
        }
        Ok(())
    })
}

/// Returns the table. Stations missing from `proved` are marked; with `None` no station is.
pub(super) fn rows(known: &Known, proved_stations: Option<&BTreeSet<StationId>>) -> Columns {
    let twins = twins(known);
    let mut columns = Columns::default();
    columns.row([
        "arm", "station", "machine", "port", "state", "holder", "job",
    ]);
    for (at, report) in known {
        let report = report.as_ref();
        let (job, holder) = job_of(report);
        let mut state = condition(report);
        if twins.contains(&at.arm) {
            state.push_str(", twice on the site");
        }
        if proved_stations.is_some_and(|proved_stations| !proved_stations.contains(&at.station)) {
            state.push_str(", unproved");
        }
        let (machine, port) = report.map_or(("", ""), |report| (&report.machine, &report.port));
        columns.row([
            at.arm.as_str(),
            &at.station.to_string(),
            machine,
            port,
            &state,
            &holder,
            &job,
        ]);
    }
    columns
}
