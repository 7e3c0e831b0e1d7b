//! Job that is paused, resumed and stopped, by JSON lines on stdin and by keys.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::magician::drawing::{Fixture, PAPER, last};
use crate::magician::terminal::Terminal;
use rustix::termios::{LocalModes, tcgetattr};
use serde_json::{Value, json};

/// Running job with its output and input.
struct Talk {
    child: Child,
    lines: BufReader<ChildStdout>,
}

impl Talk {
    fn with(mut command: Command) -> Self {
        command.arg("--json");
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
        let lines = BufReader::new(child.stdout.take().expect("a pipe"));
        Self { child, lines }
    }

    fn says(&mut self, line: &str) {
        let stdin = self.child.stdin.as_mut().expect("a pipe");
        writeln!(stdin, "{line}").expect("it reads");
    }

    fn next(&mut self) -> Value {
        let mut line = String::new();
        self.lines.read_line(&mut line).expect("a line");
        serde_json::from_str(&line).unwrap_or_else(|_| panic!("{line:?}"))
    }

    /// Waits for the next event with this name.
    fn until(&mut self, event: &str) -> Value {
        loop {
            let next = self.next();
            if next["event"] == event {
                return next;
            }
            let name = next["event"].as_str();
            assert!(name.is_some_and(|name| name != "paused"), "{next}");
        }
    }
}

#[test]
fn json_lines_pause_and_resume_a_job() {
    let fixture = Fixture::homed("5");
    let mut talk = Talk::with(fixture.draw(&[]));
    while talk.until("progress")["step"].as_u64() < Some(3) {}
    talk.says("{\"do\":\"pause\"}");
    let paused = talk.until("paused");
    assert_eq!(
        paused,
        json!({"event": "paused", "part": null, "reason": "person"})
    );
    assert_eq!(fixture.number("queue", "left_space"), 32.0);
    let height = fixture.number("pose", "z");
    assert!(height > PAPER + 9.0, "{height}");
    // The arm may be moved meanwhile; an invalid line is returned.
    last(&fixture.run(&["move", "10", "0", "5", "--relative"]));
    talk.says("go on");
    let ignored = talk.until("ignored");
    assert_eq!(ignored, json!({"event": "ignored", "line": "go on"}));
    assert_eq!(fixture.number("queue", "left_space"), 32.0);
    talk.says("{\"do\":\"resume\"}");
    assert_eq!(talk.until("resumed"), json!({"event": "resumed"}));
    let done = loop {
        let next = talk.next();
        match next["event"].as_str() {
            Some(event) => assert_eq!(event, "progress"),
            None => break next,
        }
    };
    assert_eq!(done["end"]["pen"], "up", "{done}");
    assert!(talk.child.wait().expect("it ends").success());
}

#[test]
fn json_line_stops_a_paused_job() {
    let fixture = Fixture::homed("5");
    for paused in [false, true] {
        let mut talk = Talk::with(fixture.draw(&[]));
        while talk.until("progress")["step"].as_u64() < Some(3) {}
        if paused {
            talk.says("{\"do\":\"pause\"}");
            talk.until("paused");
        }
        talk.says("{\"do\":\"stop\"}");
        let status = talk.child.wait().expect("it ends");
        assert_eq!(status.code(), Some(130));
        assert!(fixture.number("pose", "z") > PAPER + 9.0);
    }
    // A stopped run can be resumed.
    let done = fixture
        .draw(&["--resume", "--json"])
        .output()
        .expect("it runs");
    assert!(done.status.success(), "{done:?}");
}

#[test]
fn keys_pause_resume_and_stop_a_job() {
    let fixture = Fixture::homed("5");
    let mut terminal = Terminal::running(fixture.draw(&[]));
    let canonical = |terminal: &Terminal| {
        let modes = tcgetattr(&terminal.line).expect("a terminal").local_modes;
        modes.contains(LocalModes::ICANON | LocalModes::ECHO)
    };
    terminal.until_step(3);
    assert!(!canonical(&terminal));
    terminal.types("p");
    terminal.until_seen("paused: p resumes, space stops");
    assert!(fixture.number("pose", "z") > PAPER + 9.0);
    terminal.types("p");
    terminal.until_seen("left");
    terminal.types(" ");
    // The arm may be on its way to the next line, with the pen up already.
    terminal.until_seen("--resume continues with step");
    let status = terminal.child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    assert!(fixture.number("pose", "z") > PAPER + 9.0);
    assert!(canonical(&terminal));
}
