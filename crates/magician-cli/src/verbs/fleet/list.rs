//! `fleet list`: who is on the site.

use magician_site::Site;
use magician_site::carrier::ZenohSite;
use serde_json::json;

use super::{Known, as_json, condition, gather, job_of, twins};
use crate::columns::Columns;
use crate::context::Context;
use crate::failure::Failure;

pub(super) fn run(
    context: &mut Context,
    join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
) -> Result<(), Failure> {
    let (name, proved, known) = context.attending(async |_| {
        let site = join().await?;
        let known = gather(&site).await?;
        let (name, proved) = (site.name().to_owned(), site.is_proved());
        site.leave().await;
        Ok((name, proved, known))
    })?;
    let twins = twins(&known);
    let arms: Vec<_> = { known.iter() }
        .map(|(at, news)| as_json(at, news.as_ref(), twins.contains(&at.arm)))
        .collect();
    context.show(
        &json!({"site": name, "proved": proved, "arms": arms}),
        |out| rows(&known).write(out),
    )
}

/// The table.
pub(super) fn rows(known: &Known) -> Columns {
    let twins = twins(known);
    let mut columns = Columns::default();
    columns.row([
        "arm", "station", "machine", "port", "state", "holder", "job",
    ]);
    for (at, news) in known {
        let news = news.as_ref();
        let (job, holder) = job_of(news);
        let mut state = condition(news);
        if twins.contains(&at.arm) {
            state.push_str(", twice on the site");
        }
        let (machine, port) = news.map_or(("", ""), |news| (&news.machine, &news.port));
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
