//! Ctrl-C and SIGTERM while the arm moves: the command ends when the arm stands.
#![cfg(unix)]

mod magician;

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use magician::served::Served;
use magician::{command, run};
use serde_json::{Value, json};

/// An arm at real speed behind a pseudo-terminal, its alarms cleared, and a second door to look in.
struct Place {
    dir: tempfile::TempDir,
    served: Served,
}

impl Place {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let path = dir.path().join("arm");
        let path = path.to_str().expect("UTF-8");
        let served = Served::start(&["--pty", path, "--tcp", "127.0.0.1:0", "--speed", "1"], 2);
        let place = Self { dir, served };
        assert_eq!(
            run(&["--port", &place.port(), "alarms", "--clear"]).status,
            0
        );
        place
    }

    fn port(&self) -> String {
        let path = self.dir.path().join("arm");
        path.to_str().expect("UTF-8").to_owned()
    }

    fn look(&self, arguments: &[&str]) -> Value {
        let door = self.served.door("tcp");
        run(&[&["--port", &door, "--json"], arguments].concat()).object()
    }

    /// A move that takes minutes, under way: seen to have left the pose it began at.
    fn slow_move(&self) -> Child {
        let before = self.look(&["pose"]);
        let child = command()
            .args(["--port", &self.port(), "--json"])
            .args(["move", "220", "80", "50", "--speed-ratio", "1"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let moved = (0..10_000).any(|_| self.look(&["pose"]) != before);
        assert!(moved, "the arm does not begin to move");
        child
    }
}

fn signal(signal: &str, process: u32) -> bool {
    let mut kill = Command::new("kill");
    let kill = kill
        .args([signal, &process.to_string()])
        .stderr(Stdio::null());
    kill.status().is_ok_and(|status| status.success())
}

/// How a command ended, and the error it told.
fn outcome(child: Child) -> (Option<i32>, Value) {
    let output = child.wait_with_output().expect("it ends");
    let error: Value = serde_json::from_slice(&output.stderr).expect("one object");
    (output.status.code(), error["error"].clone())
}

#[test]
fn a_signal_stops_the_arm_and_gives_the_settings_back() {
    for name in ["-INT", "-TERM"] {
        let place = Place::new();
        let child = place.slow_move();
        assert!(signal(name, child.id()));
        let (status, error) = outcome(child);
        assert_eq!((status, &error["kind"]), (Some(130), &json!("interrupted")));
        let message = error["message"].as_str().expect("text");
        assert!(message.contains("the arm stands at x "), "{message}");
        assert_eq!(place.look(&["pose"]), place.look(&["pose"]));
        let queue = place.look(&["queue"]);
        assert_eq!(queue["left_space"], 32);
        let ratios = place.look(&["get", "PTPCommonParams"]);
        let before = json!({"velocity_ratio": 50.0, "acceleration_ratio": 50.0});
        assert_eq!(ratios, before);
    }
}

#[test]
fn signals_again_and_again_end_it_even_when_the_arm_is_deaf() {
    let place = Place::new();
    let mut child = place.slow_move();
    assert!(signal("-STOP", place.served.child.id()));
    while child.try_wait().expect("a child").is_none() {
        signal("-INT", child.id());
    }
    let (status, error) = outcome(child);
    assert_eq!(status, Some(130));
    let message = error["message"].as_str().expect("text");
    assert!(message.contains("not known"), "{message}");
    assert!(signal("-CONT", place.served.child.id()));
}

#[test]
fn what_others_set_going_is_left_alone() {
    let place = Place::new();
    let mut slow = place.slow_move();
    let watch = command()
        .args([
            "--port",
            &place.served.door("tcp"),
            "--json",
            "pose",
            "--watch",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut watch = watch.expect("it starts");
    let mut line = String::new();
    let mut lines = BufReader::new(watch.stdout.take().expect("stdout"));
    lines.read_line(&mut line).expect("a pose");
    assert!(signal("-INT", watch.id()));
    let (status, error) = outcome(watch);
    assert_eq!(
        (status, &error["message"]),
        (Some(130), &json!("interrupted"))
    );
    assert!(
        slow.try_wait().expect("a child").is_none(),
        "the move goes on"
    );
    assert!(signal("-INT", slow.id()));
    assert_eq!(outcome(slow).0, Some(130));
}

#[test]
fn a_move_whose_arm_dies_is_a_port_error() {
    let mut place = Place::new();
    let child = place.slow_move();
    place.served.child.kill().expect("it lives");
    let (status, error) = outcome(child);
    assert_eq!((status, &error["kind"]), (Some(4), &json!("port")));
}
