//! Arm without a known homing: the refusals of each front end, and how they end.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use serde_json::{Value, json};

use crate::laser::written;
use crate::magician::served::Served;
use crate::magician::terminal::Terminal;
use crate::magician::{Run, command};

/// Verbs that draw, burn or play.
const RUNS: [&[&str]; 13] = [
    &["draw", "line.svg", "--surface", "-50"],
    &["draw", "a.plan.json"],
    &["write", "ab", "--size", "8", "--surface", "-50"],
    &["engrave", "line.svg", "--surface", "-50", "--yes"],
    &["frame", "line.svg", "--surface", "-50"],
    &[
        "testgrid",
        "--power",
        "50:50:1",
        "--speed",
        "40:40:1",
        "--cell",
        "2",
        "--no-labels",
        "--surface",
        "-50",
        "--yes",
    ],
    &["run", "line.svg", "--surface", "-50"],
    &["run", "pen.gcode"],
    &["run", "burn.gcode", "--yes"],
    &["run", "a.plan.json"],
    &["run", "points.csv"],
    &["run", "taught.playback"],
    &["play", "taught.playback"],
];
/// Verbs in which a user shows the arm positions.
const PADS: [&[&str]; 4] = [
    &["teach", "new.playback"],
    &["calibrate", "surface", "--tool", "pen"],
    &["calibrate", "sheet", "--tool", "pen"],
    &["calibrate", "tool"],
];

/// Virtual arm in another process, which counts as a real one.
struct Fixture {
    dir: tempfile::TempDir,
    served: Served,
}

impl Fixture {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        let served = serve(&dir.path().join("arm"));
        let fixture = Self { dir, served };
        fixture.write(
            "line.svg",
            "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' viewBox='0 0 20 20'>\
             <path d='M2 5 L18 5' fill='none' stroke='black'/></svg>",
        );
        fixture.write(
            "pen.gcode",
            "G21 G90\nG0 X220 Y0 Z10\nG1 Z-40 F900\nG1 X240\nG0 Z10\n",
        );
        fixture.write(
            "burn.gcode",
            "G21 G90\nG0 X220 Y0 Z0\nM3 S0\nG1 X221 F600 S500\nM5\n",
        );
        fixture.write(
            "a.plan.json",
            &plan(r#"{"move":[220,0,0,0],"by":"joints"}"#),
        );
        fixture.write("points.csv", "x,y,z\n220,0,20\n220,10,20\n");
        let taught = "magician-program/samples/jump_suction_named_v170.playback";
        let taught = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(taught);
        std::fs::copy(taught, fixture.path("taught.playback")).expect("copied");
        fixture
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command();
        command.args(["--port", "./arm"]).args(arguments);
        command.current_dir(self.dir.path());
        command.env("XDG_STATE_HOME", self.path("state"));
        command.env("MAGICIAN_CONFIG", self.path("config.toml"));
        command
    }

    fn run(&self, arguments: &[&str]) -> Run {
        Run::of(&mut self.command(arguments), b"")
    }

    /// Asserts that a verb is refused: nothing was written to the arm, and the remedy is named.
    fn refuses(&self, arguments: &[&str]) {
        let trace = ["--trace", "frames.pcapng", "--json"];
        let refused = self.run(&[&trace[..], arguments].concat());
        assert_eq!(refused.status, 3, "{arguments:?}: {refused:?}");
        let error = refused.error();
        let told = (&error["kind"], &error["code"]);
        assert_eq!(
            told,
            (&json!("invalid-input"), &json!("not-homed")),
            "{arguments:?}"
        );
        let remedies = json!([
            {"action": "home", "effect": "homes it"},
            {"option": "unhomed", "value": true, "effect": "goes on anyway"},
        ]);
        assert_eq!(error["remedies"], remedies);
        let sent = written(self.path("frames.pcapng").to_str().expect("UTF-8"));
        assert_eq!(sent, Vec::<String>::new(), "{arguments:?}");
    }

    fn does(&self, arguments: &[&str]) -> Run {
        let done = self.run(arguments);
        assert_eq!(done.status, 0, "{arguments:?}: {done:?}");
        done
    }

    fn person(&self, arguments: &[&str]) -> Terminal {
        Terminal::running(self.command(arguments))
    }

    /// Switches the arm off and on.
    fn power_cycle(&mut self) {
        let _ = self.served.child.kill();
        let _ = self.served.child.wait();
        self.served = serve(&self.path("arm"));
    }

    fn homed(&self) -> String {
        let found = self.run(&["doctor", "--json", "--count", "1"]).object();
        let findings = found["checks"].as_array().expect("checks").clone();
        let homed = findings.iter().find(|one| one["check"] == "homed");
        homed.expect("it is told")["text"]
            .as_str()
            .expect("text")
            .to_owned()
    }
}

fn serve(path: &std::path::Path) -> Served {
    let _ = std::fs::remove_file(path);
    let path = path.to_str().expect("UTF-8");
    Served::start(&["--pty", path, "--speed", "max"], 1)
}

/// Calls a method of a station and returns its answer.
fn rpc(url: &str, method: &str, params: &Value) -> Value {
    let address = url.trim_start_matches("http://");
    let body = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).to_string();
    let mut stream = TcpStream::connect(address).expect("it listens");
    write!(
        stream,
        "POST /api/v1/rpc HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .expect("it reads");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("an answer");
    let (_, body) = text.split_once("\r\n\r\n").expect("a body");
    serde_json::from_str(body).unwrap_or_else(|_| panic!("{text}"))
}

fn plan(steps: &str) -> String {
    format!(r#"{{"format":"magician-plan","version":1,"title":"a","steps":[{steps}]}}"#)
}

#[test]
fn missing_homing_is_reported_before_an_unknown_surface() {
    let fixture = Fixture::new();
    fixture.refuses(&["draw", "line.svg"]);
    let surface = |arguments: &[&str]| {
        let refused = fixture.run(arguments);
        assert_eq!(refused.status, 3, "{refused:?}");
        assert!(
            refused.err.contains("work surface height unknown"),
            "{refused:?}"
        );
    };
    surface(&["draw", "line.svg", "--unhomed"]);
    // A preview needs no homed arm.
    surface(&["draw", "line.svg", "--check"]);
    fixture.does(&["home"]);
    surface(&["draw", "line.svg"]);
}

#[test]
fn unhomed_arm_does_not_draw_burn_or_play() {
    let mut fixture = Fixture::new();
    for cleared in [false, true] {
        if cleared {
            let told = fixture.does(&["alarms", "--clear"]);
            assert!(told.out.contains("is still not homed"), "{told:?}");
        }
        for verb in RUNS {
            fixture.refuses(verb);
        }
    }
    for verb in RUNS {
        fixture.does(&[verb, &["--unhomed"]].concat());
    }
    fixture.refuses(RUNS[0]);
    fixture.does(&["home"]);
    for verb in RUNS {
        fixture.does(verb);
    }
    fixture.power_cycle();
    fixture.refuses(RUNS[0]);
    fixture.does(&["alarms", "--clear"]);
    fixture.refuses(RUNS[0]);
}

#[test]
fn unhomed_arm_is_not_taught_or_calibrated() {
    let fixture = Fixture::new();
    for cleared in [false, true] {
        if cleared {
            fixture.does(&["alarms", "--clear"]);
        }
        for verb in PADS {
            let mut terminal = fixture.person(verb);
            terminal.until("--unhomed goes on anyway");
            assert_eq!(
                terminal.child.wait().expect("it ends").code(),
                Some(3),
                "{verb:?}"
            );
        }
    }
    let unhomed = &[PADS[0], &["--unhomed"]].concat();
    fixture.person(unhomed).until_drawn("link up");
    fixture.does(&["home"]);
    for verb in PADS {
        fixture.person(verb).until_drawn("link up");
    }
}

#[test]
fn reads_and_plain_moves_need_no_homed_arm() {
    let fixture = Fixture::new();
    fixture.does(&["draw", "line.svg", "--surface", "-50", "--check"]);
    fixture.does(&["move", "220", "0", "20"]);
    let sim = Run::of(
        fixture
            .command(&["run", "a.plan.json"])
            .args(["--port", "sim"]),
        b"",
    );
    assert_eq!(sim.status, 0, "{sim:?}");
}

#[test]
fn program_that_homes_first_needs_no_homed_arm() {
    let fixture = Fixture::new();
    fixture.write(
        "homes.plan.json",
        &plan(r#"{"home":true},{"move":[220,0,0,0],"by":"joints"}"#),
    );
    fixture.write(
        "late.plan.json",
        &plan(r#"{"move":[220,0,0,0],"by":"joints"},{"home":true}"#),
    );
    fixture.refuses(&["run", "late.plan.json"]);
    fixture.does(&["run", "homes.plan.json"]);
    fixture.does(&["run", "late.plan.json"]);
    fixture.does(&["run", "a.plan.json"]);
}

#[test]
fn homing_is_remembered_however_the_arm_was_homed() {
    for way in [&["home"][..], &["shell"], &["jog"]] {
        let fixture = Fixture::new();
        match way {
            ["shell"] => {
                let done = Run::of(&mut fixture.command(way), b"home\n");
                assert_eq!(done.status, 0, "{done:?}");
            }
            ["jog"] => {
                let mut terminal = fixture.person(way);
                terminal.until_drawn("0x00 ResetOccurred");
                terminal.types("h");
                terminal.until_drawn("y/n");
                terminal.types("y");
                terminal.until_drawn("no alarm");
                terminal.types("q");
                assert!(terminal.child.wait().expect("it ends").success());
            }
            way => drop(fixture.does(way)),
        }
        fixture.does(&["run", "a.plan.json"]);
    }
}

#[test]
fn cancelled_homing_is_not_remembered() {
    let fixture = Fixture::new();
    fixture.does(&["home"]);
    fixture.does(&["run", "a.plan.json"]);
    // The homing waits in the queue and is dropped by the stop.
    fixture.does(&["enqueue", "HOMECmd"]);
    fixture.does(&["stop"]);
    fixture.refuses(&["run", "a.plan.json"]);
}

#[test]
fn two_arms_of_one_serial_number_are_kept_apart() {
    let (one, mut two) = (Fixture::new(), Fixture::new());
    // Both use the same memory of homings.
    let state = one.path("state");
    one.does(&["home"]);
    let at = |fixture: &Fixture| {
        let mut command = fixture.command(&["run", "a.plan.json"]);
        Run::of(command.env("XDG_STATE_HOME", &state), b"").status
    };
    assert_eq!((at(&one), at(&two)), (0, 3));
    two.power_cycle();
    assert_eq!((at(&one), at(&two)), (0, 3));
}

#[test]
fn doctor_reports_the_homing_state() {
    let fixture = Fixture::new();
    assert!(fixture.homed().starts_with("no, "));
    fixture.does(&["alarms", "--clear"]);
    assert!(fixture.homed().starts_with("unknown: "));
    fixture.does(&["home"]);
    assert!(fixture.homed().starts_with("yes, "));
    let fresh = Fixture::new();
    let alarms = fresh.does(&["alarms"]);
    assert!(alarms.out.contains("remedy: home the arm"), "{alarms:?}");
}

#[test]
fn station_and_its_clients_need_a_homed_arm_too() {
    let fixture = Fixture::new();
    let mut command = command();
    command.current_dir(fixture.dir.path());
    command.env("XDG_STATE_HOME", fixture.path("state"));
    let station = Served::of(
        command,
        "serve",
        &["--port", "./arm", "--listen", "127.0.0.1:0"],
        1,
    );
    let address = station.endpoint("http").replace("http:", "");
    let url = format!("http://{}", address.trim_matches('/'));
    let through = |arguments: &[&str]| {
        let mut command = fixture.command(arguments);
        // Memory of another computer: the station knows that the arm is homed.
        command.env("XDG_STATE_HOME", fixture.path("elsewhere"));
        command.args(["--station", &url]);
        Run::of(&mut command, b"")
    };
    let start = |options: &[(&str, Value)]| -> Value {
        let mut asked = json!({"text": plan(r#"{"move":[220,0,0,0],"by":"joints"}"#)});
        for (name, value) in options {
            asked[*name] = value.clone();
        }
        rpc(&url, "job.start", &asked)
    };
    let homed = || rpc(&url, "arm.state", &json!({}))["result"]["homed"].clone();
    for cleared in [false, true] {
        if cleared {
            rpc(&url, "arm.clear_alarms", &json!({}));
        }
        assert_eq!(homed(), if cleared { Value::Null } else { json!(false) });
        let refused = start(&[]);
        assert_eq!(refused["error"]["data"]["code"], "not-homed", "{refused}");
        assert_eq!(through(&["run", "a.plan.json"]).status, 3);
        // A surface is measured with a homed arm, so every front end asks for homing first.
        let drawn = |options: &[(&str, Value)]| {
            let line = fs::read_to_string(fixture.path("line.svg")).expect("a drawing");
            let mut asked = json!({"text": line, "setup": {"work": "draw"}});
            for (name, value) in options {
                asked[*name] = value.clone();
            }
            rpc(&url, "job.start", &asked)
        };
        let refused = drawn(&[]);
        assert_eq!(refused["error"]["data"]["code"], "not-homed", "{refused}");
        let refused = drawn(&[("unhomed", json!(true))]).to_string();
        assert!(refused.contains("work surface height unknown"), "{refused}");
        for (method, options) in [
            ("teach.capture", json!({})),
            ("teach.guide", json!({"on": true})),
        ] {
            let refused = rpc(&url, method, &options);
            assert_eq!(refused["error"]["data"]["code"], "not-homed", "{refused}");
        }
        let taken = rpc(&url, "teach.capture", &json!({"unhomed": true}));
        assert!(taken["result"]["step"].is_object(), "{taken}");
    }
    let begins = |options: &[(&str, Value)]| {
        let begun = start(options);
        let job = &begun["result"]["job"];
        assert!(job.is_string(), "{begun}");
        for _ in 0..500 {
            if rpc(&url, "job.get", &json!({"job": job}))["result"]["state"] == "done" {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("it is not done");
    };
    begins(&[("unhomed", json!(true))]);
    assert_eq!(through(&["run", "a.plan.json", "--unhomed"]).status, 0);
    rpc(&url, "arm.home", &json!({}));
    assert_eq!(homed(), json!(true));
    begins(&[]);
    let taken = rpc(&url, "teach.capture", &json!({}));
    assert!(taken["result"]["step"].is_object(), "{taken}");
    let done = through(&["run", "a.plan.json"]);
    assert_eq!(done.status, 0, "{done:?}");
    // The homing that the station saw is remembered on its computer.
    station.end("-TERM");
    fixture.does(&["run", "a.plan.json"]);
}

#[test]
fn height_measured_by_a_page_applies_to_every_front_end() {
    let fixture = Fixture::new();
    let mut command = fixture.command(&[]);
    command.env("MAGICIAN_TOKEN", "");
    let served = Served::of(command, "serve", &["--listen", "127.0.0.1:0"], 1);
    let url = served.endpoint("http");
    let call = |method: &str, params: Value| rpc(url.trim_end_matches('/'), method, &params);
    let drawing = || {
        let text = std::fs::read_to_string(fixture.path("line.svg")).expect("a file");
        json!({"text": text, "setup": {"work": "draw"}, "preview": true})
    };

    // The remedy for an unknown height is data, as on the command line.
    let unknown = call("job.check", drawing());
    let told = fixture
        .run(&["draw", "line.svg", "--check", "--json"])
        .error();
    assert_eq!(unknown["error"]["data"]["remedies"], told["remedies"]);
    let acts = |action: &str| {
        let remedies = told["remedies"].as_array().expect("remedies").clone();
        remedies.iter().any(|remedy| remedy["action"] == action)
    };
    assert!(acts("touch-off") && acts("calibrate-surface"), "{told}");

    // Touching with an unhomed arm gives no measurement.
    let unhomed = call("surface.touch", json!({}));
    assert_eq!(
        unhomed["error"]["data"]["code"],
        json!("not-homed"),
        "{unhomed}"
    );
    assert_eq!(
        unhomed["error"]["data"]["remedies"][0]["action"],
        json!("home")
    );

    call("arm.home", json!({}));
    let down = call("arm.move", json!({"to": [220, 0, -52.5, 0]}));
    assert!(down.get("error").is_none(), "{down}");
    let touched = call("surface.touch", json!({}));
    let z = touched["result"]["plane"]["z"].as_f64().expect("a height");
    assert!((z + 52.5).abs() < 0.02, "{touched}");
    let checked = call("job.check", drawing());
    assert_eq!(checked["result"]["ok"], json!(true), "{checked}");
    drop(served);

    let config = std::fs::read_to_string(fixture.path("config.toml")).expect("settings");
    assert_eq!(config, format!("surface = {z}\n"));
    let shown = fixture.does(&["calibrate", "show", "--json"]).object();
    assert_eq!(shown["surface"].as_f64(), Some(z));
    let report = fixture
        .does(&["draw", "line.svg", "--check", "--json"])
        .object();
    assert_eq!(report["ok"], json!(true), "{report}");
}
