//! Ctrl-C and SIGTERM while the arm moves: the command ends once the arm stands.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::{command, run};
use serde_json::{Value, json};

/// Arm at real speed behind a pseudo-terminal, its alarms cleared, with a second endpoint for
/// observation.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
}

impl Fixture {
    fn new() -> Self {
        Self::answering_after("0")
    }

    /// Creates a place whose arm takes this many milliseconds for an answer.
    fn answering_after(turnaround: &str) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let path = dir.path().join("arm");
        let path = path.to_str().expect("UTF-8");
        let endpoints = ["--pty", path, "--tcp", "127.0.0.1:0", "--speed", "1"];
        let served = Served::start(&[&endpoints[..], &["--turnaround", turnaround]].concat(), 2);
        let fixture = Self { dir, served };
        assert_eq!(
            run(&["--port", &fixture.port(), "alarms", "--clear"]).status,
            0
        );
        mark_homed(command(), &fixture.port());
        fixture
    }

    fn port(&self) -> String {
        let path = self.dir.path().join("arm");
        path.to_str().expect("UTF-8").to_owned()
    }

    fn look(&self, arguments: &[&str]) -> Value {
        let endpoint = self.served.endpoint("tcp");
        run(&[&["--port", &endpoint, "--json"], arguments].concat()).object()
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
fn signal_stops_the_arm_and_restores_settings() {
    for name in ["-INT", "-TERM"] {
        let fixture = Fixture::new();
        let child = fixture.slow_move();
        assert!(signal(name, child.id()));
        let (status, error) = outcome(child);
        assert_eq!((status, &error["kind"]), (Some(130), &json!("interrupted")));
        let message = error["message"].as_str().expect("text");
        assert!(message.contains("the arm stands at x "), "{message}");
        assert_eq!(fixture.look(&["pose"]), fixture.look(&["pose"]));
        let queue = fixture.look(&["queue"]);
        assert_eq!(queue["left_space"], 32);
        let ratios = fixture.look(&["get", "PTPCommonParams"]);
        let before = json!({"velocity_ratio": 50.0, "acceleration_ratio": 50.0});
        assert_eq!(ratios, before);
    }
}

#[test]
fn repeated_signals_end_the_command_even_if_the_arm_is_silent() {
    let fixture = Fixture::new();
    let mut child = fixture.slow_move();
    assert!(signal("-STOP", fixture.served.child.id()));
    while child.try_wait().expect("a child").is_none() {
        signal("-INT", child.id());
    }
    let (status, error) = outcome(child);
    assert_eq!(status, Some(130));
    let message = error["message"].as_str().expect("text");
    assert!(message.contains("may still be moving"), "{message}");
    assert!(signal("-CONT", fixture.served.child.id()));
}

#[test]
fn motions_of_other_programs_continue() {
    let fixture = Fixture::new();
    let mut slow = fixture.slow_move();
    let watch = command()
        .args([
            "--port",
            &fixture.served.endpoint("tcp"),
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
fn move_with_a_lost_arm_is_a_port_error() {
    let mut fixture = Fixture::new();
    let child = fixture.slow_move();
    fixture.served.child.kill().expect("it lives");
    let (status, error) = outcome(child);
    assert_eq!((status, &error["kind"]), (Some(4), &json!("port")));
}

#[test]
fn doctor_clears_its_queued_commands() {
    let fixture = Fixture::answering_after("100");
    let before = fixture.look(&["queue"]);
    let child = fixture.busy(&["doctor", "--yes"], &["queue"]);
    assert!(signal("-INT", child.id()));
    assert_eq!(outcome(child).0, Some(130));
    assert_eq!(fixture.look(&["queue"]), before);
}

#[test]
fn bench_restores_the_path_speeds() {
    let fixture = Fixture::new();
    let speeds = ["get", "CPParams"];
    let before = fixture.look(&speeds);
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
        let child = fixture.busy(&arguments, &speeds);
        assert!(signal("-INT", child.id()));
        assert_eq!(outcome(child).0, Some(130), "{only}");
        assert_eq!(fixture.look(&speeds), before, "{only}");
        assert_eq!(fixture.look(&["queue"])["left_space"], 32, "{only}");
    }
}

#[test]
fn signal_switches_off_the_belt_that_a_shell_started() {
    let fixture = Fixture::new();
    let trace = fixture.dir.path().join("trace.pcapng");
    let trace = trace.to_str().expect("UTF-8");
    let mut child = command()
        .args(["--port", &fixture.port(), "--trace", trace, "shell"])
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
