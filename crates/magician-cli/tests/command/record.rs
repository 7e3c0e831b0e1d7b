//! `magician record`: an arm moved by another program, recorded as readings and as a program.
#![cfg(unix)]

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::{Run, command, run};
use serde_json::Value;

/// Arm at real speed in another process, its alarms cleared, and a directory.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
}

/// Running recording.
struct Recording {
    child: Child,
}

impl Fixture {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let served = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "1"], 1);
        let fixture = Self { dir, served };
        assert_eq!(fixture.arm(&["alarms", "--clear"]).status, 0);
        mark_homed(command(), &fixture.served.endpoint("tcp"));
        fixture
    }

    fn file(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap_or_default()
    }

    fn arm(&self, arguments: &[&str]) -> Run {
        let endpoint = self.served.endpoint("tcp");
        run(&[&["--port", &endpoint], arguments].concat())
    }

    fn moves(&self, to: &[&str]) {
        let moved = self.arm(&[&["move"], to].concat());
        assert_eq!(moved.status, 0, "{}", moved.err);
    }

    fn command(&self, name: &str, more: &[&str]) -> Command {
        let mut command = command();
        command
            .args(["--json", "--port", &self.served.endpoint("tcp"), "record"])
            .arg(self.file(name))
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Starts a recording, and waits until a text is in the file.
    fn record(&self, name: &str, wanted: &str) -> Recording {
        let child = self.command(name, &[]).spawn().expect("it starts");
        let recording = Recording { child };
        self.until(name, wanted);
        recording
    }

    /// Waits until the file contains a text.
    fn until(&self, name: &str, wanted: &str) {
        // A deadline, so that the test fails instead of hanging.
        let deadline = Instant::now() + Duration::from_secs(120);
        while !String::from_utf8_lossy(&std::fs::read(self.file(name)).unwrap_or_default())
            .contains(wanted)
        {
            assert!(Instant::now() < deadline, "{name}: {}", self.text(name));
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Recording {
    /// Sends a signal and waits for the end.
    fn end(self, signal: &str) -> (Option<i32>, String, String) {
        let kill = Command::new("kill")
            .args([signal, &self.child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        self.ended()
    }

    fn ended(self) -> (Option<i32>, String, String) {
        let output = self.child.wait_with_output().expect("it ends");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    }
}

/// Returns the rows of a table as cells.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines()
        .skip(1)
        .map(|line| line.split(',').collect())
        .collect()
}

#[test]
fn a_table_has_every_reading_from_beginning_to_end() {
    let fixture = Fixture::new();
    let recording = fixture.record("a.csv", "259.");
    fixture.moves(&["230", "40", "60", "--linear"]);
    let (status, out, err) = recording.end("-INT");
    assert_eq!(status, Some(0), "{err}");
    let summary: Value = serde_json::from_str(&out).expect("an object");
    let text = fixture.text("a.csv");
    assert!(
        text.starts_with("time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms\n"),
        "{text}"
    );
    let rows = rows(&text);
    assert_eq!(summary["readings"], rows.len());
    assert_eq!(summary["format"], "csv");
    let number = |row: &[&str], at: usize| row[at].parse::<f64>().expect("a number");
    assert!(
        rows.windows(2)
            .all(|pair| number(&pair[0], 1) <= number(&pair[1], 1))
    );
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    assert!((number(first, 2) - 259.104).abs() < 0.001, "{first:?}");
    assert_eq!([2, 3, 4].map(|at| number(last, at)), [230.0, 40.0, 60.0]);
    assert_eq!((last[10], last[11], last[12]), ("2", "32", ""));
    // Positions on the way were recorded, not only the ends.
    let between = rows
        .iter()
        .filter(|row| (235.0..255.0).contains(&number(row, 2)));
    assert!(between.count() > 3);
    let way = [230.0 - 259.104, 40.0, 60.0 + 8.485_f64];
    let way = way.iter().map(|part| part * part).sum::<f64>().sqrt();
    let length = summary["length"].as_f64().expect("a number");
    assert!((length - way).abs() < 0.1, "{length} {way}");
}

#[test]
fn a_motion_is_recorded_as_a_program_that_repeats_it() {
    let fixture = Fixture::new();
    let recording = fixture.record("led.plan.json", "\"move\"");
    // Joints that move together lead the tool along a curve; J4 does not turn, as when the arm is
    // led by hand.
    fixture.moves(&["20", "40", "30", "0", "--joints"]);
    fixture.moves(&["-20", "30", "40", "0", "--joints"]);
    let (status, out, err) = recording.end("-INT");
    assert_eq!(status, Some(0), "{err}");
    let summary: Value = serde_json::from_str(&out).expect("an object");
    let text = fixture.text("led.plan.json");
    let plan: Value = serde_json::from_str(&text).expect("a plan");
    let steps = plan["steps"].as_array().expect("steps");
    assert_eq!(summary["steps"], steps.len());
    assert_eq!(
        (&plan["title"], &plan["tool"]),
        (&Value::from("led"), &Value::from("suction"))
    );
    let path: Vec<_> = steps
        .iter()
        .filter_map(|step| step["path"].as_array())
        .collect();
    assert!((3..40).contains(&path.len()), "{text}");

    // Another arm that runs the file ends at the same place.
    let there = fixture.arm(&["--json", "pose"]).object();
    let file = fixture.file("led.plan.json");
    let file = file.to_str().expect("UTF-8");
    let endpoint = fixture.served.endpoint("tcp");
    fixture.moves(&["220", "0", "50", "0"]);
    let ran = run(&[
        "--port",
        &endpoint,
        "run",
        file,
        "--record",
        fixture.file("r.csv").to_str().expect("UTF-8"),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let again = fixture.arm(&["--json", "pose"]).object();
    for axis in ["x", "y", "z"] {
        let [a, b] = [&there, &again].map(|pose| pose[axis].as_f64().expect("a number"));
        assert!((a - b).abs() < 0.01, "{axis}: {a} {b}");
    }
    // A run is recorded in the same format, with its steps.
    let text = fixture.text("r.csv");
    assert!(
        text.starts_with("time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms,step\n"),
        "{text}"
    );
    let rows = rows(&text);
    let last = rows.last().expect("a row");
    assert_eq!(last[13], steps.len().to_string());
}

#[test]
fn tool_set_by_another_program_is_no_motion() {
    let fixture = Fixture::new();
    let tells = |bias: &str| {
        let told = ["set", "EndEffectorParams", bias, "y_bias=0", "z_bias=0"];
        assert_eq!(fixture.arm(&told).status, 0);
    };
    // Set before any motion, it is the program's tool; set later, the program keeps the earlier
    // tool.
    let recording = fixture.record("told.plan.json", "\"move\"");
    tells("x_bias=61");
    fixture.moves(&["240", "30", "20", "0"]);
    let there = fixture.arm(&["--json", "pose"]).object();
    tells("x_bias=0");
    fixture.moves(&["200", "30", "20", "0"]);
    tells("x_bias=61");
    fixture.moves(&["240", "-30", "20", "0"]);
    let (status, out, err) = recording.end("-INT");
    assert_eq!(status, Some(0), "{err}");
    let plan: Value = serde_json::from_str(&fixture.text("told.plan.json")).expect("a plan");
    assert_eq!(plan["tool"], "pen");
    let steps = plan["steps"].as_array().expect("steps");
    let ends: Vec<_> = steps
        .iter()
        .filter_map(|step| step["path"].as_array().or(step["move"].as_array()))
        .map(|end| [0, 1, 2].map(|axis| end[axis].as_f64().expect("a number")))
        .collect();
    let near = |x: f64, y: f64| {
        let far = |end: &[f64; 3]| (end[0] - x).hypot(end[1] - y);
        ends.iter().map(far).fold(f64::INFINITY, f64::min) < 0.7
    };
    assert!(near(240.0, 30.0) && near(240.0, -30.0), "{ends:?}");
    assert!(there["x"].as_f64().is_some_and(|x| (x - 240.0).abs() < 0.1));
    // From the home position (260.4 mm with the pen), without a jump of 61 mm.
    let summary: Value = serde_json::from_str(&out).expect("an object");
    let length = summary["length"].as_f64().expect("a number");
    assert!((125.0..165.0).contains(&length), "{length} {ends:?}");
}

#[test]
fn killed_recording_keeps_its_file_and_existing_files_are_not_replaced() {
    let fixture = Fixture::new();
    for (name, wanted) in [
        ("a.jsonl", "\"left_space\":32"),
        ("a.mcap", "position"),
        ("a.csv", "259."),
    ] {
        let recording = fixture.record(name, wanted);
        let (status, ..) = recording.end("-KILL");
        assert_eq!(status, None);
        let size = std::fs::metadata(fixture.file(name)).expect("a file").len();
        let refused = fixture
            .command(name, &["--for", "0.1"])
            .output()
            .expect("it runs");
        assert_eq!(refused.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&refused.stderr).contains("already exists"));
        assert_eq!(
            std::fs::metadata(fixture.file(name)).expect("a file").len(),
            size
        );
        let replaced = fixture.command(name, &["--for", "0.1", "--yes"]).output();
        assert_eq!(replaced.expect("it runs").status.code(), Some(0));
    }
    for line in fixture.text("a.jsonl").lines() {
        let row: Value = serde_json::from_str(line).expect("an object");
        assert_eq!(row["index"], 0, "{row}");
    }
    // Topics and schemas are the same as in a virtual arm's own recording.
    let bytes = std::fs::read(fixture.file("a.mcap")).expect("a file");
    let text = String::from_utf8_lossy(&bytes);
    for wanted in [
        "/pose",
        "/joints",
        "/queue",
        "/alarms",
        "foxglove.PoseInFrame",
        "magician.Queue.v1",
    ] {
        assert!(text.contains(wanted), "{wanted}");
    }
}

#[test]
fn broken_line_ends_the_recording_and_keeps_its_rows() {
    let fixture = Fixture::new();
    let recording = fixture.record("a.jsonl", "\"left_space\":32");
    let Fixture { dir, served } = fixture;
    served.end("-TERM");
    let (status, out, err) = recording.ended();
    assert_eq!((status, out.as_str()), (Some(4), ""), "{err}");
    assert!(err.contains("\"kind\":\"port\""), "{err}");
    let text = std::fs::read_to_string(dir.path().join("a.jsonl")).expect("a file");
    assert!(text.contains("\"event\":\"the line broke"), "{text}");
}

#[test]
fn unsupported_recording_is_refused_before_connecting() {
    for (file, more, part) in [
        ("a.txt", &[][..], ".mcap, .csv or .jsonl"),
        ("a", &[], "does not end in a format to record"),
        ("a.csv", &["--rate", "0"], "0.01 to 1000"),
        ("a.csv", &["--for", "0"], "seconds above 0"),
        ("a.plan.json", &["--tolerance", "0"], "0.01 to 100"),
    ] {
        let ran = run(&[&["record", file], more].concat());
        assert_eq!(ran.status, 2, "{file} {more:?}: {}", ran.err);
        assert!(ran.err.contains(part), "{file} {more:?}: {}", ran.err);
    }
    let nowhere = run(&[
        "--port",
        "sim",
        "record",
        "/nowhere/at/all.csv",
        "--for",
        "1",
    ]);
    assert_eq!(nowhere.status, 3, "{}", nowhere.err);
}

#[test]
fn residue_at_rest_matches_the_recorded_file() {
    let fixture = Fixture::new();
    for name in ["a.csv", "a.jsonl", "a.mcap"] {
        let more = ["--law", "--for", "0.5"];
        let child = fixture.command(name, &more).spawn().expect("it starts");
        let (status, out, err) = Recording { child }.ended();
        assert_eq!(status, Some(0), "{err}");
        let summary: Value = serde_json::from_str(&out).expect("an object");
        assert_eq!(summary["law"]["basis"], "readings");
        let untold = &summary["law"]["not_told"];
        assert_eq!(
            untold[0]["why"], "the arm was at rest throughout",
            "{summary}"
        );
        let file = fixture.file(name);
        let later = run(&["replay", "--law", "--json", file.to_str().expect("UTF-8")]);
        assert_eq!(later.object(), summary["law"]);
    }
    let program = run(&["record", "a.plan.json", "--law", "--port", "sim"]);
    assert_eq!(program.status, 2, "{program:?}");
    assert!(
        program.err.contains("--law needs readings"),
        "{}",
        program.err
    );
}

#[test]
fn watch_records_until_the_signal() {
    let fixture = Fixture::new();
    let watch = |name: &str| {
        let mut command = command();
        command
            .args([
                "--json",
                "--port",
                &fixture.served.endpoint("tcp"),
                "watch",
                "--law",
                "--record",
            ])
            .arg(fixture.file(name))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    };
    let child = watch("w.csv").spawn().expect("it starts");
    fixture.until("w.csv", "259.");
    let (status, out, err) = Recording { child }.end("-INT");
    assert_eq!(status, Some(0), "{err}");
    let lines: Vec<Value> = out
        .lines()
        .map(|line| serde_json::from_str(line).expect("an object"))
        .collect();
    let (summary, readings) = lines.split_last().expect("a summary");
    assert!(
        readings.iter().all(|reading| reading["x"].is_number()),
        "{out}"
    );
    assert_eq!(
        (&summary["format"], &summary["law"]["basis"]),
        (&"csv".into(), &"readings".into())
    );
    assert_eq!(summary["readings"], rows(&fixture.text("w.csv")).len());
    let again = watch("w.csv").output().expect("it ends");
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(run(&["watch", "--law", "--port", "sim"]).status, 2);
}
