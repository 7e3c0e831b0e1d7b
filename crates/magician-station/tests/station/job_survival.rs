//! Table of survival: the list of jobs after a program ended in any way, with a job in any state.

use std::sync::atomic::Ordering;
use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Storage, Tester};
use crate::jobs::{drawing, until};

/// Way in which a program ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    /// `kill -9`, or a power failure.
    Killed,
    /// SIGTERM or Ctrl-C.
    Asked,
    /// The disk is full from here on, followed by `kill -9`.
    Full,
}

/// State of a job, and its state at the next station after each end. The same rows are in
/// `docs/reference/STATION.md`.
const TABLE: [(&str, [&str; 3]); 7] = [
    ("queued", ["queued", "queued", "queued"]),
    ("checking", ["interrupted", "stopped", "interrupted"]),
    ("running", ["interrupted", "stopped", "interrupted"]),
    ("pausing", ["interrupted", "stopped", "interrupted"]),
    ("paused", ["interrupted", "stopped", "interrupted"]),
    ("stopping", ["interrupted", "stopped", "interrupted"]),
    ("done", ["done", "done", "done"]),
];

/// Brings a job into a state. Returns its id.
async fn bring(bench: &LocalStation, anna: &mut Tester, state: &str) -> Value {
    anna.lease().await;
    if state == "queued" {
        anna.begin_job().await;
        let queue = json!({"text": drawing(), "queue": true});
        return anna.ok("job.start", queue).await["job"].clone();
    }
    bench.gate.close(state == "checking");
    let params = json!({"text": drawing(), "after_check": false});
    let job = anna.ok("job.start", params).await["job"].clone();
    if state == "checking" {
        return job;
    }
    until(anna, &job, "running").await;
    anna.listen(Duration::from_secs(4)).await;
    match state {
        "pausing" => drop(anna.send("job.pause", json!({"job": job}))),
        "paused" => drop(anna.ok("job.pause", json!({"job": job})).await),
        "stopping" => drop(anna.send("job.stop", json!({"job": job}))),
        "done" => drop(until(anna, &job, "done").await),
        _ => {}
    }
    for _ in 0..3000 {
        let now = anna.ok("job.get", json!({"job": job})).await;
        if now["state"] == json!(state) {
            break;
        }
        anna.listen(Duration::from_millis(1)).await;
    }
    job
}

/// Returns the state that the next station lists.
async fn listed(state: &str, end: End) -> Value {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    let job = bring(&bench, &mut anna, state).await;
    let now = anna.ok("job.get", json!({"job": job})).await;
    assert_eq!(now["state"], json!(state), "{end:?}");
    let kept = match end {
        End::Killed => bench.kept.copy(),
        End::Full => {
            // Everything reported before the flush is on the disk; nothing later is.
            bench.station.flush().await;
            bench.kept.full.store(true, Ordering::SeqCst);
            // Virtual time stands still while a program is being read.
            if state != "checking" {
                anna.listen(Duration::from_secs(60)).await;
            }
            let refused = anna
                .call("job.start", json!({"text": drawing(), "queue": true}))
                .await;
            assert!(refused.is_err(), "a job that is not kept is not taken");
            bench.kept.copy()
        }
        End::Asked => {
            let ending = tokio::spawn({
                let station = bench.station.clone();
                async move {
                    station.end_runs().await;
                    station.flush().await;
                }
            });
            tokio::task::yield_now().await;
            bench.gate.close(false);
            anna.listen(Duration::from_secs(7)).await;
            ending.await.unwrap();
            if !["queued", "done"].contains(&state) {
                let told = anna.noticed("job.changed");
                let last = told.iter().rev().find(|told| told["job"]["job"] == job);
                assert_eq!(
                    last.unwrap()["job"]["state"],
                    json!("stopped"),
                    "{state}: told before the end"
                );
            }
            bench.kept.copy()
        }
    };
    bench.gate.close(false);
    drop((anna, bench));
    list_after(kept, &job).await
}

async fn list_after(kept: Storage, job: &Value) -> Value {
    let bench = LocalStation::after(kept).await;
    let mut ben = bench.join_as("Ben", Role::Teacher).await;
    let list = ben.ok("job.list", json!({})).await["jobs"].clone();
    let found: Vec<_> = { list.as_array().unwrap().iter() }
        .filter(|found| found["job"] == *job)
        .collect();
    assert_eq!(found.len(), 1, "{list}");
    // A restart moves nothing.
    ben.listen(Duration::from_secs(60)).await;
    assert!(!bench.arms[0].state().moving);
    let later = ben.ok("job.get", json!({"job": job})).await;
    assert_eq!(later["state"], found[0]["state"]);
    found[0].clone()
}

#[tokio::test(start_paused = true)]
async fn job_states_survive_each_end_as_documented() {
    let page = include_str!("../../../../docs/reference/STATION.md");
    for (state, expected) in TABLE {
        for (end, expected) in [End::Killed, End::Asked, End::Full]
            .into_iter()
            .zip(expected)
        {
            let found = listed(state, end).await;
            println!("{state:<9} {end:?}: {}", found["state"]);
            assert_eq!(found["state"], json!(expected), "{state} {end:?}");
            let reason = (expected == "queued").then_some("restart");
            assert_eq!(found["reason"], json!(reason), "{state} {end:?}");
            let is_over = expected != "queued";
            assert_eq!(found["ended"].is_number(), is_over, "{state} {end:?}");
        }
        let [killed, asked, full] = expected;
        let row = format!("| `{state}` | `{killed}` | `{asked}` | `{full}` |");
        assert!(page.contains(&row), "docs/reference/STATION.md lacks {row}");
    }
}

#[tokio::test(start_paused = true)]
async fn refused_resume_leaves_the_job_unchanged() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.lease().await;
    let far =
        json!({"format": "magician-plan", "version": 1, "steps": [{"move": [600, 0, 50, 0]}]});
    let params = json!({"text": far.to_string(), "after_check": false});
    let job = anna.ok("job.start", params).await["job"].clone();
    let before = until(&mut anna, &job, "failed").await;
    assert_eq!(before["error"]["report"]["ok"], json!(false));
    for _ in 0..2 {
        let refused = anna.call("job.resume", json!({"job": job})).await;
        assert!(refused.is_err());
        let after = anna.ok("job.get", json!({"job": job})).await;
        assert_eq!(after, before);
    }
    bench.station.flush().await;
    let kept = bench.kept.copy();
    drop((anna, bench));
    assert_eq!(list_after(kept, &job).await, before);
}

#[tokio::test(start_paused = true)]
async fn unplaceable_program_is_refused_with_its_check_report() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='30mm' height='30mm' viewBox='0 0 30 30'>\
        <path d='M5 5H25' stroke='red'/></svg>";
    let setup = json!({"surface": -60, "at": [420, 0], "tool": "pen"});
    let params = json!({"text": svg, "format": "svg", "setup": setup});
    let report = anna.ok("job.check", params.clone()).await;
    assert_eq!(report["ok"], json!(false), "{report}");
    let refused = anna.call("job.start", params.clone()).await.unwrap_err();
    assert_eq!(refused["code"], json!(-32004), "{refused}");
    assert_eq!(refused["data"]["report"], report);
    let mut soon = params;
    soon["after_check"] = json!(false);
    let job = anna.ok("job.start", soon).await["job"].clone();
    let failed = until(&mut anna, &job, "failed").await;
    assert_eq!(failed["error"]["kind"], json!("check-failed"));
    assert_eq!(failed["error"]["report"], report);
}

#[tokio::test(start_paused = true)]
async fn endless_job_has_zero_loops_and_is_over_after_its_stop() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    anna.lease().await;
    for pause in [0, 1, 10, 100, 900, 4000] {
        let params = json!({"text": drawing(), "loops": 0});
        let job = anna.ok("job.start", params).await["job"].clone();
        assert_eq!(
            anna.ok("job.get", json!({"job": job})).await["loops"],
            json!(0)
        );
        anna.listen(Duration::from_millis(pause)).await;
        viewer.ok("arm.stop", json!({})).await;
        let after = viewer.ok("job.get", json!({"job": job})).await;
        assert_eq!(after["state"], json!("stopped"), "after {pause} ms");
    }
}

#[tokio::test(start_paused = true)]
async fn history_pages_through_all_jobs_and_totals_persist() {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let mut jobs = Vec::new();
    for _ in 0..3 {
        let job = teacher.begin_job().await;
        until(&mut teacher, &job, "done").await;
        jobs.push(job);
    }
    let running = teacher.begin_job().await;
    let busy = teacher.code("job.delete", json!({"job": running})).await;
    assert_eq!(busy, -32003);
    teacher.ok("job.stop", json!({"job": running})).await;
    let whole = teacher.ok("job.history", json!({})).await;
    assert_eq!(whole["jobs"].as_array().unwrap().len(), 4);
    let totals = whole["totals"].clone();
    assert_eq!(
        [&totals["jobs"], &totals["done"], &totals["stopped"]],
        [&json!(4), &json!(3), &json!(1)]
    );
    assert!(totals["travel_mm"].as_f64().unwrap() > 10.0, "{totals}");
    let part = teacher
        .ok("job.history", json!({"skip": 1, "limit": 2}))
        .await;
    assert_eq!(part["jobs"][0]["job"], jobs[1]);
    assert_eq!(part["jobs"][1]["job"], jobs[2]);
    assert_eq!(part["more"], json!(true));
    teacher.ok("job.delete", json!({"job": jobs[0]})).await;
    assert_eq!(
        teacher.code("job.get", json!({"job": jobs[0]})).await,
        -32602
    );
    let after = teacher.ok("job.history", json!({})).await;
    assert_eq!(after["jobs"].as_array().unwrap().len(), 3);
    assert_eq!(after["totals"], totals);
    let mut pupil = bench.join("Pupil").await;
    let refused = pupil.code("job.delete", json!({"job": jobs[1]})).await;
    assert_eq!(refused, -32001);
    bench.station.flush().await;
    let kept = bench.kept.copy();
    drop((teacher, pupil, bench));
    let bench = LocalStation::after(kept).await;
    let mut ben = bench.join("Ben").await;
    let left = ben.ok("job.history", json!({})).await;
    assert_eq!(left["totals"], totals);
}
