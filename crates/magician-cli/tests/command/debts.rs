//! Settings that a killed verb left changed: the next verb that moves or sets restores them.
#![cfg(unix)]

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use ::magician::blocking::Arm;
use ::magician::commands::WaitCmd;
use serde_json::Value;

use crate::magician::command;
use crate::magician::homed::as_if_homed;
use crate::magician::served::Served;

const BEFORE: &str = "restored now: PTPCommonParams";
const OWED: &str = "the next command that moves or sets restores: PTPCommonParams";
const LATER: &str = "the first command after the arm's queue is empty";

/// Virtual arms in another process, and a directory for files that outlive a command.
struct Place {
    dir: tempfile::TempDir,
    served: Served,
}

impl Place {
    fn new(arguments: &[&str], doors: usize) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let arguments: Vec<String> = arguments
            .iter()
            .map(|word| word.replace("DIR", dir.path().to_str().expect("UTF-8")))
            .collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let served = Served::start(&[&["--speed", "2", "-v"], &arguments[..]].concat(), doors);
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

    fn command(&self, door: &str, arguments: &[&str]) -> Command {
        let mut command = command();
        command.args(["--port", door]).args(arguments);
        command.env("XDG_STATE_HOME", self.path("state"));
        command
    }

    /// Runs the command. Returns stdout and stderr.
    fn run(&self, door: &str, arguments: &[&str]) -> (String, String) {
        let output: Output = self.command(door, arguments).output().expect("it runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{arguments:?}: {out}{err}");
        (out, err)
    }

    fn ratio(&self, door: &str) -> f64 {
        let (out, _) = self.run(door, &["get", "PTPCommonParams", "--json"]);
        let answer: Value = serde_json::from_str(&out).expect("an object");
        answer["velocity_ratio"]
            .as_f64()
            .or_else(|| answer["value"]["velocity_ratio"].as_f64())
            .unwrap_or_else(|| panic!("{out}"))
    }

    fn start(&self, door: &str, arguments: &[&str]) -> Child {
        let mut command = self.command(door, arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("it starts")
    }

    /// Marks the arm at this port as homed.
    fn is_homed(&self, door: &str) {
        let mut command = command();
        command.env("XDG_STATE_HOME", self.path("state"));
        as_if_homed(command, door);
    }

    /// Leaves the arm with a speed of 21 % instead of its usual 77 %, by killing a run.
    fn killed(&mut self, door: &str) {
        self.run(door, &["alarms", "--clear"]);
        self.is_homed(door);
        let usual = ["velocity_ratio=77", "acceleration_ratio=66"];
        self.run(door, &["set", "PTPCommonParams", usual[0], usual[1]]);
        let program = self.program();
        let mut child = self.start(door, &["run", &program]);
        for _ in 0..3 {
            self.served
                .until(|line| line.ends_with(" WAITCmd finished"));
        }
        child.kill().expect("killed");
        child.wait().expect("it ends");
    }

    /// Fills the arm's queue with a wait, so that it is not empty until it is cleared.
    fn waits(door: &str) {
        let arm = Arm::connect(door).expect("it answers");
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
fn a_killed_run_leaves_its_speeds_to_the_next_verb_that_moves_or_sets() {
    let mut place = Place::new(&["--pty", "DIR/arm"], 1);
    let door = place.path("arm").to_str().expect("UTF-8").to_owned();
    place.killed(&door);
    Place::waits(&door);
    assert_eq!(place.files(), 1);
    // Verbs that only read restore nothing and say so.
    for look in [&["info"][..], &["pose"], &["queue"], &["alarms"], &["io"]] {
        let (_, err) = place.run(&door, look);
        assert!(err.contains(OWED), "{look:?}: {err}");
    }
    let (out, err) = place.run(&door, &["info", "--json"]);
    assert_eq!(err, "");
    let answer: Value = serde_json::from_str(&out).expect("an object");
    assert_eq!(answer["notes"][0]["code"], "speed", "{answer}");
    assert_eq!(place.ratio(&door), 21.0);
    // Queued commands may still change settings, so restoring is postponed.
    let (_, err) = place.run(&door, &["suction", "off"]);
    assert!(err.contains(LATER), "{err}");
    assert_eq!((place.ratio(&door), place.files()), (21.0, 1));
    // A stop is never delayed.
    let (_, err) = place.run(&door, &["stop"]);
    assert!(!err.contains("note:"), "{err}");
    let (_, err) = place.run(&door, &["suction", "off"]);
    assert!(err.contains(BEFORE), "{err}");
    assert_eq!((place.ratio(&door), place.files()), (77.0, 0));
    let (_, err) = place.run(&door, &["suction", "off"]);
    assert!(!err.contains("note:"), "{err}");
}

#[test]
fn a_run_that_goes_on_gives_back_the_speeds_of_before_the_killed_one() {
    let mut place = Place::new(&["--tcp", "127.0.0.1:0"], 1);
    let door = place.served.door("tcp");
    place.killed(&door);
    let program = place.program();
    let (out, err) = place.run(&door, &["run", &program, "--resume", "--json"]);
    let answer: Value = serde_json::from_str(out.lines().last().unwrap_or_default()).expect("JSON");
    let notes = answer["notes"].to_string();
    assert!(notes.contains(BEFORE), "{out}{err}");
    assert_eq!((place.ratio(&door), place.files()), (77.0, 0));
}

#[test]
fn a_damaged_file_is_told_of_and_nothing_of_it_is_sent() {
    let mut place = Place::new(&["--tcp", "127.0.0.1:0"], 1);
    let door = place.served.door("tcp");
    place.killed(&door);
    place.run(&door, &["stop"]);
    let dir = place.path("state/magician/debts");
    let file = std::fs::read_dir(dir).expect("a directory").next();
    let file = file.expect("a file").expect("readable").path();
    let text = std::fs::read_to_string(&file).expect("text");
    let harm = text.replace("\"PTPCommonParams\"", "\"EndEffectorSuctionCup\"");
    assert_ne!(text, harm);
    std::fs::write(&file, harm).expect("written");
    for (verb, left) in [(&["info"][..], 1), (&["suction", "off"], 0)] {
        let (_, err) = place.run(&door, verb);
        assert!(err.contains("is damaged"), "{verb:?}: {err}");
        assert_eq!((place.ratio(&door), place.files()), (21.0, left));
    }
}

#[test]
fn each_arm_has_its_own_debts_and_a_living_process_keeps_its_own() {
    let mut place = Place::new(&["--arms", "2", "--pty", "DIR/arm"], 2);
    let [one, two] = ["arm.1", "arm.2"].map(|name| place.path(name).display().to_string());
    place.killed(&one);
    place.run(&one, &["stop"]);
    let (_, err) = place.run(&two, &["suction", "off"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    // Same arm at another port.
    place.run(&two, &["alarms", "--clear"]);
    place.is_homed(&two);
    let program = place.program();
    let mut child = place.start(&two, &["run", &program]);
    place
        .served
        .until(|line| line.ends_with(" WAITCmd finished"));
    assert_eq!(place.files(), 2, "one for each arm");
    let (_, err) = place.run(&one, &["suction", "off"]);
    assert!(err.contains(BEFORE), "{err}");
    assert_eq!(place.files(), 1, "that of the living is not touched");
    child.kill().expect("killed");
    child.wait().expect("it ends");
    let (_, err) = place.run(&two, &["info"]);
    assert!(err.contains(OWED), "{err}");
}

#[test]
fn virtual_arms_at_two_places_keep_their_own_settings_and_runs() {
    let mut place = Place::new(&["--pty", "DIR/arm"], 1);
    let [one, two] = ["arm", "other"].map(|name| place.path(name).display().to_string());
    let _other = Served::start(&["--pty", &two, "--speed", "2"], 1);
    place.killed(&one);
    place.run(&one, &["stop"]);
    let (_, err) = place.run(&two, &["alarms", "--clear"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    let (_, err) = place.run(&two, &["suction", "off"]);
    assert!(!err.contains("note:"), "another arm: {err}");
    place.is_homed(&two);
    let resumed = place
        .command(&two, &["run", &place.program(), "--resume"])
        .output();
    let resumed = resumed.expect("it runs");
    assert_eq!(resumed.status.code(), Some(3), "another arm: {resumed:?}");
    let (_, err) = place.run(&one, &["suction", "off"]);
    assert!(err.contains(BEFORE), "{err}");
    assert_eq!((place.ratio(&one), place.files()), (77.0, 0));
}

/// Returns the serial number of an arm.
fn serial(door: &str) -> String {
    let info = command().args(["--port", door, "info", "--json"]).output();
    let info: Value = serde_json::from_slice(&info.expect("it runs").stdout).expect("JSON");
    info["device_sn"].as_str().expect("text").to_owned()
}

#[test]
fn virtual_arm_has_the_serial_number_of_its_place_at_each_start() {
    let dir = tempfile::tempdir().expect("directory");
    let path = |name: &str| dir.path().join(name).display().to_string();
    let (one, two) = (path("one"), path("two"));
    let told = |door: &str, more: &[&str]| {
        let _arm = Served::start(&[&["--pty", door], more].concat(), 1);
        serial(door)
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
    let doors = several.doors.iter();
    let doors: Vec<_> = doors
        .filter_map(|line| line.split_once("serving "))
        .collect();
    let mut serials: Vec<_> = doors.iter().map(|(_, door)| serial(door)).collect();
    serials.sort();
    serials.dedup();
    assert_eq!(serials.len(), 3, "{serials:?}");
}

#[test]
fn killed_run_that_is_begun_anew_names_the_way_to_go_on() {
    let mut place = Place::new(&["--tcp", "127.0.0.1:0"], 1);
    let door = place.served.door("tcp");
    place.killed(&door);
    place.run(&door, &["stop"]);
    let program = place.program();
    let mut child = place.command(&door, &["run", &program]);
    let mut child = child.stderr(Stdio::piped()).spawn().expect("it starts");
    place
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
    let (_, err) = place.run(&door, &["run", &program, "--from", "80"]);
    assert!(!err.contains(said), "{err}");
}

#[test]
fn a_run_is_done_also_where_nothing_can_be_kept() {
    let place = Place::new(&["--tcp", "127.0.0.1:0"], 1);
    let door = place.served.door("tcp");
    place.run(&door, &["alarms", "--clear"]);
    // A file in place of the directory; not even root can write there.
    std::fs::write(place.path("state"), "").expect("written");
    let (_, err) = place.run(&door, &["move", "220", "0", "40", "--speed-ratio", "90"]);
    assert!(err.contains("cannot be saved"), "{err}");
    let (_, err) = place.run(&door, &["info"]);
    assert!(!err.contains("note:"), "{err}");
}

#[test]
fn nothing_is_kept_for_an_arm_that_ends_with_the_process() {
    let place = Place::new(&["--tcp", "127.0.0.1:0"], 1);
    place.run(
        "sim:max",
        &["move", "220", "0", "40", "--speed-ratio", "90"],
    );
    assert!(!place.path("state/magician/debts").exists());
    let door = place.served.door("tcp");
    place.run(&door, &["alarms", "--clear"]);
    place.run(&door, &["move", "220", "0", "40", "--speed-ratio", "90"]);
    assert_eq!(place.files(), 0, "given back");
    assert!(place.path("state/magician/debts").exists());
}
