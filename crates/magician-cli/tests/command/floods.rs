//! Frames of other programs are reported without flooding the log.
#![cfg(unix)]

use std::io::Write;
use std::net::TcpStream;
use std::process::{Command, Stdio};

use crate::magician::run;
use crate::magician::served::Served;

/// Frame with a wrong checksum.
const DAMAGED: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF7];
const COUNT: usize = 20_000;
/// Largest number of log lines that they may cause, on a slow computer too.
const LINES: usize = 60;

/// Sends damaged frames, then a valid one whose answer shows that all were read.
fn floods(served: &Served) {
    let endpoint = served.endpoint("tcp");
    let address = endpoint.strip_prefix("tcp:").expect("TCP");
    let mut stream = TcpStream::connect(address).expect("it listens");
    stream.write_all(&DAMAGED.repeat(COUNT)).expect("written");
    drop(stream);
    assert_eq!(run(&["--port", &endpoint, "pose"]).status, 0);
}

#[test]
fn a_flood_of_damaged_frames_is_a_few_lines_of_a_virtual_arms_log() {
    let served = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    floods(&served);
    let log = served.log();
    let damaged = log.iter().filter(|line| line.contains("damaged frame"));
    assert!(damaged.count() >= 10, "{log:?}");
    assert!(log.len() < LINES, "{} lines", log.len());
    assert!(
        log.iter()
            .any(|line| line.contains("more like it in the last")),
        "{log:?}"
    );
}

#[test]
fn a_flood_of_damaged_frames_is_a_few_lines_of_a_proxys_log() {
    for (options, more) in [
        (&[][..], "more in the last"),
        (&["--json"], r#""event":"more""#),
    ] {
        let first = if options.is_empty() { 2 } else { 0 };
        let arm = Served::start(&["--tcp", "127.0.0.1:0"], 1);
        let at = arm.endpoint("tcp");
        let arguments = [&["--port", &at, "--tcp", "127.0.0.1:0"], options].concat();
        let mut served = Served::verb("proxy", &arguments, first);
        if first == 0 {
            let line = served.until(|line| line.contains("serving"));
            let object: serde_json::Value = serde_json::from_str(&line).expect("JSON");
            let endpoint = object["endpoint"].as_str().expect("text");
            served.endpoints = vec![format!("serving {endpoint}")];
        }
        floods(&served);
        let log = served.log();
        assert!(log.iter().any(|line| line.contains("noise")), "{log:?}");
        assert!(log.iter().any(|line| line.contains(more)), "{log:?}");
        let noise = log.iter().filter(|line| line.contains("noise")).count();
        assert!(noise < LINES, "{noise} lines");
    }
}

#[test]
fn proxy_reachable_from_other_computers_warns() {
    let arm = Served::start(&["--tcp", "127.0.0.1:0"], 1);
    let at = arm.endpoint("tcp");
    let exposed = Served::verb("proxy", &["--port", &at, "--tcp", "0.0.0.0:0"], 3);
    let warning = exposed.endpoints.last().expect("three lines");
    for part in ["warning: every computer that reaches tcp:0.0.0.0:", &at] {
        assert!(warning.contains(part), "{warning}");
    }
    let quiet = Served::verb("proxy", &["--port", &at, "--udp", "127.0.0.1:0"], 2);
    assert!(
        !quiet
            .log()
            .iter()
            .any(|line| line.contains("every computer"))
    );
}

#[test]
fn virtual_arm_reachable_from_other_computers_warns() {
    let arm = Served::start(&["--tcp", "0.0.0.0:0"], 2);
    let note = arm.endpoints.last().expect("three lines");
    assert!(
        note.contains("note: every computer that reaches tcp:0.0.0.0:"),
        "{note}"
    );
}

/// Returns a path for a pseudo-terminal.
fn path(folder: &tempfile::TempDir) -> String {
    folder
        .path()
        .join("arm")
        .to_str()
        .expect("UTF-8")
        .to_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn path_of_a_running_virtual_arm_is_not_replaced() {
    let folder = tempfile::tempdir().expect("a directory");
    let path = path(&folder);
    let mut first = Served::start(&["--pty", &path], 1);
    let process = first.child.id().to_string();
    for second in [&["sim"][..], &["proxy", "--port", "sim"]] {
        let refused = run(&[second, &["--pty", &path]].concat());
        assert_eq!(refused.status, 4, "{refused:?}");
        assert!(refused.err.contains(&process), "{refused:?}");
    }
    assert_eq!(run(&["--port", &path, "pose"]).status, 0);
    // A killed server leaves a dangling link.
    first.child.kill().expect("killed");
    first.child.wait().expect("it ends");
    assert!(std::fs::symlink_metadata(&path).is_ok());
    let _second = Served::start(&["--pty", &path], 1);
    assert_eq!(run(&["--port", &path, "pose"]).status, 0);
}

#[cfg(target_os = "linux")]
#[test]
fn program_at_a_virtual_arm_is_named_in_its_log() {
    let folder = tempfile::tempdir().expect("a directory");
    let path = path(&folder);
    let served = Served::start(&["--pty", &path], 1);
    let mut user = Command::new(env!("CARGO_BIN_EXE_magician"))
        .args(["--port", &path, "shell"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    writeln!(user.stdin.as_mut().expect("stdin"), "pose").expect("written");
    let mut line = String::new();
    let out = user.stdout.take().expect("stdout");
    std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut line).expect("a line");
    let refused = run(&["--port", &path, "pose"]);
    drop(user.stdin.take());
    let id = user.id();
    user.wait().expect("it ends");
    assert_eq!(refused.status, 4, "{refused:?}");
    assert!(
        refused.err.contains(&format!("(process {id})")),
        "{refused:?}"
    );
    let arm = format!("(process {})", served.child.id());
    assert!(!refused.err.contains(&arm), "{refused:?}");
}
