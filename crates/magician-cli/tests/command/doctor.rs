//! `magician doctor` and `magician bench`, with a reachable arm and with every connection failure
//! that can be produced here.
#![cfg(unix)]

use crate::magician;
use crate::magician::device::Device;
use crate::magician::served::Served;
use crate::magician::{Run, run};
use rustix::fs::{FlockOperation, flock};
use serde_json::{Value, json};

/// Checks a port with a short timeout.
fn doctor(port: &str, more: &[&str]) -> Run {
    let arguments = [
        "--port",
        port,
        "--json",
        "--timeout",
        "2",
        "doctor",
        "--count",
        "5",
    ];
    run(&[&arguments[..], more].concat())
}

/// Returns the finding of a check.
fn finding<'a>(report: &'a Value, check: &str) -> &'a Value {
    let checks = report["checks"].as_array().expect("checks");
    let found = checks.iter().find(|finding| finding["check"] == check);
    found.unwrap_or_else(|| panic!("no {check} in {report}"))
}

fn says(finding: &Value, text: &str) -> bool {
    ["text", "hint"].iter().any(|part| {
        finding[part]
            .as_str()
            .is_some_and(|said| said.contains(text))
    })
}

#[test]
fn arm_is_examined_without_queueing_commands() {
    let run = doctor("sim", &[]);
    assert_eq!(run.status, 0, "{run:?}");
    let report = run.object();
    assert_eq!(
        (&report["ok"], &report["window"]),
        (&json!(true), &json!(8))
    );
    assert!(report["turnaround_ms"].is_f64(), "{report}");
    assert_eq!(finding(&report, "answer")["value"], "3.6.14");
    assert_eq!(finding(&report, "losses")["value"], 0);
    assert_eq!(finding(&report, "index_law")["ok"], Value::Null);
    assert!(says(finding(&report, "homed"), "magician home"));
}

#[test]
fn queue_is_tested_on_request_and_left_empty() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("arm");
    let path = path.to_str().expect("UTF-8");
    let arm = Served::start(&["--pty", path], 1);
    let report = doctor(path, &[]).object();
    assert_eq!(finding(&report, "queue")["value"], 0);
    let asked = doctor(path, &["--yes"]);
    let report = asked.object();
    // Turnaround and jitter depend on this machine, so they are not checked.
    let checks = report["checks"].as_array().expect("checks");
    let wrong = checks.iter().filter(|finding| finding["ok"] == false);
    let wrong: Vec<&Value> = wrong.map(|finding| &finding["check"]).collect();
    let timely = |check: &&Value| **check == "turnaround" || **check == "jitter";
    assert!(wrong.iter().all(timely), "{asked:?}");
    let expected = if wrong.is_empty() { 0 } else { 10 };
    assert_eq!(asked.status, expected, "{asked:?}");
    assert_eq!(finding(&report, "index_law")["value"], 15);
    assert_eq!(finding(&report, "left_space")["ok"], true);
    assert_eq!(finding(&report, "window")["value"], 8);
    let queue = run(&["--port", path, "--json", "queue", "status"]).object();
    assert_eq!(queue, json!({"current_index": 0, "left_space": 32}));
    // Commands queued by another program are reported and not dropped.
    assert_eq!(
        run(&["--port", path, "enqueue", "WAITCmd", "timeout=9"]).status,
        0
    );
    let run = doctor(path, &["--yes"]);
    assert_eq!(
        (run.status, &run.error()["kind"]),
        (10, &json!("check-failed"))
    );
    let report = run.object();
    assert_eq!(finding(&report, "queue")["value"], 1);
    assert!(says(finding(&report, "queue"), "magician stop"));
    drop(arm);
}

#[test]
fn causes_of_a_missing_arm_are_distinguished() {
    let silent = Device::answering(|_| Vec::new());
    let printer = Device::answering(|_| b"echo:Unknown command\nok\nMarlin 2.1\n".to_vec());
    let garbage = Device::answering(|_| vec![0xF8, 0x00, 0x78, 0x80, 0xFE]);
    let looped = Device::answering(<[u8]>::to_vec);
    for (device, status, text) in [
        (&silent, 5, "switched on"),
        (&printer, 6, "Marlin"),
        (&garbage, 6, "f8 00 78 80"),
        (&looped, 6, "loop"),
    ] {
        let run = doctor(&device.path, &[]);
        assert_eq!(run.status, status, "{run:?}");
        let report = run.object();
        let answer = finding(&report, "answer");
        assert!(answer["ok"] == false && says(answer, text), "{answer}");
        assert!(answer["hint"].is_string(), "{answer}");
        assert_eq!(run.error()["message"], answer["text"]);
    }
}

#[test]
fn busy_or_missing_port_is_reported() {
    let held = Device::answering(|_| Vec::new());
    flock(&held.line, FlockOperation::NonBlockingLockExclusive).expect("it locks");
    let run = doctor(&held.path, &[]);
    assert_eq!(run.status, 4, "{run:?}");
    assert!(says(finding(&run.object(), "line"), "in use by"));
    // A separate file: a shared one may be locked by another test.
    let file = tempfile::NamedTempFile::new().expect("a file");
    let file = file.path().to_str().expect("UTF-8");
    for (port, text) in [
        ("/dev/no-such-arm", "does not exist"),
        (file, "not a serial port"),
    ] {
        let run = doctor(port, &[]);
        assert_eq!((run.status, &run.error()["kind"]), (4, &json!("port")));
        assert!(says(finding(&run.object(), "line"), text), "{run:?}");
    }
    let run = doctor("nonsense", &[]);
    assert_eq!(run.object()["ok"], false);
    assert_eq!(
        (run.status, &run.error()["kind"]),
        (3, &json!("invalid-input"))
    );
}

#[test]
fn host_without_a_listener_is_reported() {
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let port = format!("udp:{}", socket.local_addr().expect("an address"));
    let silent = doctor(&port, &[]);
    assert_eq!(silent.status, 5, "{silent:?}");
    assert!(says(finding(&silent.object(), "answer"), "no reply"));
    drop(socket);
    let refused = doctor(&port, &[]);
    assert_eq!(refused.status, 5, "{refused:?}");
    assert!(says(
        finding(&refused.object(), "answer"),
        "nothing listens"
    ));
}

#[test]
fn no_window_is_recommended_for_datagrams() {
    let arm = Served::start(&["--udp", "127.0.0.1:0"], 1);
    for more in [&[][..], &["--yes"]] {
        let asked = doctor(&arm.endpoint("udp"), more);
        assert_eq!(asked.status, 0, "{asked:?}");
        assert_eq!(asked.object()["window"], 1);
        assert!(!asked.out.contains("MAGICIAN_WINDOW"), "{asked:?}");
    }
}

#[test]
fn long_move_is_not_mistaken_for_a_stopped_queue() {
    let arm = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "1"], 1);
    let port = arm.endpoint("tcp");
    let script = "alarms --clear\nmove 220 80 50 --speed-ratio 1 --no-wait\n";
    let moving = magician::run_with(&["--port", &port, "shell"], script.as_bytes());
    assert_eq!(moving.status, 0, "{moving:?}");
    let report = doctor(&port, &["--yes"]).object();
    let queue = finding(&report, "queue");
    assert!(queue["ok"].is_null() && says(queue, "it runs"), "{queue}");
    let law = finding(&report, "index_law");
    assert!(says(law, "not tried"), "the move goes on: {law}");
}

#[test]
fn text_output_has_one_line_per_finding_with_advice() {
    let run = run(&["--port", "sim", "doctor", "--count", "5"]);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    assert!(
        run.out.contains("✓ answer") && run.out.contains("→ "),
        "{}",
        run.out
    );
    let silent = Device::answering(|_| Vec::new());
    let told = magician::run(&["--port", &silent.path, "--timeout", "0.1", "doctor"]);
    assert_eq!(told.status, 5);
    assert!(told.out.contains("✗ answer"), "{}", told.out);
    assert!(
        !told.err.contains("error:"),
        "it is told once: {}",
        told.err
    );
}

#[test]
fn bench_measures_everything_on_a_virtual_arm() {
    let run = run(&[
        "--port",
        "sim",
        "bench",
        "--json",
        // With a full queue the arm takes a segment every 20 ms.
        "--seconds",
        "1.5",
        "--stops",
        "1",
    ]);
    assert_eq!(run.status, 0, "{run:?}");
    let figures = run.object();
    for key in ["get_pose_per_s", "enqueue_per_s", "turnaround_ms"] {
        assert!(
            figures[key].as_f64().is_some_and(|value| value > 0.0),
            "{key}: {figures}"
        );
    }
    assert_eq!(figures["window"], 1);
    assert_eq!(
        figures["h2"],
        Value::Null,
        "it is for windows of 4 and more"
    );
    for key in ["h1", "h3", "h4", "h5", "h7"] {
        assert!(figures[key].is_object(), "{key}: {figures}");
    }
}

#[test]
fn bench_draws_only_with_confirmation() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("arm");
    let path = path.to_str().expect("UTF-8");
    let arm = Served::start(&["--pty", path], 1);
    let bench = |more: &[&str]| {
        let arguments = ["--port", path, "--json", "bench", "--seconds", "0.2"];
        run(&[&arguments[..], more].concat()).object()
    };
    let figures = bench(&["--only", "h1,h3,h4"]);
    assert!(figures["get_pose_per_s"].is_f64() && figures["enqueue_per_s"].is_null());
    assert!(figures["h3"].is_null() && figures["h4"].is_null() && figures["h7"].is_null());
    let index = run(&["--port", path, "--json", "queue", "status"]).object();
    assert_eq!(index["current_index"], 0);
    // Commands queued by another program are not run by a measurement.
    let port = ["--port", path];
    let waiting = run(&[&port[..], &["enqueue", "WAITCmd", "timeout=9"]].concat());
    assert_eq!(waiting.status, 0, "{waiting:?}");
    let refused = run(&[&port[..], &["bench", "--yes", "--seconds", "0.2"]].concat());
    assert_eq!(refused.status, 3, "{refused:?}");
    assert!(refused.err.contains("another program"), "{refused:?}");
    assert_eq!(run(&[&port[..], &["stop"]].concat()).status, 0);
    let speeds = run(&["--port", path, "--json", "get", "CPParams"]).object();
    let stood = run(&["--port", path, "--json", "pose"]).object();
    let figures = bench(&["--only", "h2,h4", "--stops", "1", "--yes", "--window", "4"]);
    assert!(
        figures["h2"].is_object() && figures["h4"].is_object(),
        "{figures}"
    );
    assert_eq!(figures["window"], 4);
    let after = run(&["--port", path, "--json", "get", "CPParams"]).object();
    assert_eq!(speeds, after, "the path speeds are given back");
    let stands = run(&["--port", path, "--json", "pose"]).object();
    for axis in ["x", "y", "z"] {
        let [from, to] = [&stood, &stands].map(|pose| pose[axis].as_f64().expect("a number"));
        assert!(
            (from - to).abs() < 0.01,
            "the arm is where it was: {stood} {stands}"
        );
    }
    drop(arm);
}
