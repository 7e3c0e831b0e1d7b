//! `magician sim` as other programs use it: a process with endpoints.
#![cfg(unix)]

use crate::magician;
use std::net::UdpSocket;
use std::path::Path;
use std::time::Duration;

use crate::magician::run;
use crate::magician::served::Served;
use serde_json::json;

#[test]
fn all_endpoints_reach_the_same_arm() {
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
    let (udp, tcp) = (served.endpoint("udp"), served.endpoint("tcp"));
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
fn interrupt_exits_with_130() {
    let served = Served::start(&["--udp", "127.0.0.1:0"], 1);
    let (status, rest) = served.end("-INT");
    assert_eq!((status.code(), rest.as_str()), (Some(130), ""));
}

#[test]
fn several_arms_are_served_by_one_process() {
    let dir = tempfile::tempdir().expect("directory");
    let inside = |name: &str| dir.path().join(name).to_str().expect("UTF-8").to_owned();
    let (path, trace) = (inside("arm"), inside("trace"));
    let arguments = [
        "--arms", "3", "--pty", &path, "--trace", &trace, "--speed", "max",
    ];
    let served = Served::start(&arguments, 5);
    let name = |number: u32| {
        let port = format!("{path}.{number}");
        run(&["--port", &port, "get", "DeviceName", "--json"]).object()["device_name"].clone()
    };
    for number in 1..=3 {
        assert_eq!(name(number), json!(format!("Dobot 2.0 #{number}")));
        let serving = format!("arm {number}: serving {path}.{number} ");
        let said = served
            .endpoints
            .iter()
            .any(|line| line.starts_with(&serving));
        assert!(said, "{:?}", served.endpoints);
    }
    let (status, rest) = served.end("-TERM");
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));
    for number in 1..=3 {
        assert!(!Path::new(&format!("{path}.{number}")).is_symlink());
        let decoded = run(&["decode", "--json", &format!("{trace}.{number}")]);
        let told = decoded.objects();
        let named = told
            .iter()
            .filter(|told| told["command"] == "GetDeviceName");
        assert_eq!((decoded.status, named.count()), (0, 2), "{told:?}");
    }
}

#[test]
fn failure_of_one_arm_cleans_up_the_others() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("arm");
    let taken = dir.path().join("arm.2");
    std::fs::write(&taken, "mine").expect("written");
    let path = path.to_str().expect("UTF-8");
    let refused = run(&["sim", "--arms", "3", "--pty", path]);
    assert_eq!((refused.status, refused.out.as_str()), (4, ""));
    let left = std::fs::read_dir(dir.path()).expect("directory").count();
    assert_eq!(left, 1);
}

#[test]
fn trace_contains_the_traffic() {
    let dir = tempfile::tempdir().expect("directory");
    let trace = dir.path().join("trace.pcapng");
    let path = trace.to_str().expect("UTF-8");
    let served = Served::start(&["--tcp", "127.0.0.1:0", "--trace", path], 1);
    let port = served.endpoint("tcp");
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
fn failed_endpoint_is_an_error_and_leaves_no_files() {
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

/// Searches for an arm as a program does.
fn discovered(address: &str) -> String {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("socket");
    let deadline = Some(Duration::from_secs(120));
    socket.set_read_timeout(deadline).expect("deadline");
    socket.send_to(b"Who is Dobot?", address).expect("sent");
    let mut answer = [0; 128];
    let count = socket.recv(&mut answer).expect("an answer");
    String::from_utf8_lossy(&answer[..count]).into_owned()
}

#[test]
fn discovery_finds_the_arm() {
    let arguments = ["--udp", "127.0.0.1:0", "--discovery", "127.0.0.1:0"];
    let served = Served::start(&arguments, 2);
    let endpoint = served.endpoint("discovery");
    let address = endpoint.trim_start_matches("discovery:");
    let answer = discovered(address);
    assert!(answer.starts_with("127.0.0.1,02"), "{answer}");

    let taken = run(&["sim", "--udp", "127.0.0.1:0", "--discovery", address]);
    assert_eq!((taken.status, taken.out.as_str()), (4, ""));
    let alone = run(&["sim", "--tcp", "127.0.0.1:0", "--discovery", address]);
    assert_eq!((alone.status, alone.out.as_str()), (2, ""));
}

/// On another loopback address, which only Linux has.
#[cfg(target_os = "linux")]
#[test]
fn default_port_is_discovered_unless_in_use() {
    let [_, a, b, c] = std::process::id().to_be_bytes();
    let host = format!("127.{}.{b}.{c}", 200 + a % 16);
    let first = Served::start(&["--udp", &host], 2);
    assert!(discovered(&format!("{host}:48899")).starts_with(&host));
    drop(first);

    let _another = UdpSocket::bind(format!("{host}:48899")).expect("socket");
    let second = Served::start(&["--udp", &host], 2);
    assert!(
        second.endpoints[0].starts_with("note: "),
        "{:?}",
        second.endpoints
    );
    assert_eq!(second.endpoint("udp"), format!("udp:{host}:8899"));
    drop(second);

    let hidden = Served::start(&["--udp", &host, "--discovery", "off"], 1);
    assert_eq!(hidden.endpoints.len(), 2);
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
    let name = run(&[
        "--port",
        &served.endpoint("tcp"),
        "get",
        "DeviceName",
        "--json",
    ])
    .object();
    assert_eq!(name, json!({"device_name": "Somebody"}));
}

#[test]
fn every_arm_has_a_recording_of_its_own() {
    let dir = tempfile::tempdir().expect("directory");
    let recording = dir.path().join("arm.mcap");
    let path = recording.to_str().expect("UTF-8");
    let arguments = ["--arms", "2", "--tcp", "127.0.0.1:0", "--record", path];
    // Each of two arms prints its title and one endpoint.
    let served = Served::start(&arguments, 3);
    served.end("-TERM");
    for number in [1, 2] {
        let file = std::fs::read(format!("{path}.{number}")).expect("a recording");
        let magic = b"\x89MCAP0\r\n";
        assert!(file.starts_with(magic) && file.ends_with(magic));
        let told = |text: &str| {
            file.windows(text.len())
                .any(|bytes| bytes == text.as_bytes())
        };
        assert!(told("foxglove.PoseInFrame") && told("ResetOccurred"));
    }
    assert!(!recording.exists());
}

#[test]
fn recording_that_cannot_start_is_an_error() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("no").join("such.mcap");
    let path = path.to_str().expect("UTF-8");
    let refused = run(&["sim", "--udp", "127.0.0.1:0", "--record", path, "--json"]);
    assert_eq!((refused.status, refused.out.as_str()), (3, ""));
    assert_eq!(refused.error()["kind"], "invalid-input");
}

#[test]
fn flash_content_is_stored_in_its_file() {
    let dir = tempfile::tempdir().expect("directory");
    let flash = dir.path().join("flash.toml");
    let path = flash.to_str().expect("UTF-8");
    let arguments = ["--tcp", "127.0.0.1:0", "--flash", path];
    let name = |port: &str| {
        run(&["--port", port, "get", "DeviceName", "--json"]).object()["device_name"].clone()
    };
    let served = Served::start(&arguments, 1);
    assert!(flash.exists(), "it is made at once");
    let port = served.endpoint("tcp");
    assert_eq!(name(&port), json!("Dobot 2.0"));
    let set = ["--port", &port, "set", "DeviceName", "device_name=Ada"];
    assert_eq!(run(&set).status, 0);
    let (status, rest) = served.end("-TERM");
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));

    let served = Served::start(&arguments, 1);
    assert_eq!(name(&served.endpoint("tcp")), json!("Ada"));
    served.end("-TERM");

    std::fs::write(&flash, "version = 1").expect("written");
    let refused = run(&["sim", "--tcp", "127.0.0.1:0", "--flash", path]);
    assert_eq!(refused.status, 3, "{refused:?}");
    let left = std::fs::read_to_string(&flash).expect("left alone");
    assert_eq!(left, "version = 1");
}

#[test]
fn strict_arm_refuses_choices_and_reports_its_assumptions() {
    let arguments = [
        "--tcp",
        "127.0.0.1:0",
        "--speed",
        "max",
        "--strict",
        "--fidelity",
    ];
    let served = Served::start(&arguments, 1);
    let port = served.endpoint("tcp");
    assert_eq!(run(&["--port", &port, "home"]).status, 0);
    assert_eq!(run(&["--port", &port, "move", "220", "30", "20"]).status, 0);
    assert_eq!(run(&["--port", &port, "get", "HOMEParams"]).status, 6);
    let log = served.log();
    let told = |what: &str| log.iter().any(|line| line.contains(what));
    assert!(
        told("HOMEParams not carried out: it relies on a choice (model 15a): "),
        "{log:?}"
    );
    assert!(
        told(" M  model 11   homing turns J1 to its switch"),
        "{log:?}"
    );
    assert!(
        told(" G  model 15a  until set, HOMEParams read as"),
        "{log:?}"
    );
    assert!(told("section N of docs/reference/MODEL.md"), "{log:?}");
}

#[test]
fn fidelity_report_is_an_object_with_json() {
    let arguments = ["--json", "--tcp", "127.0.0.1:0", "--fidelity"];
    let mut child = magician::command()
        .arg("sim")
        .args(arguments)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut ready = String::new();
    let mut stdout = std::io::BufReader::new(child.stdout.take().expect("stdout"));
    std::io::BufRead::read_line(&mut stdout, &mut ready).expect("a line");
    let end = std::process::Command::new("kill")
        .arg(child.id().to_string())
        .status();
    assert!(end.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    let told: serde_json::Value = serde_json::from_slice(&output.stderr).expect("an object");
    let bases = told["fidelity"].as_array().expect("a list");
    let alarm = bases.iter().find(|basis| basis["basis"] == "ResetAlarm");
    let alarm = alarm.expect("it is there");
    assert_eq!(alarm["uses"], 1);
    assert_eq!(alarm["page"], "docs/reference/MODEL.md#section-11");
}

/// Pen above paper.
const PAPER: &str = "tool = { kind = \"pen\" }\ntable = { height = -60 }\narm = { homed = true }\n";

#[test]
fn unwritable_picture_is_reported_before_drawing() {
    let dir = tempfile::tempdir().expect("directory");
    let inside = |name: &str| dir.path().join(name).to_str().expect("UTF-8").to_owned();
    let (scenario, old) = (inside("paper.toml"), inside("old.svg"));
    std::fs::write(&scenario, PAPER).expect("written");
    std::fs::write(&old, "what was drawn before").expect("written");
    let sim = |picture: &str, more: &[&str]| {
        let mut arguments = vec!["sim", "--scenario", &scenario, "--picture", picture];
        arguments.extend(more);
        run(&arguments)
    };
    for picture in [inside("missing/a.svg"), inside("paper.toml/a.png")] {
        let refused = sim(&picture, &["--tcp", "127.0.0.1:0"]);
        assert_eq!(
            (refused.status, refused.out.as_str()),
            (3, ""),
            "{refused:?}"
        );
        assert!(refused.err.contains("cannot be written"), "{refused:?}");
    }
    // Checking that it can be written leaves no file.
    for picture in [&old, &inside("new.svg")] {
        assert_eq!(sim(picture, &["--tcp", "nowhere"]).status, 3);
    }
    assert_eq!(
        std::fs::read_to_string(&old).expect("there"),
        "what was drawn before"
    );
    assert_eq!(std::fs::read_dir(dir.path()).expect("directory").count(), 2);
}

#[test]
fn drawing_is_saved_elsewhere_if_its_folder_is_gone() {
    let dir = tempfile::tempdir().expect("directory");
    let scenario = dir.path().join("paper.toml");
    let gone = dir.path().join("gone");
    std::fs::write(&scenario, PAPER).expect("written");
    std::fs::create_dir(&gone).expect("made");
    let picture = gone.join("drawing.svg");
    let (scenario, picture) = (
        scenario.to_str().expect("UTF-8"),
        picture.to_str().expect("UTF-8"),
    );
    let arguments = [
        "--tcp",
        "127.0.0.1:0",
        "--speed",
        "max",
        "--scenario",
        scenario,
        "--picture",
        picture,
    ];
    let served = Served::start(&arguments, 1);
    let port = served.endpoint("tcp");
    for [x, y, z] in [["220", "0", "-61"], ["260", "0", "-61"], ["260", "0", "0"]] {
        assert_eq!(
            run(&["--port", &port, "move", x, y, z, "--linear"]).status,
            0
        );
    }
    std::fs::remove_dir(&gone).expect("removed");
    let (status, _, said) = served.end_telling("-TERM");
    assert_eq!(status.code(), Some(3), "{said}");
    let (_, elsewhere) = said.split_once("the drawing is in ").expect(&said);
    let elsewhere = Path::new(elsewhere.trim());
    let drawn = std::fs::read_to_string(elsewhere).expect("saved");
    assert!(drawn.contains("L260 0\""), "{drawn}");
    std::fs::remove_file(elsewhere).expect("removed");
}

#[test]
fn each_of_several_arms_has_a_picture() {
    let dir = tempfile::tempdir().expect("directory");
    let scenario = dir.path().join("paper.toml");
    std::fs::write(&scenario, PAPER).expect("written");
    let picture = dir.path().join("drawing.png");
    let (scenario, picture) = (
        scenario.to_str().expect("UTF-8"),
        picture.to_str().expect("UTF-8"),
    );
    let arguments = [
        "--arms",
        "2",
        "--tcp",
        "127.0.0.1:0",
        "--scenario",
        scenario,
        "--picture",
        picture,
    ];
    let (status, said) = Served::start(&arguments, 4).end("-TERM");
    assert_eq!(status.code(), Some(0), "{said}");
    for name in ["drawing.1.png", "drawing.2.png"] {
        let bytes = std::fs::read(dir.path().join(name)).expect(name);
        assert!(bytes.starts_with(b"\x89PNG"));
    }
}

#[test]
fn trace_of_another_running_arm_is_not_overwritten() {
    let dir = tempfile::tempdir().expect("directory");
    for option in ["--trace", "--record"] {
        let file = dir.path().join("kept");
        let file = file.to_str().expect("UTF-8");
        let served = Served::start(&["--tcp", "127.0.0.1:0", option, file], 1);
        let port = served.endpoint("tcp");
        assert_eq!(run(&["--port", &port, "pose"]).status, 0);
        let second = run(&["sim", "--tcp", "127.0.0.1:0", option, file]);
        assert_eq!(second.status, 3, "{second:?}");
        assert!(second.err.contains("another program"), "{second:?}");
        served.end("-TERM");
        let length = std::fs::metadata(file).expect("there").len();
        assert!(length > 100, "{option}: {length} bytes");
    }
}

#[test]
fn arm_on_wifi_is_listed_with_its_port() {
    let endpoints = ["--udp", "127.0.0.1:0", "--discovery", "127.0.0.1:0"];
    let served = Served::start(&endpoints, 2);
    let endpoint = served.endpoint("discovery");
    let host = endpoint.strip_prefix("discovery:").expect("an address");
    let list = run(&["ports", "--wifi", host, "--json"]).object();
    assert!(list["ports"].is_array());
    assert_eq!(list["wifi"].as_array().map(Vec::len), Some(1), "{list}");
    assert_eq!(list["wifi"][0]["port"], "udp:127.0.0.1:8899");
    assert_eq!(list["wifi"][0]["name"], "USR-C322");
    let text = run(&["ports", "--wifi", host]).out;
    assert!(text.contains("udp:127.0.0.1:8899  an arm"), "{text}");
    assert_eq!(
        run(&["ports", "--local", "--json"]).object().get("wifi"),
        None
    );
    let (status, _) = served.end("-TERM");
    assert_eq!(status.code(), Some(0));
}

#[test]
fn sim_lists_its_built_in_scenarios_and_takes_them_by_name() {
    let names = ["cubes", "drawing", "pick_and_sort", "faults", "engraving"];
    let unknown = run(&["sim", "--tcp", "127.0.0.1:0", "--scenario", "nowhere"]);
    assert_eq!(unknown.status, 3, "{unknown:?}");
    let bare = run(&["sim", "--tcp", "127.0.0.1:0", "--picture", "a.svg"]);
    assert_eq!(bare.status, 2, "{bare:?}");
    assert!(bare.err.contains("--picture needs a scenario"), "{bare:?}");
    for verb in ["sim", "serve"] {
        let help = run(&[verb, "--help"]).out;
        for name in names {
            assert!(help.contains(name), "{verb} {name}: {help}");
        }
    }
    for name in names {
        assert!(
            unknown.err.contains(name) && bare.err.contains(name),
            "{name}"
        );
        let words = ["--tcp", "127.0.0.1:0", "--scenario", name];
        let served = Served::start(&words, 1);
        assert!(served.end("-TERM").0.success(), "{name}");
    }
}
