//! Settings that a killed verb left changed: the next verb that moves or sets restores them.
#![cfg(unix)]

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use ::magician::blocking::Arm;
use ::magician::commands::WaitCmd;
use serde_json::Value;

use crate::magician::command;
use crate::magician::homed::mark_homed;
use crate::magician::served::Served;

const RESTORED_NOW: &str = "restored now: PTPCommonParams";
const PENDING: &str = "the next command that moves or sets restores: PTPCommonParams";
const AFTER_QUEUE: &str = "the first command after the arm's queue is empty";

/// Virtual arms in another process, and a directory for files that outlive a command.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
}

impl Fixture {
    fn new(arguments: &[&str], endpoints: usize) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let arguments: Vec<String> = arguments
            .iter()
            .map(|word| word.replace("DIR", dir.path().to_str().expect("UTF-8")))
            .collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let served = Served::start(
            &[&["--speed", "2", "-v"], &arguments[..]].concat(),
            endpoints,
        );
        Self { dir, served }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Returns a program with moves and waits that is slower than the arm's settings.
    fn program(&self) -> String {
        let steps: Vec<String> = (0..40)
            .map(|nth| format!("{{\"move\":[230,{nth},20,0],\"by\":\"line\"}},{{\"wait\":0.05}}"))
            .collect();
        let steps = steps.join(",\n");
        let text = format!(
            r#"{{"format":"magician-plan","version":1,"title":"waits","tool":"none","steps":[
{{"command":"PTPCommonParams","values":{{"velocity_ratio":21,"acceleration_ratio":22}}}},
{steps}]}}"#
        );
        let path = self.path("waits.plan.json");
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    }

    fn command(&self, endpoint: &str, arguments: &[&str]) -> Command {
        let mut command = command();
        command.args(["--port", endpoint]).args(arguments);
        command.env("XDG_STATE_HOME", self.path("state"));
        command
    }

    /// Runs the command. Returns stdout and stderr.
    fn run(&self, endpoint: &str, arguments: &[&str]) -> (String, String) {
        let output: Output = self.command(endpoint, arguments).output().expect("it runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{arguments:?}: {out}{err}");
        (out, err)
    }

    fn ratio(&self, endpoint: &str) -> f64 {
        let (out, _) = self.run(endpoint, &["get", "PTPCommonParams", "--json"]);
        let answer: Value = serde_json::from_str(&out).expect("an object");
        answer["velocity_ratio"]
            .as_f64()
            .or_else(|| answer["value"]["velocity_ratio"].as_f64())
            .unwrap_or_else(|| panic!("{out}"))
    }

    fn start(&self, endpoint: &str, arguments: &[&str]) -> Child {
        let mut command = self.command(endpoint, arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("it starts")
    }

    /// Marks the arm at this port as homed.
    fn is_homed(&self, endpoint: &str) {
        let mut command = command();
        command.env("XDG_STATE_HOME", self.path("state"));
        mark_homed(command, endpoint);
    }

    /// Leaves the arm with a speed of 21 % instead of its usual 77 %, by killing a run.
    fn killed(&mut self, endpoint: &str) {
        self.run(endpoint, &["alarms", "--clear"]);
        self.is_homed(endpoint);
        let usual = ["velocity_ratio=77", "acceleration_ratio=66"];
        self.run(endpoint, &["set", "PTPCommonParams", usual[0], usual[1]]);
        let program = self.program();
        let mut child = self.start(endpoint, &["run", &program]);
        for _ in 0..3 {
            self.served
                .until(|line| line.ends_with(" WAITCmd finished"));
        }
        child.kill().expect("killed");
        child.wait().expect("it ends");
    }

    /// Fills the arm's queue with a wait, so that it is not empty until it is cleared.
    fn waits(endpoint: &str) {
        let arm = Arm::connect(endpoint).expect("it answers");
        arm.enqueue(&WaitCmd { timeout: 3_600_000 })
            .expect("there is room");
        arm.detach();
        arm.close();
    }

    fn files(&self) -> usize {
        let files = std::fs::read_dir(self.path("state/magician/debts"));
        files.map_or(0, |files| files.count())
    }
}

#[test]
fn settings_of_a_killed_run_are_restored_by_the_next_verb_that_moves_or_sets() {
    let mut fixture = Fixture::new(&["--pty", "DIR/arm"], 1);
    let endpoint = fixture.path("arm").to_str().expect("UTF-8").to_owned();
    fixture.killed(&endpoint);
    Fixture::waits(&endpoint);
    assert_eq!(fixture.files(), 1);
    // Verbs that only read restore nothing and say so.
    for look in [&["info"][..], &["pose"], &["queue"], &["alarms"], &["io"]] {
        let (_, err) = fixture.run(&endpoint, look);
        assert!(err.contains(PENDING), "{look:?}: {err}");
    }
    let (out, err) = fixture.run(&endpoint, &["info", "--json"]);
    assert_eq!(err, "");
    let answer: Value = serde_json::from_str(&out).expect("an object");
    assert_eq!(answer["notes"][0]["code"], "speed", "{answer}");
    assert_eq!(fixture.ratio(&endpoint), 21.0);
    // Queued commands may still change settings, so restoring is postponed.
    let (_, err) = fixture.run(&endpoint, &["suction", "off"]);
    assert!(err.contains(AFTER_QUEUE), "{err}");
    assert_eq!((fixture.ratio(&endpoint), fixture.files()), (21.0, 1));
    // A stop is never delayed.
    let (_, err) = fixture.run(&endpoint, &["stop"]);
    assert!(!err.contains("note:"), "{err}");
    let (_, err) = fixture.run(&endpoint, &["suction", "off"]);
    assert!(err.contains(RESTORED_NOW), "{err}");
    assert_eq!((fixture.ratio(&endpoint), fixture.files()), (77.0, 0));
    let (_, err) = fixture.run(&endpoint, &["suction", "off"]);
    assert!(!err.contains("note:"), "{err}");
}

#[test]
fn resumed_run_restores_the_settings_before_the_killed_one() {
    let mut fixture = Fixture::new(&["--tcp", "127.0.0.1:0"], 1);
    let endpoint = fixture.served.endpoint("tcp");
    fixture.killed(&endpoint);
    let program = fixture.program();
    let (out, err) = fixture.run(&endpoint, &["run", &program, "--resume", "--json"]);
    let answer: Value = serde_json::from_str(out.lines().last().unwrap_or_default()).expect("JSON");
    let notes = answer["notes"].to_string();
    assert!(notes.contains(RESTORED_NOW), "{out}{err}");
    assert_eq!((fixture.ratio(&endpoint), fixture.files()), (77.0, 0));
}

#[test]
fn damaged_file_is_reported_and_not_sent() {
    let mut fixture = Fixture::new(&["--tcp", "127.0.0.1:0"], 1);
    let endpoint = fixture.served.endpoint("tcp");
    fixture.killed(&endpoint);
    fixture.run(&endpoint, &["stop"]);
    let dir = fixture.path("state/magician/debts");
    let file = std::fs::read_dir(dir).expect("a directory").next();
    let file = file.expect("a file").expect("readable").path();
    let text = std::fs::read_to_string(&file).expect("text");
    let harm = text.replace("\"PTPCommonParams\"", "\"EndEffectorSuctionCup\"");
    assert_ne!(text, harm);
    std::fs::write(&file, harm).expect("written");
    for (verb, left) in [(&["info"][..], 1), (&["suction", "off"], 0)] {
        let (_, err) = fixture.run(&endpoint, verb);
        assert!(err.contains("is damaged"), "{verb:?}: {err}");
        assert_eq!((fixture.ratio(&endpoint), fixture.files()), (21.0, left));
    }
}

#[test]
fn unrestored_settings_are_kept_per_arm_and_process() {
    let mut fixture = Fixture::new(&["--arms", "2", "--pty", "DIR/arm"], 2);
    let [one, two] = ["arm.1", "arm.2"].map(|name| fixture.path(name).display().to_string());
    fixture.killed(&one);
    fixture.run(&one, &["stop"]);
    let (_, err) = fixture.run(&two, &["suction", "off"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    // Same arm at another port.
    fixture.run(&two, &["alarms", "--clear"]);
    fixture.is_homed(&two);
    let program = fixture.program();
    let mut child = fixture.start(&two, &["run", &program]);
    fixture
        .served
        .until(|line| line.ends_with(" WAITCmd finished"));
    assert_eq!(fixture.files(), 2, "one for each arm");
    let (_, err) = fixture.run(&one, &["suction", "off"]);
    assert!(err.contains(RESTORED_NOW), "{err}");
    assert_eq!(fixture.files(), 1, "that of the living is not touched");
    child.kill().expect("killed");
    child.wait().expect("it ends");
    let (_, err) = fixture.run(&two, &["info"]);
    assert!(err.contains(PENDING), "{err}");
}

#[test]
fn virtual_arms_at_two_places_keep_their_own_settings_and_runs() {
    let mut fixture = Fixture::new(&["--pty", "DIR/arm"], 1);
    let [one, two] = ["arm", "other"].map(|name| fixture.path(name).display().to_string());
    let _other = Served::start(&["--pty", &two, "--speed", "2"], 1);
    fixture.killed(&one);
    fixture.run(&one, &["stop"]);
    let (_, err) = fixture.run(&two, &["alarms", "--clear"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    let (_, err) = fixture.run(&two, &["suction", "off"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    fixture.is_homed(&two);
    let resumed = fixture
        .command(&two, &["run", &fixture.program(), "--resume"])
        .output();
    let resumed = resumed.expect("it runs");
    assert_eq!(resumed.status.code(), Some(3), "another arm: {resumed:?}");
    let (_, err) = fixture.run(&one, &["suction", "off"]);
    assert!(err.contains(RESTORED_NOW), "{err}");
    assert_eq!((fixture.ratio(&one), fixture.files()), (77.0, 0));
}

/// Returns the serial number of an arm.
fn serial(endpoint: &str) -> String {
    let info = command()
        .args(["--port", endpoint, "info", "--json"])
        .output();
    let info: Value = serde_json::from_slice(&info.expect("it runs").stdout).expect("JSON");
    info["device_sn"].as_str().expect("text").to_owned()
}

#[test]
fn virtual_arm_has_the_serial_number_of_its_place_at_each_start() {
    let dir = tempfile::tempdir().expect("directory");
    let path = |name: &str| dir.path().join(name).display().to_string();
    let (one, two) = (path("one"), path("two"));
    let told = |endpoint: &str, more: &[&str]| {
        let _arm = Served::start(&[&["--pty", endpoint], more].concat(), 1);
        serial(endpoint)
    };
    let first = told(&one, &[]);
    assert!(first.starts_with("SIM"), "{first}");
    assert_eq!(told(&one, &[]), first, "another start");
    assert_ne!(told(&two, &[]), first, "another place");
    let profile = path("profile.toml");
    std::fs::write(&profile, "[identity]\nserial = \"DT7\"\n").expect("written");
    assert_eq!(told(&one, &["--profile", &profile]), "DT7");
    let flash = path("flash");
    assert_eq!(told(&one, &["--flash", &flash]), first);
    // Each arm prints a title and an endpoint.
    let several = Served::start(&["--arms", "3", "--tcp", "127.0.0.1:0"], 5);
    let endpoints = several.endpoints.iter();
    let endpoints: Vec<_> = endpoints
        .filter_map(|line| line.split_once("serving "))
        .collect();
    let mut serials: Vec<_> = endpoints
        .iter()
        .map(|(_, endpoint)| serial(endpoint))
        .collect();
    serials.sort();
    serials.dedup();
    assert_eq!(serials.len(), 3, "{serials:?}");
}

#[test]
fn restarting_a_killed_run_names_the_resume_flag() {
    let mut fixture = Fixture::new(&["--tcp", "127.0.0.1:0"], 1);
    let endpoint = fixture.served.endpoint("tcp");
    fixture.killed(&endpoint);
    fixture.run(&endpoint, &["stop"]);
    let program = fixture.program();
    let mut child = fixture.command(&endpoint, &["run", &program]);
    let mut child = child.stderr(Stdio::piped()).spawn().expect("it starts");
    fixture
        .served
        .until(|line| line.ends_with(" WAITCmd finished"));
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.expect("kill runs").success());
    let mut err = String::new();
    let mut stderr = child.stderr.take().expect("piped");
    std::io::Read::read_to_string(&mut stderr, &mut err).expect("UTF-8");
    child.wait().expect("it ends");
    let said = "an earlier run of this file was interrupted after at least";
    assert!(err.contains(said), "{err}");
    assert!(err.contains("--resume continues where it ended"), "{err}");
    // The interrupted run has printed how to resume.
    let (_, err) = fixture.run(&endpoint, &["run", &program, "--from", "80"]);
    assert!(!err.contains(said), "{err}");
}

#[test]
fn run_completes_without_a_state_folder() {
    let fixture = Fixture::new(&["--tcp", "127.0.0.1:0"], 1);
    let endpoint = fixture.served.endpoint("tcp");
    fixture.run(&endpoint, &["alarms", "--clear"]);
    // A file in place of the directory; not even root can write there.
    std::fs::write(fixture.path("state"), "").expect("written");
    let (_, err) = fixture.run(
        &endpoint,
        &["move", "220", "0", "40", "--speed-ratio", "90"],
    );
    assert!(err.contains("cannot be saved"), "{err}");
    let (_, err) = fixture.run(&endpoint, &["info"]);
    assert!(!err.contains("note:"), "{err}");
}

#[test]
fn nothing_is_stored_for_an_arm_in_the_process() {
    let fixture = Fixture::new(&["--tcp", "127.0.0.1:0"], 1);
    fixture.run(
        "sim:max",
        &["move", "220", "0", "40", "--speed-ratio", "90"],
    );
    assert!(!fixture.path("state/magician/debts").exists());
    let endpoint = fixture.served.endpoint("tcp");
    fixture.run(&endpoint, &["alarms", "--clear"]);
    fixture.run(
        &endpoint,
        &["move", "220", "0", "40", "--speed-ratio", "90"],
    );
    assert_eq!(fixture.files(), 0, "given back");
    assert!(fixture.path("state/magician/debts").exists());
}
