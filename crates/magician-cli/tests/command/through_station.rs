//! Every verb through a station: output and exit status as at a port, or a message why not.
#![cfg(target_os = "linux")]

use magician_station::MAX_SOCKETS;
use magician_station::client::StationClient;
use serde_json::Value;

use crate::magician::served::Served;
use crate::magician::terminal::Terminal;
use crate::magician::{Run, command, run, run_with};

/// Way in which a verb works through a station.
enum Through {
    /// Lines that give the same results when run one after the other on one arm. A line `<<` has its
    /// input after it.
    Same(&'static [&'static [&'static str]]),
    /// Interactive: the command line, keys with their effects, and keys that end it.
    Pad(
        &'static [&'static str],
        &'static [(&'static str, &'static str)],
        &'static str,
    ),
    /// Refused, because the verb needs its own lines or arms.
    Refuses(&'static [&'static str]),
    /// Works differently from all others.
    Own(&'static [&'static str]),
    /// Needs no arm and works without one.
    NoArm(&'static [&'static str]),
}

use Through::{NoArm, Own, Pad, Refuses, Same};

/// All verbs of the command.
const VERBS: &[(&str, &[Through])] = &[
    ("ports", &[NoArm(&["ports", "--json"])]),
    ("info", &[Same(&[&["info", "--json"], &["info"]])]),
    ("pose", &[Same(&[&["pose", "--json"], &["pose"]])]),
    ("watch", &[Pad(&["watch"], &[("", "x 259.10")], "q")]),
    (
        "alarms",
        &[Same(&[
            &["alarms", "--json"],
            &["alarms"],
            &["alarms", "--clear", "--json"],
            &["alarms"],
        ])],
    ),
    ("doctor", &[Own(&["doctor", "--json"])]),
    (
        "sensor",
        &[Same(&[
            &["sensor", "color", "gp1", "--json"],
            &["sensor", "infrared", "gp4"],
            &["sensor", "infrared", "gp4", "--off", "--json"],
        ])],
    ),
    (
        "record",
        &[Same(&[
            &["record", "arm.csv", "--for", "0.3", "--json"],
            &["record", "arm.nonsense", "--for", "0.1"],
        ])],
    ),
    ("home", &[Same(&[&["home", "--json"], &["pose", "--json"]])]),
    (
        "move",
        &[Same(&[
            &["move", "220", "40", "30", "--json"],
            &["move", "220", "0", "30", "--linear"],
            &["move", "600", "0", "0", "--json"],
            &["move", "220", "-40", "30", "--no-wait", "--json"],
        ])],
    ),
    (
        "jog",
        &[
            Same(&[
                &["jog", "x", "-10", "--json"],
                &["jog", "j1", "5"],
                &["jog", "x", "500", "--json"],
            ]),
            Pad(
                &["jog"],
                &[("\u{1b}[A", "x 264.10"), ("?", "stop all motion")],
                "xq",
            ),
        ],
    ),
    (
        "stop",
        &[Same(&[
            &["stop", "--json"],
            &["stop"],
            &["stop", "--gentle"],
        ])],
    ),
    (
        "suction",
        &[Same(&[&["suction", "on", "--json"], &["suction", "off"]])],
    ),
    (
        "gripper",
        &[Same(&[
            &["gripper", "close", "--json"],
            &["gripper", "open"],
            &["gripper", "off", "--json"],
        ])],
    ),
    (
        "laser",
        &[Same(&[
            &["laser", "on", "--for", "0.1"],
            &["laser", "on", "--for", "0.1", "--yes", "--json"],
            &["get", "EndEffectorLaser", "--json"],
            &["laser", "off", "--json"],
            &["get", "EndEffectorLaser", "--json"],
        ])],
    ),
    (
        "io",
        &[Same(&[
            &["io", "list", "--json"],
            &["io", "mux", "10", "digital-output"],
            &["io", "set", "10", "1", "--json"],
            &["io", "get", "10", "--json"],
            &["io", "adc", "99"],
        ])],
    ),
    (
        "rail",
        &[Same(&[
            &["rail", "--json"],
            &["rail", "to", "100"],
            &["rail", "on", "--json"],
            &["rail", "to", "100", "--json"],
            &["rail", "by", "-20"],
            &["rail", "off"],
        ])],
    ),
    (
        "conveyor",
        &[Same(&[
            &["shell", "--json", "<<", "conveyor run 50\nconveyor stop\n"],
            &["conveyor", "by", "-20", "--speed", "40"],
            &["conveyor", "stop", "--json"],
        ])],
    ),
    (
        "draw",
        &[Same(&[
            &["draw", "line.svg", "--surface", "-50", "--check", "--json"],
            &["draw", "line.svg", "--surface", "-50"],
            &["home"],
            &["draw", "line.svg", "--surface", "-50", "--json"],
            &["draw", "line.svg", "--surface", "-50", "--scale", "20"],
        ])],
    ),
    (
        "engrave",
        &[Same(&[
            &["home"],
            &["engrave", "line.svg", "--surface", "-50"],
            &["engrave", "line.svg", "--surface", "-50", "--yes", "--json"],
        ])],
    ),
    (
        "frame",
        &[Same(&[
            &["frame", "line.svg", "--surface", "-50"],
            &["home"],
            &["frame", "line.svg", "--surface", "-50", "--json"],
            &["frame", "line.svg", "--surface", "-50", "--shape", "hull"],
        ])],
    ),
    (
        "testgrid",
        &[Same(&[
            &["home"],
            &["testgrid", "--surface", "-50", "--check", "--json"],
            &["testgrid", "--surface", "-50", "--cell", "2", "--json"],
        ])],
    ),
    (
        "write",
        &[Same(&[
            &[
                "write",
                "Hi",
                "--size",
                "5",
                "--surface",
                "-50",
                "--check",
                "--json",
            ],
            &["write", "Hi", "--size", "5", "--surface", "-50"],
            &["home"],
            &["write", "Hi", "--size", "5", "--surface", "-50", "--json"],
            &["write", "\u{4e2d}", "--strict-text", "--surface", "-50"],
        ])],
    ),
    (
        "run",
        &[Same(&[
            &["run", "moves.plan.json", "--json"],
            &["run", "moves.plan.json", "--loops", "2"],
            &["run", "moves.plan.json", "--resume"],
            &["run", "far.plan.json", "--json"],
            &["run", "nowhere.plan.json"],
        ])],
    ),
    (
        "convert",
        &[NoArm(&["convert", "moves.plan.json", "moves.csv"])],
    ),
    (
        "calibrate",
        &[
            NoArm(&["calibrate", "show", "--json"]),
            Pad(
                &["calibrate", "surface", "--tool", "pen"],
                &[("?", "stop all motion")],
                "xq",
            ),
        ],
    ),
    ("demo", &[Refuses(&["demo"])]),
    (
        "teach",
        &[Pad(
            &["teach", "shown.plan.json"],
            &[
                ("\r", "P1 stored"),
                ("\u{1b}[A", "x 264.10"),
                ("", "stands"),
                ("\r", "2 rows"),
            ],
            "qn",
        )],
    ),
    (
        "play",
        &[Same(&[
            &["play", "moves.plan.json", "--json"],
            &["play", "-", "--format", "plan", "<<", PLAN],
        ])],
    ),
    ("serve", &[Refuses(&["serve"])]),
    ("studio", &[Refuses(&["studio", "--no-open"])]),
    (
        "station",
        &[NoArm(&["station", "token", "--list", "--json"])],
    ),
    ("fleet", &[Refuses(&["fleet", "--site", "lab", "list"])]),
    ("site", &[Refuses(&["site", "list"])]),
    ("sim", &[Refuses(&["sim"])]),
    ("proxy", &[Refuses(&["proxy", "--tcp", "127.0.0.1:0"])]),
    (
        "shell",
        &[Same(&[
            &[
                "shell",
                "--json",
                "<<",
                "pose\nmove 220 40 30\nsuction on\nget PTPCommonParams\nqueue status\n",
            ],
            &[
                "shell",
                "--keep-going",
                "<<",
                "move 600 0 0\npose\nlaser on\n",
            ],
        ])],
    ),
    (
        "get",
        &[Same(&[
            &["get", "PTPCommonParams", "--json"],
            &["get", "Pose"],
            &["get", "IODI", "address=3", "--json"],
            &["get", "Nonsense", "--json"],
        ])],
    ),
    (
        "set",
        &[Same(&[
            &[
                "set",
                "PTPCommonParams",
                "velocity_ratio=80",
                "acceleration_ratio=60",
                "--json",
            ],
            &["get", "PTPCommonParams"],
            &["set", "PTPCommonParams", "velocity_ratio=nan"],
            &["set", "EndEffectorLaser", "enable_ctrl=1", "on=1"],
            &["set", "DeviceSN", "device_sn=1"],
        ])],
    ),
    (
        "enqueue",
        &[Same(&[&[
            "enqueue",
            "WAITCmd",
            "timeout=10",
            "--start",
            "--json",
        ]])],
    ),
    (
        "queue",
        &[Same(&[
            &["queue", "status", "--json"],
            &["queue", "stop"],
            &["enqueue", "WAITCmd", "timeout=10"],
            &["queue", "status"],
            &["queue", "clear", "--json"],
            &["queue", "start", "--json"],
        ])],
    ),
    ("commands", &[NoArm(&["commands", "PTPCmd", "--json"])]),
    ("decode", &[NoArm(&["decode", "aa aa 02 0a 00 f6"])]),
    ("replay", &[Refuses(&["replay", "moves.plan.json"])]),
    ("conform", &[Refuses(&["conform"])]),
    ("bench", &[Refuses(&["bench"])]),
    (
        "forward",
        &[NoArm(&["forward", "0", "45", "45", "0", "--json"])],
    ),
    (
        "inverse",
        &[NoArm(&["inverse", "220", "0", "30", "0", "--json"])],
    ),
    ("preset", &[NoArm(&["preset", "list", "--json"])]),
    ("config", &[NoArm(&["config", "--json"])]),
    ("completions", &[NoArm(&["completions", "bash"])]),
    ("man", &[NoArm(&["man"])]),
    ("help", &[NoArm(&["help", "pose"])]),
];

const PLAN: &str = r#"{"format":"magician-plan","version":1,"title":"moves","steps":[
{"move":[220,20,50,0],"by":"line"},
{"move":[220,-20,50,0],"by":"line"}
]}
"#;
const SVG: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' viewBox='0 0 20 20'>\
    <path d='M2 5 L18 5 L2 15' fill='none' stroke='black'/></svg>";

/// Arm behind a port, optionally with a station, and the files of the lines.
struct Fixture {
    dir: tempfile::TempDir,
    /// `--port` or `--station`, and its value.
    way: [String; 2],
    _served: Vec<Served>,
}

impl Fixture {
    fn new(by_station: bool) -> Self {
        let dir = tempfile::tempdir().expect("directory");
        for (name, text) in [
            ("line.svg", SVG.to_owned()),
            ("moves.plan.json", PLAN.to_owned()),
            ("far.plan.json", PLAN.replace("220", "620")),
        ] {
            std::fs::write(dir.path().join(name), text).expect("written");
        }
        let port = dir.path().join("arm").to_str().expect("UTF-8").to_owned();
        let mut served = vec![Served::start(&["--pty", &port, "--speed", "20"], 1)];
        let mut way = ["--port".to_owned(), port.clone()];
        if by_station {
            let listen = ["--port", &port, "--listen", "127.0.0.1:0"];
            let station = Served::verb("serve", &listen, 1);
            let url = station.endpoint("http").trim_end_matches('/').to_owned();
            way = ["--station".to_owned(), url];
            served.push(station);
        }
        Self {
            dir,
            way,
            _served: served,
        }
    }

    /// Creates a place, homed if the verb needs that.
    fn homed_for(verb: &str, by_station: bool) -> Self {
        let fixture = Self::new(by_station);
        let needs = [
            "draw",
            "engrave",
            "write",
            "frame",
            "testgrid",
            "run",
            "play",
            "teach",
            "calibrate",
        ];
        if needs.contains(&verb) {
            let homed = fixture.run(&["home"]);
            assert_eq!(homed.status, 0, "{homed:?}");
        }
        fixture
    }

    fn command(&self, words: &[&str]) -> std::process::Command {
        let mut command = command();
        command.args(&self.way).args(words);
        command.current_dir(self.dir.path());
        command.env("XDG_STATE_HOME", self.dir.path().join("state"));
        command
    }

    fn run(&self, words: &[&str]) -> Run {
        let (words, input) = match words.iter().position(|word| *word == "<<") {
            Some(at) => (&words[..at], words[at + 1]),
            None => (words, ""),
        };
        let run = Run::of(&mut self.command(words), input.as_bytes());
        let dir = self.dir.path().to_str().expect("UTF-8");
        Run {
            status: run.status,
            out: run.out.replace(dir, "DIR"),
            err: run.err.replace(dir, "DIR").replace(&self.way[1], "PLACE"),
        }
    }

    fn pad(&self, words: &[&str], keys: &[(&str, &str)], end: &str) -> (i32, Value) {
        let mut terminal = Terminal::running(self.command(words));
        terminal.until("\x1b[?1049h");
        terminal.until_drawn("link up");
        for (keys, shown) in keys {
            terminal.types(keys);
            terminal.until_drawn(shown);
        }
        terminal.types(end);
        terminal.until("\x1b[?1049l");
        let ended = terminal.child.wait().expect("it ends");
        let pose = self.run(&["pose", "--json"]).object();
        (ended.code().expect("not killed"), pose)
    }
}

/// Returns the output without parts that differ between runs: times, and the arm's name.
fn told(run: &Run) -> (i32, Vec<Value>, String, Value) {
    let mut objects = Vec::new();
    let mut text = String::new();
    for line in run.out.lines() {
        match serde_json::from_str::<Value>(line) {
            // The number of progress events depends on the clock.
            Ok(Value::Object(object))
                if object.get("event").is_some_and(|event| event == "progress") => {}
            Ok(Value::Object(mut object)) => {
                for name in ["uptime_ms", "seconds", "readings", "port", "device_sn"] {
                    object.remove(name);
                }
                objects.push(Value::Object(object));
            }
            _ if ["port ", "serial number", "switched on"]
                .iter()
                .any(|name| line.starts_with(name)) => {}
            // The duration in "done in 0:04: 2 steps" depends on the clock.
            _ => match line.split_once(": ") {
                Some((head, rest)) if head.starts_with("done in") => text += rest,
                _ => text += &format!("{line}\n"),
            },
        }
    }
    let error: Value = serde_json::from_str(&run.err).unwrap_or_default();
    (run.status, objects, text, error["error"]["kind"].clone())
}

/// Returns the verbs that the command lists.
fn verbs() -> Vec<String> {
    let help = run(&["help"]).out;
    let lines = help.lines().take_while(|line| *line != "Options:");
    let verb = |line: &str| {
        let name = line.strip_prefix("  ")?.split(' ').next()?;
        (!name.is_empty()).then(|| name.to_owned())
    };
    lines.filter_map(verb).collect()
}

#[test]
fn every_verb_is_in_the_list() {
    let mut listed: Vec<_> = VERBS.iter().map(|(verb, _)| (*verb).to_owned()).collect();
    let mut all = verbs();
    if !cfg!(feature = "site") {
        // They exist but are not listed.
        all.extend(["fleet", "site"].map(str::to_owned));
    }
    listed.sort();
    all.sort();
    assert_eq!(listed, all);
}

fn of_kind<T>(
    wanted: impl Fn(&'static Through) -> Option<T>,
) -> impl Iterator<Item = (&'static str, T)> {
    VERBS.iter().flat_map(move |(verb, ways)| {
        let found: Vec<_> = ways.iter().filter_map(&wanted).collect();
        found.into_iter().map(|found| (*verb, found))
    })
}

#[test]
fn lines_do_the_same_through_a_station() {
    let mut differ = Vec::new();
    for (verb, lines) in of_kind(|way| match way {
        Same(lines) => Some(*lines),
        _ => None,
    }) {
        let (at_port, through) = (
            Fixture::homed_for(verb, false),
            Fixture::homed_for(verb, true),
        );
        for words in lines {
            let (here, there) = (at_port.run(words), through.run(words));
            if told(&here) != told(&there) {
                differ.push(format!(
                    "{verb}: {words:?}\nat the port {here:#?}\nthrough a station {there:#?}"
                ));
            }
        }
    }
    assert!(differ.is_empty(), "{}", differ.join("\n\n"));
}

#[test]
fn pads_do_the_same_through_a_station() {
    for (verb, (words, keys, end)) in of_kind(|way| match way {
        Pad(words, keys, end) => Some((*words, *keys, *end)),
        _ => None,
    }) {
        let (at_port, through) = (
            Fixture::homed_for(verb, false),
            Fixture::homed_for(verb, true),
        );
        assert_eq!(
            at_port.pad(words, keys, end),
            through.pad(words, keys, end),
            "{verb}"
        );
    }
}

#[test]
fn verbs_with_own_lines_are_refused_at_a_station() {
    let fixture = Fixture::new(true);
    for (verb, words) in of_kind(|way| match way {
        Refuses(words) => Some(*words),
        _ => None,
    }) {
        let refused = fixture.run(words);
        assert_eq!(refused.status, 2, "{verb} {refused:?}");
        assert!(refused.err.contains("--station"), "{verb} {refused:?}");
    }
}

#[test]
fn verbs_that_differ_at_a_station_succeed() {
    let fixture = Fixture::new(true);
    for (verb, words) in of_kind(|way| match way {
        Own(words) => Some(*words),
        _ => None,
    }) {
        let done = fixture.run(words);
        assert_eq!(done.status, 0, "{verb} {done:?}");
    }
}

#[test]
fn verbs_without_an_arm_do_not_connect_to_a_station() {
    let fixture = Fixture::new(false);
    for (verb, words) in of_kind(|way| match way {
        NoArm(words) => Some(*words),
        _ => None,
    }) {
        let nowhere = [&["--station", "http://127.0.0.1:1"][..], words].concat();
        let mut command = command();
        command.args(&nowhere).current_dir(fixture.dir.path());
        let there = Run::of(&mut command, b"");
        assert_eq!(there.status, 0, "{verb} {there:?}");
    }
}

#[test]
fn file_errors_are_reported_before_connecting_to_a_station() {
    let fixture = tempfile::tempdir().unwrap();
    let file = fixture.path().join("empty.svg");
    std::fs::write(&file, "").unwrap();
    let file = file.to_str().unwrap();
    for verb in ["draw", "engrave", "run"] {
        let told = run(&["--station", "http://127.0.0.1:1", verb, file]);
        assert!(told.err.contains("the file is empty"), "{told:?}");
    }
}

#[test]
fn virtual_arm_of_a_station_counts_as_virtual() {
    let station = Served::verb("serve", &["--port", "sim:20", "--listen", "127.0.0.1:0"], 1);
    let url = station.endpoint("http").trim_end_matches('/').to_owned();
    for words in [
        &["laser", "on", "--for", "0.1", "--json"][..],
        &["set", "EndEffectorLaser", "enable_ctrl=1", "on=0", "--json"],
    ] {
        let here = run(&[&["--port", "sim"], words].concat());
        let there = run_with(&[&["--station", &url], words].concat(), b"");
        assert_eq!(told(&here), told(&there), "{words:?}");
        assert_eq!(there.status, 0, "{there:?}");
    }
}

/// A refusal is reported in the station's words, which the arm's line could not give.
#[test]
fn lease_holder_is_reported_once() {
    let station = Served::verb("serve", &["--port", "sim", "--listen", "127.0.0.1:0"], 1);
    let url = station.endpoint("http").trim_end_matches('/').to_owned();
    let mut holder = command();
    holder.args(["--station", &url, "laser", "on"]);
    let mut holder = Terminal::running(holder);
    holder.until("laser: on");
    let refused = run(&["--station", &url, "suction", "on", "--json"]);
    assert_eq!(refused.status, 4, "{refused:?}");
    // Once, and with the next step.
    assert_eq!(refused.err.lines().count(), 1, "{refused:?}");
    assert!(
        refused.err.contains("magician has the lease"),
        "{refused:?}"
    );
    assert!(!refused.err.contains("lease.ask"), "{refused:?}");
    let refused = run(&["--station", &url, "suction", "on"]);
    let next = "hint: try again when magician has released the arm";
    assert!(refused.err.contains(next), "{refused:?}");
    assert!(!refused.err.contains("cable"), "{refused:?}");
    assert_eq!(run(&["--station", &url, "stop"]).status, 0);
    holder.types("\x04");
    holder.child.wait().expect("it ends");
}

#[test]
fn stop_works_at_a_station_that_refuses_sessions() {
    let station = Served::verb("serve", &["--port", "sim", "--listen", "127.0.0.1:0"], 1);
    let url = station.endpoint("http").trim_end_matches('/').to_owned();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.expect("a runtime");
    let _all: Vec<_> = (0..MAX_SOCKETS)
        .map(|_| {
            runtime
                .block_on(StationClient::connect(&url, "Anna", None))
                .expect("a session")
        })
        .collect();
    let look = run(&["--station", &url, "pose"]);
    assert_eq!(look.status, 4, "{look:?}");
    assert!(
        look.err
            .contains("serves nobody more now: the station has all"),
        "{look:?}"
    );
    let stop = run(&["--station", &url, "stop"]);
    assert_eq!(stop.status, 0, "{stop:?}");
    assert!(stop.out.starts_with("stopped: x  259.10"), "{stop:?}");
    assert!(stop.err.contains("no session at the station"), "{stop:?}");
    let gentle = run(&["--station", &url, "stop", "--gentle"]);
    assert_eq!(gentle.status, 4, "{gentle:?}");
}
