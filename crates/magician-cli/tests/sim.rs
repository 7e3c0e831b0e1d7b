//! `magician sim` as other programs use it: a process with doors.
#![cfg(unix)]

mod magician;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};

use magician::{command, run};
use serde_json::json;

/// A virtual arm in a process of its own.
struct Served {
    child: Child,
    stdout: BufReader<ChildStdout>,
    /// What stderr said before it was ready.
    doors: Vec<String>,
}

impl Served {
    fn start(arguments: &[&str], doors: usize) -> Self {
        let mut child = command()
            .arg("sim")
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("stdout"));
        let mut line = String::new();
        stdout.read_line(&mut line).expect("a line");
        assert_eq!(line, "ready\n");
        let stderr = child.stderr.take().expect("stderr");
        let mut lines = BufReader::new(stderr)
            .lines()
            .map(|line| line.expect("UTF-8"));
        let doors = lines.by_ref().take(doors + 1).collect();
        // Somebody has to read on, or the arm would wait for us.
        std::thread::spawn(move || lines.for_each(drop));
        Self {
            child,
            stdout,
            doors,
        }
    }

    /// The address after `serving udp:`.
    fn door(&self, scheme: &str) -> String {
        let prefix = format!("serving {scheme}:");
        let found = self
            .doors
            .iter()
            .find_map(|line| line.strip_prefix(&prefix));
        format!(
            "{scheme}:{}",
            found.unwrap_or_else(|| panic!("{:?}", self.doors))
        )
    }

    /// Ends it with a signal; its status and the rest of its stdout.
    fn end(mut self, signal: &str) -> (ExitStatus, String) {
        let kill = Command::new("kill")
            .args([signal, &self.child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        let status = self.child.wait().expect("it ends");
        let mut rest = String::new();
        self.stdout.read_to_string(&mut rest).expect("UTF-8");
        (status, rest)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn every_door_leads_to_the_same_arm() {
    let dir = tempfile::tempdir().expect("directory");
    let link = dir.path().join("arm");
    let path = link.to_str().expect("UTF-8");
    let arguments = [
        "--pty",
        path,
        "--udp",
        "127.0.0.1:0",
        "--tcp",
        "127.0.0.1:0",
        "--speed",
        "max",
    ];
    let served = Served::start(&arguments, 3);
    let (udp, tcp) = (served.door("udp"), served.door("tcp"));
    assert_eq!(run(&["--port", path, "move", "220", "40", "30"]).status, 0);
    for port in [path, &udp, &tcp] {
        let pose = run(&["--port", port, "pose", "--json"]).object();
        assert_eq!(
            (&pose["x"], &pose["y"], &pose["z"]),
            (&json!(220.0), &json!(40.0), &json!(30.0))
        );
    }
    let (status, rest) = served.end("-TERM");
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));
    assert!(!link.exists() && !Path::new(&link).is_symlink());
}

#[test]
fn an_interrupt_ends_it_with_130() {
    let served = Served::start(&["--udp", "127.0.0.1:0"], 1);
    let (status, rest) = served.end("-INT");
    assert_eq!((status.code(), rest.as_str()), (Some(130), ""));
}

#[test]
fn the_trace_holds_what_passed() {
    let dir = tempfile::tempdir().expect("directory");
    let trace = dir.path().join("trace.pcapng");
    let path = trace.to_str().expect("UTF-8");
    let served = Served::start(&["--tcp", "127.0.0.1:0", "--trace", path], 1);
    let port = served.door("tcp");
    assert_eq!(run(&["--port", &port, "alarms", "--clear"]).status, 0);
    served.end("-TERM");
    let decoded = run(&["decode", "--json", path]);
    assert_eq!(decoded.status, 0, "{decoded:?}");
    let objects = decoded.objects();
    let told = |command: &str, direction: &str| {
        objects
            .iter()
            .any(|object| object["command"] == command && object["direction"] == direction)
    };
    assert!(told("ClearAllAlarmsState", "request") && told("ClearAllAlarmsState", "reply"));
    assert!(
        objects
            .iter()
            .all(|object| object["time"].is_u64() && object["ok"] == true)
    );
}

#[test]
fn a_door_that_cannot_open_is_an_error_and_nothing_is_left() {
    let dir = tempfile::tempdir().expect("directory");
    let taken = dir.path().join("taken");
    std::fs::write(&taken, "mine").expect("written");
    let path = taken.to_str().expect("UTF-8");
    let occupied = run(&["sim", "--pty", path, "--json"]);
    assert_eq!((occupied.status, occupied.out.as_str()), (4, ""));
    assert_eq!(occupied.error()["kind"], "port");
    assert_eq!(
        std::fs::read_to_string(&taken).expect("still there"),
        "mine"
    );
    let address = run(&["sim", "--tcp", "nowhere", "--json"]);
    assert_eq!(
        (address.status, address.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
    let profile = run(&["sim", "--udp", "127.0.0.1:0", "--profile", path, "--json"]);
    assert_eq!(
        (profile.status, profile.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
}

#[test]
fn the_built_in_profile_can_be_printed_and_used() {
    let dir = tempfile::tempdir().expect("directory");
    let file = dir.path().join("profile.toml");
    let text = run(&["sim", "--profile", "-"])
        .out
        .replace("Dobot 2.0", "Somebody");
    std::fs::write(&file, text).expect("written");
    let path = file.to_str().expect("UTF-8");
    let served = Served::start(&["--tcp", "127.0.0.1:0", "--profile", path], 1);
    let name = run(&["--port", &served.door("tcp"), "get", "DeviceName", "--json"]).object();
    assert_eq!(name, json!({"device_name": "Somebody"}));
}

/// A move that takes minutes, under way: seen to have left the pose it began at.
fn slow_move(port: &str) -> Child {
    let before = run(&["--port", port, "pose", "--json"]).object();
    let child = command()
        .args([
            "--port",
            port,
            "--json",
            "move",
            "220",
            "80",
            "50",
            "--speed-ratio",
            "1",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let moved = (0..10_000).any(|_| run(&["--port", port, "pose", "--json"]).object() != before);
    assert!(moved, "the arm does not begin to move");
    child
}

/// How a command ended, and the kind of its error.
fn outcome(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("it ends");
    let error: serde_json::Value = serde_json::from_slice(&output.stderr).expect("one object");
    (
        output.status.code(),
        error["error"]["kind"]
            .as_str()
            .unwrap_or_default()
            .to_owned(),
    )
}

#[test]
fn an_interrupt_stops_the_arm_and_gives_the_settings_back() {
    let served = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    let port = served.door("tcp");
    assert_eq!(run(&["--port", &port, "alarms", "--clear"]).status, 0);
    let child = slow_move(&port);
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("kill runs").success());
    assert_eq!(outcome(child), (Some(130), "interrupted".to_owned()));
    let pose = || run(&["--port", &port, "pose", "--json"]).object();
    assert_eq!(pose(), pose(), "the arm stands");
    let queue = run(&["--port", &port, "queue", "--json"]).object();
    assert_eq!(queue["left_space"], 32);
    let ratios = run(&["--port", &port, "get", "PTPCommonParams", "--json"]).object();
    assert_eq!(
        ratios,
        json!({"velocity_ratio": 50.0, "acceleration_ratio": 50.0})
    );
}

#[test]
fn a_move_whose_arm_dies_is_a_port_error() {
    let mut served = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    let port = served.door("tcp");
    let child = slow_move(&port);
    served.child.kill().expect("it lives");
    assert_eq!(outcome(child), (Some(4), "port".to_owned()));
}
