//! Ctrl-C and SIGTERM while the arm moves: the command ends once the arm stands.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::magician::homed::as_if_homed;
use crate::magician::served::Served;
use crate::magician::{command, run};
use serde_json::{Value, json};

/// Arm at real speed behind a pseudo-terminal, its alarms cleared, with a second endpoint for
/// observation.
struct Place {
    dir: tempfile::TempDir,
    served: Served,
}

impl Place {
    fn new() -> Self {
        Self::answering_after("0")
    }

    /// Creates a place whose arm takes this many milliseconds for an answer.
    fn answering_after(turnaround: &str) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let path = dir.path().join("arm");
        let path = path.to_str().expect("UTF-8");
        let doors = ["--pty", path, "--tcp", "127.0.0.1:0", "--speed", "1"];
        let served = Served::start(&[&doors[..], &["--turnaround", turnaround]].concat(), 2);
        let place = Self { dir, served };
        assert_eq!(
            run(&["--port", &place.port(), "alarms", "--clear"]).status,
            0
        );
        as_if_homed(command(), &place.port());
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

    /// Starts a command, and waits until the second endpoint shows its effect.
    fn busy(&self, arguments: &[&str], look: &[&str]) -> Child {
        let before = self.look(look);
        let child = command()
            .args(["--port", &self.port(), "--json"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let changed = (0..10_000).any(|_| self.look(look) != before);
        assert!(changed, "{arguments:?} changes nothing");
        child
    }

    /// Starts a move that takes minutes, and waits until the arm has left its pose.
    fn slow_move(&self) -> Child {
        self.busy(
            &["move", "220", "80", "50", "--speed-ratio", "1"],
            &["pose"],
        )
    }
}

fn signal(signal: &str, process: u32) -> bool {
    let mut kill = Command::new("kill");
    let kill = kill
        .args([signal, &process.to_string()])
        .stderr(Stdio::null());
    kill.status().is_ok_and(|status| status.success())
}

/// Returns the exit status of a command and its error.
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
    assert!(message.contains("may still be moving"), "{message}");
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

#[test]
fn doctor_drops_what_it_put_into_the_queue() {
    let place = Place::answering_after("100");
    let before = place.look(&["queue"]);
    let child = place.busy(&["doctor", "--yes"], &["queue"]);
    assert!(signal("-INT", child.id()));
    assert_eq!(outcome(child).0, Some(130));
    assert_eq!(place.look(&["queue"]), before);
}

#[test]
fn bench_gives_the_path_speeds_back() {
    let place = Place::new();
    let speeds = ["get", "CPParams"];
    let before = place.look(&speeds);
    for only in ["h2", "h4"] {
        let arguments = [
            "bench",
            "--yes",
            "--only",
            only,
            "--stops",
            "10000",
            "--seconds",
            "600",
        ];
        let child = place.busy(&arguments, &speeds);
        assert!(signal("-INT", child.id()));
        assert_eq!(outcome(child).0, Some(130), "{only}");
        assert_eq!(place.look(&speeds), before, "{only}");
        assert_eq!(place.look(&["queue"])["left_space"], 32, "{only}");
    }
}

#[test]
fn signal_switches_off_the_belt_that_a_shell_started() {
    let place = Place::new();
    let trace = place.dir.path().join("trace.pcapng");
    let trace = trace.to_str().expect("UTF-8");
    let mut child = command()
        .args(["--port", &place.port(), "--trace", trace, "shell"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut stdin = child.stdin.take().expect("piped");
    std::io::Write::write_all(&mut stdin, b"conveyor run 50\n").expect("it reads");
    let mut said = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    said.read_line(&mut line).expect("text");
    assert_eq!(line.trim(), "conveyor 1: running at 50 mm/s");
    assert!(signal("-TERM", child.id()));
    let ended = child.wait().expect("it ends");
    assert_eq!(ended.code(), Some(130));
    drop(stdin);
    let sent = run(&["decode", trace]).out;
    let motors = sent.matches("request  SetEMotor\n").count();
    assert_eq!(motors, 3, "on, and both off: {sent}");
}
