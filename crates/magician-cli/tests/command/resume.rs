//! Runs that are interrupted, and runs that resume them.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use crate::magician::drawing::last;
use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::{command, signal};
use serde_json::Value;

/// Number of moves, each followed by a wait.
const PAIRS: usize = 24;

/// Arm in another process, and a directory for programs and journals.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
    endpoint: String,
}

impl Fixture {
    fn new(more: &[&str]) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let served = serve(more);
        let endpoint = served.endpoint("tcp");
        let fixture = Self {
            dir,
            served,
            endpoint,
        };
        assert!(fixture.run(&["alarms", "--clear"]).status.success());
        fixture.is_homed();
        fixture
    }

    /// Marks the arm as homed.
    fn is_homed(&self) {
        let mut command = command();
        command.env("XDG_STATE_HOME", self.dir.path().join("state"));
        mark_homed(command, &self.endpoint);
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    }

    /// Returns a program of short moves, each followed by a wait, by which progress is counted.
    fn program(&self, wait: &str) -> String {
        let steps: Vec<String> = (0..PAIRS)
            .map(|nth| {
                let y = nth as f64 - 12.0;
                format!("{{\"move\":[230,{y},20,0],\"by\":\"joints\"}},\n{{\"wait\":{wait}}}")
            })
            .collect();
        let head =
            r#"{"format":"magician-plan","version":1,"title":"waits","tool":"none","steps":["#;
        self.write(
            "waits.plan.json",
            &format!("{head}\n{}\n]}}\n", steps.join(",\n")),
        )
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command();
        command
            .args(["--port", &self.endpoint, "--json"])
            .args(arguments);
        command.env("XDG_STATE_HOME", self.dir.path().join("state"));
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("it runs")
    }

    fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("it starts")
    }

    fn journals(&self) -> usize {
        let files = std::fs::read_dir(self.path("state/magician/runs"));
        files.map_or(0, |files| files.count())
    }
}

fn serve(more: &[&str]) -> Served {
    Served::start(
        &[&["--tcp", "127.0.0.1:0", "--speed", "2", "-v"], more].concat(),
        1,
    )
}

fn error(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stderr);
    let object: Value = serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}"));
    object["error"].clone()
}

fn waits(log: &[String]) -> usize {
    log.iter()
        .filter(|line| line.ends_with(" WAITCmd finished"))
        .count()
}

/// Waits until the arm has finished this many waits.
fn until_waits(served: &mut Served, count: usize) {
    for _ in 0..count {
        served.until(|line| line.ends_with(" WAITCmd finished"));
    }
}

#[test]
fn killed_run_resumes_without_repeating_steps() {
    let mut fixture = Fixture::new(&[]);
    let program = fixture.program("0.03");
    let mut child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 5);
    signal("-KILL", &child);
    child.wait().expect("it ends");
    assert_eq!(fixture.journals(), 1);
    let done = fixture.run(&["run", &program, "--resume"]);
    assert!(done.status.success(), "{done:?}");
    let first = last(&done)["first_step"].as_u64().expect("a step");
    assert!(first > 10, "{done:?}");
    assert_eq!(fixture.journals(), 0, "a good end leaves nothing");
    assert_eq!(waits(&fixture.served.log()), PAIRS);
}

#[test]
fn ctrl_c_reports_the_resume_step_and_the_run_resumes_there() {
    let mut fixture = Fixture::new(&[]);
    let program = fixture.program("0.03");
    let child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 4);
    signal("-INT", &child);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(error(&output)["kind"], "interrupted");
    let text = std::fs::read_dir(fixture.path("state/magician/runs")).expect("journals");
    let path = text
        .map(|entry| entry.expect("an entry").path())
        .next()
        .expect("one");
    let mark: Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("text")).expect("JSON");
    let finished = mark["finished"].as_u64().expect("a number");
    assert!((8..48).contains(&finished), "{mark}");
    assert!(mark["ended"].is_string(), "{mark}");
    let done = fixture.run(&["run", &program, "--resume"]);
    assert!(done.status.success(), "{done:?}");
    assert_eq!(last(&done)["first_step"], finished + 1);
    assert_eq!(last(&done)["steps"], 2 * PAIRS as u64 - finished);
    let again = fixture.run(&["run", &program, "--resume"]);
    assert_eq!(again.status.code(), Some(3), "{again:?}");
    assert!(
        error(&again)["message"]
            .as_str()
            .expect("text")
            .contains("nothing to resume")
    );
}

#[test]
fn run_ended_by_an_alarm_resumes_after_clearing() {
    let dir = tempfile::tempdir().expect("directory");
    let scenario = dir.path().join("alarm.toml");
    let text = "[[fault]]\nkind = \"alarm\"\nalarm = 0x10\nindex = 20\n";
    std::fs::write(&scenario, text).expect("written");
    let fixture = Fixture::new(&["--scenario", scenario.to_str().expect("UTF-8")]);
    let program = fixture.program("0.01");
    let failed = fixture.run(&["run", &program]);
    assert_eq!(failed.status.code(), Some(8), "{failed:?}");
    assert_eq!(error(&failed)["kind"], "alarm");
    let held = fixture.run(&["run", &program, "--resume"]);
    assert_eq!(
        held.status.code(),
        Some(8),
        "it stands until it is cleared: {held:?}"
    );
    assert!(fixture.run(&["alarms", "--clear"]).status.success());
    let done = fixture.run(&["run", &program, "--resume"]);
    assert!(done.status.success(), "{done:?}");
    let first = last(&done)["first_step"].as_u64().expect("a step");
    assert!((15..=21).contains(&first), "{first}");
}

#[test]
fn switched_off_arm_needs_an_explicit_start() {
    // At another port a virtual arm gets another serial number, unless its profile sets one.
    let profile = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(&profile, "[identity]\nserial = \"DT7\"\n").expect("written");
    let own = ["--profile", profile.path().to_str().expect("UTF-8")];
    let mut fixture = Fixture::new(&own);
    let program = fixture.program("0.03");
    let child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 4);
    fixture.served.child.kill().expect("it lives");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(
        (output.status.code(), &error(&output)["kind"]),
        (Some(4), &Value::from("port"))
    );
    assert_eq!(fixture.journals(), 1);
    // Another arm with the same serial number and an empty history.
    fixture.served = serve(&own);
    fixture.endpoint = fixture.served.endpoint("tcp");
    assert!(fixture.run(&["alarms", "--clear"]).status.success());
    fixture.is_homed();
    let doubt = fixture.run(&["run", &program, "--resume"]);
    assert_eq!(doubt.status.code(), Some(9), "{doubt:?}");
    assert_eq!(error(&doubt)["kind"], "uncertain");
    let mut shown = fixture.command(&["run", &program, "--resume"]);
    let shown = shown.args(["--json=false"]).output().expect("it runs");
    assert_eq!(
        shown.status.code(),
        Some(2),
        "flags take no values: {shown:?}"
    );
    let done = fixture.run(&["run", &program, "--from", "9"]);
    assert!(done.status.success(), "{done:?}");
    assert_eq!(
        (&last(&done)["first_step"], &last(&done)["steps"]),
        (&Value::from(9), &Value::from(40))
    );
}

#[test]
fn arm_reset_meanwhile_repeats_no_step() {
    let dir = tempfile::tempdir().expect("directory");
    let scenario = dir.path().join("reset.toml");
    let text = "[[fault]]\nkind = \"reset\"\nindex = 20\n";
    std::fs::write(&scenario, text).expect("written");
    let fixture = Fixture::new(&["--scenario", scenario.to_str().expect("UTF-8")]);
    let program = fixture.program("0.03");
    let failed = fixture.run(&["run", &program]);
    assert_eq!(failed.status.code(), Some(9), "{failed:?}");
    assert!(fixture.run(&["alarms", "--clear"]).status.success());
    fixture.is_homed();
    // The reset arm's index is 0 again, which does not prove that nothing was done.
    let doubt = fixture.run(&["run", &program, "--resume"]);
    assert_eq!(doubt.status.code(), Some(9), "{doubt:?}");
    assert_eq!(error(&doubt)["kind"], "uncertain");
}

#[test]
fn relative_program_resumes_from_its_start_position() {
    let mut fixture = Fixture::new(&[]);
    let moved = fixture.run(&["move", "210.1234", "-10", "20"]);
    assert!(moved.status.success(), "{moved:?}");
    let lines = "G1 X1 F300\nG4 P30\n".repeat(24);
    let program = fixture.write("relative.gcode", &format!("G21 G91\n{lines}"));
    let child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 4);
    signal("-INT", &child);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    // The arm stands elsewhere now, so everything would be displaced.
    for more in [&["--resume"][..], &["--from", "9"]] {
        let refused = fixture.run(&[&["run", &program], more].concat());
        assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    }
    let said = ["--start", "210.123,-10.000,20.000", "--resume"];
    let done = fixture.run(&[&["run", &program], &said[..]].concat());
    assert!(done.status.success(), "{done:?}");
    let pose = last(&fixture.run(&["pose"]));
    let x = pose["x"].as_f64().expect("a number");
    assert!((x - 234.123).abs() < 0.01, "{pose}");
}

#[test]
fn text_output_states_how_to_resume() {
    let mut fixture = Fixture::new(&[]);
    let program = fixture.program("0.03");
    let mut told = command();
    told.args(["--port", &fixture.endpoint, "run", &program]);
    told.env("XDG_STATE_HOME", fixture.path("state"));
    told.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = told.spawn().expect("it starts");
    until_waits(&mut fixture.served, 3);
    signal("-INT", &child);
    let output = child.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stderr);
    for part in ["the arm stands at x", "of 48 steps are done", "--resume"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn stop_by_another_program_ends_a_resumable_run() {
    let mut fixture = Fixture::new(&[]);
    let program = fixture.program("0.03");
    let child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 3);
    assert!(fixture.run(&["stop"]).status.success());
    let output = child.wait_with_output().expect("it ends");
    assert!(!output.status.success(), "{output:?}");
    let done = fixture.run(&["run", &program, "--resume"]);
    assert!(done.status.success(), "{done:?}");
    assert!(last(&done)["first_step"].as_u64().expect("a step") > 6);
}

#[test]
fn resume_with_different_placement_is_refused() {
    let mut fixture = Fixture::new(&[]);
    let program = fixture.program("0.03");
    let mut child = fixture.start(&["run", &program]);
    until_waits(&mut fixture.served, 3);
    signal("-INT", &child);
    child.wait().expect("it ends");
    let other = fixture.run(&["run", &program, "--move", "0,0,5", "--resume"]);
    assert_eq!(other.status.code(), Some(3), "{other:?}");
    assert!(Path::new(&program).exists());
}

#[test]
fn resumed_laser_job_needs_confirmation() {
    let fixture = Fixture::new(&[]);
    let text = "G21 G90\nG0 X220 Y0 Z0\nM3 S0\nG1 X221 F600 S500\nM5\n";
    let file = fixture.write("burn.gcode", text);
    let refused = fixture.run(&["run", &file]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(
        error(&refused)["message"]
            .as_str()
            .expect("text")
            .contains("laser")
    );
    let check = fixture.run(&["run", &file, "--check"]);
    assert!(check.status.success(), "{check:?}");
    let burnt = fixture.run(&["run", &file, "--yes"]);
    assert!(burnt.status.success(), "{burnt:?}");
    let laser = fixture.run(&["get", "EndEffectorLaser"]);
    assert_eq!(last(&laser)["is_on"], 0, "it ends dark");
}

#[test]
fn an_arm_that_was_not_homed_and_a_queue_that_is_not_empty() {
    let fixture = Fixture::new(&[]);
    let steps = r#"{"format":"magician-plan","version":1,"title":"a","steps":[{"move":[220,0,0,0],"by":"joints"}]}"#;
    let file = fixture.write("a.plan.json", steps);
    let waits = fixture.run(&["enqueue", "WAITCmd", "timeout=10"]);
    assert!(waits.status.success());
    let strangers = fixture.run(&["run", &file]);
    assert_eq!(strangers.status.code(), Some(3), "{strangers:?}");
    let strangers = error(&strangers);
    assert_eq!(strangers["code"], "foreign-commands");
    assert_eq!(strangers["remedies"][1]["option"], "keep", "{strangers}");
    // Waiting commands may burn: they cannot be read back.
    let unread = fixture.run(&["run", &file, "--keep"]);
    assert_eq!(unread.status.code(), Some(2), "{unread:?}");
    assert!(
        fixture
            .run(&["run", &file, "--keep", "--yes"])
            .status
            .success()
    );
    let fresh = serve(&[]);
    let mut unhomed = command();
    let endpoint = fresh.endpoint("tcp");
    unhomed.args([
        "--port",
        &endpoint,
        "--json",
        "run",
        &file,
        "--require-homed",
    ]);
    let unhomed = unhomed.output().expect("it runs");
    assert_eq!(unhomed.status.code(), Some(3), "{unhomed:?}");
}

#[test]
fn preview_with_a_port_reads_the_settings_in_force() {
    let fixture = Fixture::new(&[]);
    let file = fixture.write("a.gcode", "G21 G90\nG0 X220 Y0 Z0\nG0 X260\n");
    let seconds = |fixture: &Fixture| {
        let look = fixture.run(&["run", &file, "--estimate"]);
        assert!(look.status.success(), "{look:?}");
        last(&look)["seconds"].as_f64().expect("a time")
    };
    let usual = seconds(&fixture);
    let slow = [
        "set",
        "PTPCommonParams",
        "velocity_ratio=5",
        "acceleration_ratio=5",
    ];
    assert!(fixture.run(&slow).status.success());
    assert!(seconds(&fixture) > 3.0 * usual);
    assert_eq!(
        last(&fixture.run(&["queue"]))["current_index"],
        0,
        "nothing was sent"
    );
}

#[test]
fn real_arm_needs_a_known_surface_height() {
    let fixture = Fixture::new(&[]);
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' viewBox='0 0 20 20'>\
               <path d='M5 5 L15 15' stroke='black'/></svg>";
    let file = fixture.write("line.svg", svg);
    let refused = fixture.run(&["draw", &file]);
    assert_eq!(refused.status.code(), Some(3), "{refused:?}");
    let mut told = command();
    let told = told
        .args(["--port", &fixture.endpoint, "draw", &file, "--unhomed"])
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&told.stderr);
    assert!(
        text.contains("magician calibrate") && text.contains("--surface Z"),
        "{text}"
    );
    assert!(
        fixture
            .run(&["draw", &file, "--surface", "-50"])
            .status
            .success()
    );
}

#[test]
fn interrupted_line_resumes_where_the_pen_stopped() {
    let fixture = Fixture::new(&[]);
    let steps = r#"{"format":"magician-plan","version":1,"title":"a line","tool":"pen","steps":[
        {"command":"CPParams","values":{"plan_acc":100,"junction_vel":10,"acc_or_period":100,"real_time_track":0}},
        {"move":[220,-40,0,0],"by":"line"},
        {"path":[220,40,0]},
        {"move":[220,40,20,0],"by":"line"}]}"#;
    let file = fixture.write("line.plan.json", steps);
    let at = || {
        let pose = last(&fixture.run(&["pose"]));
        ["x", "y"].map(|axis| pose[axis].as_f64().expect("a number"))
    };
    let child = fixture.start(&["run", &file]);
    while !matches!(at(), [x, y] if x < 221.0 && (-30.0..30.0).contains(&y)) {}
    signal("-INT", &child);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    let [_, stood] = at();
    assert!((-30.0..40.0).contains(&stood), "{stood}");
    let done = fixture.run(&["run", &file, "--resume"]);
    assert!(done.status.success(), "{done:?}");
    let done = last(&done);
    assert_eq!(done["first_step"], 3);
    let drawn = done["drawn_mm"].as_f64().expect("a length");
    assert!((drawn - (40.0 - stood)).abs() < 0.2, "{drawn} from {stood}");
}
