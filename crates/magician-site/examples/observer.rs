//! Observes a site like a hub, and prints measurements: the other half of `interop/site/scale`.
//!
//! `observer SITE CONFIG FOLDER` reads one command per line: `wait ARMS`, `measure SECONDS`, `stop
//! ROUNDS` or `gone ARMS`. It answers each with a line of JSON. FOLDER has the certificate of this
//! machine; the token comes from `MAGICIAN_TOKEN`.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use magician_site::carrier::ZenohSite;
use magician_site::certificates::Identity;
use magician_site::{Caller, Site, SiteEvent};
use serde_json::{Value, json};
use tokio::time::{sleep, timeout_at};

/// Longest wait for an arm to appear, disappear or answer. After that the arm is reported.
const WAIT_TIMEOUT: Duration = Duration::from_secs(90);

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let (Some(name), Some(config), Some(folder)) = (words.next(), words.next(), words.next())
    else {
        return Err("observer SITE CONFIG FOLDER".into());
    };
    let config = PathBuf::from(config);
    let identity = Identity::open(&PathBuf::from(folder))?;
    let site = Arc::new(ZenohSite::join(name.parse()?, Some(&config), identity).await?);
    // Blocking here is fine: the network has its own runtime.
    for line in std::io::stdin().lines() {
        let line = line?;
        let (verb, number) = line.split_once(' ').ok_or("a command has a number")?;
        let number: u32 = number.parse()?;
        let answer = match verb {
            "wait" => {
                wait(&site, |arms, stated| {
                    arms >= number as usize && stated == arms
                })
                .await
            }
            "gone" => wait(&site, |arms, _| arms <= number as usize).await,
            "measure" => measure(&site, Duration::from_secs(number.into())).await,
            "stop" => stop(&site, number).await,
            _ => return Err("no such command".into()),
        };
        println!("{answer}");
    }
    Ok(())
}

/// Unix time in seconds, like `t` of a state.
fn wall() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap_or_default().as_secs_f64()
}

/// Waits until the number of arms and of known states satisfies `is_so`. Reports the time.
async fn wait(site: &ZenohSite, is_so: impl Fn(usize, usize) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let arms = site.arms();
        let known = |report: &&Option<magician_site::ArmReport>| {
            report
                .as_ref()
                .is_some_and(|report| !report.state.is_null())
        };
        let stated = arms.values().filter(known).count();
        let reached = is_so(arms.len(), stated);
        if reached || begun.elapsed() > WAIT_TIMEOUT {
            return json!({"reached": reached, "arms": arms.len(), "stated": stated, "at": wall()});
        }
        sleep(Duration::from_millis(5)).await;
    }
}

/// Measures the age of states when they arrive.
async fn measure(site: &ZenohSite, time: Duration) -> Value {
    let mut events = site.watch();
    // Skip the arms and states that are already present.
    while events.try_next().is_some() {}
    let end = tokio::time::Instant::now() + time;
    let (mut ages, mut others, mut bytes, mut moving) = (Vec::new(), 0_u32, 0, BTreeMap::new());
    while let Ok(event) = timeout_at(end, events.next()).await {
        let SiteEvent::Report(at, report) = event else {
            others += 1;
            continue;
        };
        if let Some(t) = report.state["t"].as_f64() {
            ages.push((wall() - t) * 1e3);
        }
        bytes += report.state.to_string().len();
        moving.insert(at, report.state["moving"] == true);
    }
    json!({
        "seconds": time.as_secs_f64(),
        "states": ages.len(),
        "bytes": bytes,
        "others": others,
        "arms": moving.len(),
        "moving": moving.values().filter(|moves| **moves).count(),
        "age_ms": spread(ages),
    })
}

/// Stops all arms `rounds` times, with one request to each station as a hub does. Each round lasts
/// until the last station has confirmed that its arms stand. Prints when each round began, to
/// compare with the traces of the arms.
async fn stop(site: &Arc<ZenohSite>, rounds: u32) -> Value {
    let caller = Caller {
        token: std::env::var("MAGICIAN_TOKEN").ok(),
    };
    let (mut single, mut whole, mut failed) = (Vec::new(), Vec::new(), 0);
    let mut walls = Vec::new();
    for _ in 0..rounds {
        // One arm of each station.
        let arms = site.arms().into_keys();
        let stations: BTreeMap<_, _> = arms.map(|at| (at.station, at)).collect();
        walls.push(wall());
        let begun = Instant::now();
        let mut calls = tokio::task::JoinSet::new();
        for at in stations.into_values() {
            let (site, caller) = (Arc::clone(site), caller.clone());
            calls.spawn(async move {
                let request = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.stop"});
                let answer = site.call(&at, &caller, request.to_string()).await;
                let took = begun.elapsed().as_secs_f64() * 1e3;
                let is_done = matches!(&answer, Ok(Some(text)) if text.contains("\"result\""));
                is_done.then_some(took)
            });
        }
        while let Some(took) = calls.join_next().await {
            match took.ok().flatten() {
                Some(took) => single.push(took),
                None => failed += 1,
            }
        }
        whole.push(begun.elapsed().as_secs_f64() * 1e3);
        sleep(Duration::from_secs(1)).await;
    }
    json!({"answer_ms": spread(single), "round_ms": spread(whole), "failed": failed, "began": walls})
}

fn spread(mut values: Vec<f64>) -> Value {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let last = values.len().saturating_sub(1) as f64;
        let value = values.get((last * part).round() as usize);
        value.map(|value| (value * 100.0).round() / 100.0)
    };
    json!({"count": values.len(), "p50": at(0.5), "p95": at(0.95), "p99": at(0.99), "max": at(1.0)})
}
