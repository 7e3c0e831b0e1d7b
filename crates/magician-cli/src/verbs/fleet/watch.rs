//! `fleet watch`: shows the state of all arms of a site until Ctrl-C.

use std::io::{self, IsTerminal};
use std::time::Duration;

use magician_site::carrier::ZenohSite;
use magician_site::{Site, SiteEvent};
use serde_json::{Value, json};
use tokio::time::{MissedTickBehavior, interval};

use super::{as_json, condition, job_of};
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

/// Shortest time between two redraws of the table. A choice.
const REDRAW_INTERVAL: Duration = Duration::from_millis(200);
/// Escape sequences: cursor to the corner, clear the screen.
const CLEAR_SCREEN: &str = "\x1b[H\x1b[J";

pub(super) fn run(
    context: &mut Context,
    join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
) -> Result<(), Failure> {
    let json = context.global.json;
    let drawn = !json && io::stdout().is_terminal();
    context.run_with_own_line(async |out| {
        let site = join().await?;
        if drawn {
            table(&site, out).await
        } else {
            lines(&site, json, out).await
        }
    })
}

async fn table(site: &ZenohSite, out: &mut Output) -> Result<(), Failure> {
    use io::Write;
    let mut frames = interval(REDRAW_INTERVAL);
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        frames.tick().await;
        let known = site.arms();
        write!(out, "{CLEAR_SCREEN}")?;
        let (name, count) = (site.name(), known.len());
        out.line(format_args!("site {name}: {count} arms"))?;
        out.line("")?;
        if !known.is_empty() {
            super::list::rows(&known, None).write(out)?;
        }
        out.flush()?;
    }
}

async fn lines(site: &ZenohSite, json: bool, out: &mut Output) -> Result<(), Failure> {
    let mut events = site.watch();
    let mut shown = std::collections::BTreeMap::new();
    loop {
        let event = events.next().await;
        if json {
            out.event(&as_event(&event))?;
        } else if let Some(line) = as_line(&event, &mut shown) {
            out.line(line)?;
        }
        out.flush()?;
    }
}

/// Returns an event as JSON.
fn as_event(event: &SiteEvent) -> Value {
    let of = |event: &str, at, report| {
        let mut object = as_json(at, report, false);
        object["event"] = json!(event);
        object
    };
    match event {
        SiteEvent::Arrived(at) => of("arrived", at, None),
        SiteEvent::Left(at) => of("left", at, None),
        SiteEvent::Report(at, report) => of("state", at, Some(report)),
        SiteEvent::Missed => json!({"event": "missed"}),
    }
}

/// Returns an event as a line of text; `None` if the text has not changed.
fn as_line(
    event: &SiteEvent,
    shown: &mut std::collections::BTreeMap<magician_site::ArmAt, String>,
) -> Option<String> {
    match event {
        SiteEvent::Arrived(at) => Some(format!("{}: here, at station {}", at.arm, at.station)),
        SiteEvent::Left(at) => {
            shown.remove(at);
            Some(format!("{}: gone", at.arm))
        }
        SiteEvent::Report(at, report) => {
            let (job, holder) = job_of(Some(report));
            let mut line = condition(Some(report));
            for (what, text) in [("held by", holder), ("job", job)] {
                if !text.is_empty() {
                    line.push_str(&format!(", {what} {text}"));
                }
            }
            let is_new = shown.get(at) != Some(&line);
            shown.insert(at.clone(), line.clone());
            is_new.then(|| format!("{}: {line}", at.arm))
        }
        SiteEvent::Missed => Some("some events were missed".to_owned()),
    }
}
