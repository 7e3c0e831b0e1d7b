//! Jobs that wait for the user between the parts of a drawing.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::magician::command;
use crate::magician::drawing::Fixture;
use crate::magician::terminal::Terminal;
use serde_json::{Value, json};

const TWO: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='30mm' height='30mm' viewBox='0 0 30 30'>\
    <path d='M5 5H25' stroke='red'/><path d='M5 15H25' stroke='blue'/></svg>";

/// Returns the command that draws a file in parts by colour.
fn in_colors(file: &str) -> Command {
    let mut magician = command();
    magician.args(["draw", file, "--surface", "-60", "--parts", "color"]);
    magician
}

struct Talk {
    child: Child,
    lines: BufReader<ChildStdout>,
}

impl Talk {
    fn with(mut command: Command) -> Self {
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
        let lines = BufReader::new(child.stdout.take().expect("a pipe"));
        Self { child, lines }
    }

    fn until(&mut self, event: &str) -> Value {
        loop {
            let mut line = String::new();
            self.lines.read_line(&mut line).expect("a line");
            let next: Value = serde_json::from_str(&line).unwrap_or_else(|_| panic!("{line:?}"));
            if next["event"] == event {
                return next;
            }
            assert!(next["event"].is_string(), "{next}");
        }
    }
}

fn file(name: &str) -> String {
    let path = std::env::temp_dir().join(format!("waits-{}-{name}.svg", std::process::id()));
    std::fs::write(&path, TWO).expect("it is written");
    path.display().to_string()
}

fn draw(fixture: &Fixture, file: &str, more: &[&str]) -> Command {
    let mut command = fixture.command(&["draw", file, "--surface", "-60", "--parts", "color"]);
    command.args(more);
    command
}

#[test]
fn program_reading_the_events_continues_with_the_next_part() {
    let fixture = Fixture::homed("5");
    let file = file("json");
    let mut talk = Talk::with(draw(&fixture, &file, &["--json"]));
    let paused = talk.until("paused");
    assert_eq!(
        paused,
        json!({"event": "paused", "part": 2, "reason": "part"})
    );
    assert_eq!(fixture.number("queue", "left_space"), 32.0);
    let before = fixture.number("pose", "x");
    assert_eq!(fixture.number("pose", "x"), before, "nothing moves");
    let stdin = talk.child.stdin.as_mut().expect("a pipe");
    writeln!(stdin, "{{\"do\":\"resume\"}}").expect("it reads");
    assert_eq!(talk.until("resumed"), json!({"event": "resumed"}));
    assert!(talk.child.wait().expect("it ends").success());
}

#[test]
fn unanswerable_pause_stops_the_job() {
    let fixture = Fixture::homed("5");
    let file = file("end");
    let mut talk = Talk::with(draw(&fixture, &file, &["--json"]));
    drop(talk.child.stdin.take());
    talk.until("paused");
    assert_eq!(talk.child.wait().expect("it ends").code(), Some(130));
    // The job resumes where it was stopped, and waits there again.
    let mut talk = Talk::with(draw(&fixture, &file, &["--json", "--resume"]));
    talk.until("paused");
    let stdin = talk.child.stdin.as_mut().expect("a pipe");
    writeln!(stdin, "{{\"do\":\"resume\"}}").expect("it reads");
    assert!(talk.child.wait().expect("it ends").success());
}

#[test]
fn user_is_told_which_pen_to_mount() {
    let fixture = Fixture::homed("5");
    let file = file("keys");
    let mut terminal = Terminal::running(draw(&fixture, &file, &[]));
    terminal.until_both_seen([
        "mount the pen for part 2, #0000ff",
        "paused: p resumes, space stops",
    ]);
    terminal.types("p");
    terminal.until_seen("done in");
}

#[test]
fn job_with_unanswerable_pauses_does_not_start() {
    let file = file("nobody");
    let run = |more: &[&str]| {
        let mut magician = in_colors(&file);
        magician.args(["--port", "sim"]);
        magician.args(more).stdin(Stdio::null());
        magician.output().expect("it runs")
    };
    let refused = run(&[]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        said.contains("the job would pause at step") && said.contains("--no-pause"),
        "{said}"
    );
    assert!(run(&["--no-pause"]).status.success());
    assert!(run(&["--only", "blue"]).status.success(), "one part alone");
}

#[test]
fn pen_file_is_read_and_its_errors_have_positions() {
    let file = file("pens");
    let pens = format!("{file}.toml");
    let run = |text: &str| {
        std::fs::write(&pens, text).expect("it is written");
        let mut magician = in_colors(&file);
        magician.args(["--check", "--json"]);
        magician.args(["--pens", &pens]).output().expect("it runs")
    };
    let good = run("[[pen]]\nmatch = 'red'\npasses = 3\n");
    let report: Value = serde_json::from_slice(&good.stdout).expect("JSON");
    assert_eq!(
        report["drawn_mm"].as_f64().map(f64::round),
        Some(80.0),
        "{report}"
    );
    let wrong = run("[[pen]]\nmatch = 'red'\nwidth = 3\n");
    let said = String::from_utf8_lossy(&wrong.stderr).into_owned()
        + &String::from_utf8_lossy(&wrong.stdout);
    assert!(
        said.contains("line 3, column 1: unknown field `width`"),
        "{said}"
    );
    assert_eq!(
        wrong.status.code(),
        Some(3),
        "the file is wrong, not the command line"
    );
}

#[test]
fn the_parts_of_a_drawing_are_listed() {
    let file = file("list");
    let mut magician = command();
    let listed = magician.args([
        "draw",
        &file,
        "--surface",
        "-60",
        "--parts",
        "color",
        "--list-parts",
        "--json",
    ]);
    let listed = listed.output().expect("it runs");
    let listed: Value = serde_json::from_slice(&listed.stdout).expect("JSON");
    let parts = listed["parts"].as_array().expect("a list");
    assert_eq!(parts.len(), 2);
    assert_eq!(parts[1]["color"], "#0000ff");
    assert_eq!(parts[1]["n"], 2);
}
