//! Jobs of a station that is killed, ended, out of disk space or not alone, and runs of the
//! command: what the next station lists.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::{Run, command, signal};
use crate::serve::Station;

fn in_state(state: &Path) -> Command {
    let mut command = command();
    command.env("XDG_STATE_HOME", state);
    command
}

/// Returns a plan that takes half a minute.
fn slow() -> String {
    let steps: Vec<_> = (0..60)
        .flat_map(|at| [json!({"move": [220, at % 7, 20, 0]}), json!({"wait": 0.5})])
        .collect();
    json!({"format": "magician-plan", "version": 1, "title": "slow", "steps": steps}).to_string()
}

/// Returns a plan of one step.
fn short() -> String {
    json!({"format": "magician-plan", "version": 1, "title": "short", "steps": [{"wait": 0.01}]})
        .to_string()
}

fn job(station: &Station, params: &Value) -> Value {
    let answer = station.call("job.start", params);
    let job = answer["result"]["job"].clone();
    assert!(job.is_string(), "{answer}");
    job
}

fn until(station: &Station, job: &Value, state: &str) {
    // A deadline, so that the test fails instead of hanging.
    let deadline = Instant::now() + Duration::from_secs(120);
    while Instant::now() < deadline {
        let now = station.call("job.get", &json!({"job": job}));
        if now["result"]["state"] == json!(state) {
            return;
        }
    }
    panic!("never {state}");
}

fn states(station: &Station, jobs: &[&Value]) -> Vec<String> {
    let list = station.call("job.list", &json!({}));
    let list = list["result"]["jobs"].as_array().expect("jobs").clone();
    let state = |job: &&Value| {
        let found: Vec<_> = list.iter().filter(|found| found["job"] == **job).collect();
        assert_eq!(found.len(), 1, "{job} in {list:?}");
        found[0]["state"].as_str().expect("a state").to_owned()
    };
    jobs.iter().map(state).collect()
}

/// Finished, active, paused and waiting jobs after each way in which the process ends.
#[test]
fn jobs_of_an_ended_station_are_listed_by_the_next() {
    let state = tempfile::tempdir().expect("a directory");
    for (signal, left) in [("-KILL", "interrupted"), ("-TERM", "stopped")] {
        for is_paused in [false, true] {
            let station = Station::of(in_state(state.path()), &["--port", "sim"]);
            let done = job(&station, &json!({"text": short()}));
            until(&station, &done, "done");
            // Answers come in the order of writing, so the end of this job is on disk when the next
            // request is answered.
            let key = format!("{signal} {is_paused}");
            let params = json!({"text": slow(), "key": key});
            let under_way = job(&station, &params);
            if is_paused {
                let paused = station.call("job.pause", &json!({"job": under_way}));
                assert_eq!(paused["result"]["state"], json!("paused"), "{paused}");
            }
            // The process is killed right after the answer.
            let waits = job(&station, &json!({"text": short(), "queue": true}));
            let (status, _) = station.served.end(signal);
            assert_eq!(status.code(), (signal == "-TERM").then_some(0));
            let station = Station::of(in_state(state.path()), &["--port", "sim"]);
            let found = states(&station, &[&done, &under_way, &waits]);
            assert_eq!(found, ["done", left, "queued"], "{signal} {is_paused}");
            assert_eq!(job(&station, &params), under_way, "the key has its job");
            let moved = station.call("arm.move", &json!({"to": [220, 30, 50, 0]}));
            assert!(moved["result"].is_object(), "{moved}");
            let found = states(&station, &[&under_way, &waits]);
            assert_eq!(found, [left, "queued"], "nothing begins by itself");
            let resumed = station.call("job.resume", &json!({"job": waits}));
            assert!(resumed["result"].is_object(), "{resumed}");
            until(&station, &waits, "done");
        }
    }
}

/// A job that does not fit on the disk is refused by name; earlier ones remain.
#[test]
fn full_disk_refuses_a_start_without_losing_jobs() {
    let state = tempfile::tempdir().expect("a directory");
    let mut shell = Command::new("sh");
    let inherited = in_state(state.path());
    for (name, value) in inherited.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    // 64 blocks of 512 bytes; a write beyond them fails.
    let script = "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\"";
    shell.args(["-c", script]).arg(inherited.get_program());
    let station = Station::of(shell, &["--port", "sim", "--no-studio"]);
    let small = job(&station, &json!({"text": short()}));
    until(&station, &small, "done");
    let mut large: Value = serde_json::from_str(&short()).expect("JSON");
    large["title"] = json!("x".repeat(64 * 1024));
    for queue in [false, true] {
        let params = json!({"text": large.to_string(), "queue": queue});
        let refused = station.call("job.start", &params);
        assert_eq!(
            refused["error"]["data"]["kind"],
            json!("closed"),
            "{refused}"
        );
        let message = refused["error"]["message"].as_str().expect("text");
        assert!(message.contains("virtual-arm.json"), "{message}");
    }
    let moved = station.call("arm.move", &json!({"to": [220, 10, 50, 0]}));
    assert!(moved["result"].is_object(), "{moved}");
    let again = job(&station, &json!({"text": short()}));
    until(&station, &again, "done");
    // An answered request has been written. SIGTERM, since a kill right afterwards could come
    // earlier.
    station.served.end("-TERM");
    let station = Station::of(in_state(state.path()), &["--port", "sim"]);
    assert_eq!(states(&station, &[&small, &again]), ["done", "done"]);
}

#[test]
fn two_stations_share_the_folder_but_no_arm() {
    let state = tempfile::tempdir().expect("a directory");
    let arm = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    let endpoint = arm.endpoint("tcp");
    mark_homed(in_state(state.path()), &endpoint);
    let first = Station::of(in_state(state.path()), &["--port", &endpoint]);
    let second = Run::of(
        in_state(state.path()).args(["--port", &endpoint, "serve", "--listen", "127.0.0.1:0"]),
        b"",
    );
    assert_eq!(second.status, 4, "{second:?}");
    assert!(second.err.contains("another station"), "{second:?}");
    let beside = Station::of(in_state(state.path()), &["--port", "sim"]);
    let jobs = [&first, &beside].map(|station| job(station, &json!({"text": short()})));
    until(&first, &jobs[0], "done");
    until(&beside, &jobs[1], "done");
    first.served.end("-TERM");
    beside.served.end("-TERM");
    // Under another name, for the same arm.
    let named = format!("left={endpoint}");
    let first = Station::of(in_state(state.path()), &["--arm", &named]);
    assert_eq!(states(&first, &[&jobs[0]]), ["done"]);
    let beside = Station::of(in_state(state.path()), &["--port", "sim"]);
    assert_eq!(states(&beside, &[&jobs[1]]), ["done"]);
}

#[test]
fn damaged_file_of_jobs_is_named_and_stays() {
    let state = tempfile::tempdir().expect("a directory");
    let folder = state.path().join("magician/station/jobs");
    std::fs::create_dir_all(&folder).expect("made");
    let file = folder.join("virtual-arm.json");
    for (text, why) in [
        ("{\"version\":2,\"jo", "EOF"),
        ("{\"version\":9,\"jobs\":[]}", "version 9"),
    ] {
        std::fs::write(&file, text).expect("written");
        let mut serve = in_state(state.path());
        serve.args(["--port", "sim", "serve", "--listen", "127.0.0.1:0"]);
        let refused = Run::of(&mut serve, b"");
        assert_eq!(refused.status, 3, "{refused:?}");
        for told in ["virtual-arm.json", why, "move the file away"] {
            assert!(refused.err.contains(told), "{told}: {refused:?}");
        }
        assert_eq!(std::fs::read_to_string(&file).expect("there"), text);
    }
}

/// Runs of the command are listed and can be resumed there.
#[test]
fn interrupted_run_of_the_command_is_listed_and_resumed_at_a_station() {
    let steps: Vec<_> = (0..24)
        .flat_map(|at| {
            [
                json!({"move": [230, at - 12, 20, 0]}),
                json!({"wait": 0.05}),
            ]
        })
        .collect();
    let plan = json!({"format": "magician-plan", "version": 1, "title": "waits", "tool": "none", "steps": steps});
    let finished = |line: &str| line.ends_with(" WAITCmd finished");
    for end in ["-INT", "-KILL"] {
        let state = tempfile::tempdir().expect("a directory");
        let mut arm = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "2", "-v"], 1);
        let endpoint = arm.endpoint("tcp");
        mark_homed(in_state(state.path()), &endpoint);
        let program = state.path().join("waits.plan.json");
        std::fs::write(&program, plan.to_string()).expect("written");
        let alarms = Run::of(
            in_state(state.path()).args(["--port", &endpoint, "alarms", "--clear"]),
            b"",
        );
        assert_eq!(alarms.status, 0, "{alarms:?}");
        let mut run = in_state(state.path());
        run.args(["--port", &endpoint, "run"]).arg(&program);
        let mut run = { run.stdout(Stdio::null()).stderr(Stdio::null()) }
            .spawn()
            .expect("it starts");
        for _ in 0..5 {
            arm.until(finished);
        }
        signal(end, &run);
        run.wait().expect("it ends");
        let station = Station::of(in_state(state.path()), &["--port", &endpoint]);
        let list = station.call("job.list", &json!({}));
        let jobs = list["result"]["jobs"].as_array().expect("jobs").clone();
        let left = jobs.last().expect("the run");
        assert_eq!(
            (&left["state"], &left["title"], &left["steps"]),
            (&json!("interrupted"), &json!("waits"), &json!(48)),
            "{end}: {list}"
        );
        let id = left["job"].clone();
        let resumed = station.call("job.resume", &json!({"job": id}));
        assert_eq!(
            resumed["result"]["state"],
            json!("running"),
            "{end}: {resumed}"
        );
        until(&station, &id, "done");
        station.served.end("-TERM");
        let station = Station::of(in_state(state.path()), &["--port", &endpoint]);
        assert_eq!(states(&station, &[&id]), ["done"]);
        let list = station.call("job.list", &json!({}));
        let jobs = list["result"]["jobs"].as_array().expect("jobs").len();
        assert_eq!(jobs, 1, "{list}");
        drop(station);
        let waits = arm.log().iter().filter(|line| finished(line)).count();
        assert_eq!(waits, 24, "each step is done once");
    }
}
