//! `magician replay`: a recorded session on a virtual arm and in the decoder.
#![cfg(unix)]

use crate::magician;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::magician::served::Served;
use crate::magician::{command, run};
use magician_motion::{self as motion, Geometry, ToolBias};
use magician_protocol::Direction::{Reply, Request};
use magician_protocol::commands::{JogCmd, Pose};
use magician_protocol::{Ctrl, Flag, FrameBuf, JogCommand, Set};
use magician_record::trace::{TraceWriter, read_trace};
use serde_json::{Value, json};

const GET_POSE: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];

/// Records a trace of a virtual arm with which a shell worked.
fn session(dir: &Path, speed: &str) -> PathBuf {
    let path = dir.join("session.pcapng");
    let trace = path.to_str().expect("UTF-8");
    let served = Served::start(
        &["--tcp", "127.0.0.1:0", "--speed", speed, "--trace", trace],
        1,
    );
    let port = served.endpoint("tcp");
    for words in [
        &["get", "DeviceTime"][..],
        &[
            "set",
            "PTPCommonParams",
            "velocity_ratio=100",
            "acceleration_ratio=100",
        ],
        &["move", "220", "30", "20", "0"],
        &["pose"],
        &["move", "200", "-30", "40", "0", "--linear"],
        &["pose"],
    ] {
        let run = run(&[&["--port", &port], words].concat());
        assert_eq!(run.status, 0, "{words:?}: {run:?}");
    }
    let (status, _) = served.end("-TERM");
    assert!(status.success());
    path
}

/// Writes a trace with these packets on one link.
fn written(path: &Path, packets: &[(u64, bool, &[u8])]) {
    let mut trace = TraceWriter::new(fs::File::create(path).expect("a file")).expect("begun");
    let link = trace.link("./arm").expect("a link");
    for (time, reply, bytes) in packets {
        let direction = if *reply { Reply } else { Request };
        trace
            .record(link, *time, direction, bytes)
            .expect("written");
    }
}

fn replay(arguments: &[&str], trace: &Path) -> magician::Run {
    run(&[&["replay", trace.to_str().expect("UTF-8")], arguments].concat())
}

#[test]
fn recorded_session_replays_equally() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = session(dir.path(), "max");
    // Values that depend on the exact microsecond of a poll are left out, since the process
    // followed the wall clock.
    let ignore = ["--clock", "max", "--ignore", "QueuedCmdCurrentIndex"];
    let first = replay(&[&ignore[..], &["--json"]].concat(), &path);
    assert_eq!(first.status, 0, "{first:?}");
    let summary = first.object();
    assert_eq!(summary["differences"], 0);
    assert!(summary["answers"].as_u64().is_some_and(|count| count > 20));
    assert_eq!(summary["answers"], summary["requests"]);
    assert_eq!(replay(&ignore, &path).out.lines().count(), 1);
}

#[test]
fn a_saved_session_is_the_same_as_itself() {
    let dir = tempfile::tempdir().expect("a directory");
    let (path, new) = (dir.path().join("old.pcapng"), dir.path().join("new.pcapng"));
    let bad = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF7];
    let noise = b"M10\r\n";
    let requests = [
        (5, false, &noise[..]),
        (9, false, &GET_POSE),
        (11, false, &bad),
        (12, false, &GET_POSE),
    ];
    written(&path, &requests);
    let run = replay(&["--save", new.to_str().expect("UTF-8")], &path);
    assert_eq!(run.status, 0, "{run:?}");
    let bytes = fs::read(&new).expect("saved");
    let packets: Vec<_> = read_trace(&bytes)
        .map(|packet| packet.expect("a packet"))
        .collect();
    let sent: Vec<u8> = (packets
        .iter()
        .filter(|packet| packet.direction == Some(Request)))
    .flat_map(|packet| packet.bytes.to_vec())
    .collect();
    assert_eq!(sent, requests.map(|(_, _, bytes)| bytes).concat());
    assert_eq!(
        packets
            .iter()
            .filter(|packet| packet.direction == Some(Reply))
            .count(),
        2
    );
    assert_eq!(packets[0].link_name, "./arm");
    let again = replay(&["--json"], &new);
    assert_eq!(again.status, 0, "{again:?}");
    assert_eq!(
        (
            again.object()["requests"].clone(),
            again.object()["answers"].clone()
        ),
        (json!(2), json!(2))
    );
}

#[test]
fn difference_has_both_values_and_exits_with_10() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("session.pcapng");
    // Pose of the vendor's document, at which this arm does not stand.
    let pose = [
        0xAA, 0xAA, 0x22, 0x0A, 0x00, 0xB0, 0x0A, 0x42, 0x43, 0x36, 0x85, 0x95, 0x42, 0x94, 0xE8,
        0x06, 0x43, 0xA0, 0x90, 0xA8, 0x41, 0xA0, 0x90, 0xA8, 0x41, 0x00, 0xB6, 0xBD, 0xBC, 0x98,
        0x0C, 0x12, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x0C,
    ];
    // Jog that was stopped before it began: the first pose then does not show the start.
    let stop = [0xAA, 0xAA, 0x04, 0x49, 0x01, 0x00, 0x00, 0xB6];
    let stopped = [0xAA, 0xAA, 0x02, 0x49, 0x01, 0xB6];
    written(
        &path,
        &[
            (1_000_000, false, &stop),
            (1_000_000, true, &stopped),
            (1_000_000, false, &GET_POSE),
            (1_000_400, true, &pose),
        ],
    );
    let told = replay(&[], &path);
    assert_eq!(told.status, 10);
    assert!(
        told.out
            .starts_with("0.000000 s  ./arm  GetPose x: recorded 194.04175, now 259.104"),
        "{}",
        told.out
    );
    assert_eq!(
        told.out.lines().last(),
        Some("2 requests, 2 answers compared in 5 fields: 5 differences")
    );
    let run = replay(
        &[
            "--json",
            "--ignore",
            "GetPose.joint_angle",
            "--ignore",
            "r",
            "--ignore",
            "Pose.y",
        ],
        &path,
    );
    assert_eq!(
        (run.status, run.error()["kind"].clone()),
        (10, json!("check-failed"))
    );
    let objects = run.objects();
    assert_eq!(objects.len(), 3);
    assert_eq!(objects[0]["recorded"], json!(194.04175));
    assert_eq!(objects[0]["command"], "GetPose");
    assert_eq!(
        (objects[0]["field"].clone(), objects[1]["field"].clone()),
        (json!("x"), json!("z"))
    );
    assert_eq!(
        (
            objects[2]["ignored"].clone(),
            objects[2]["differences"].clone()
        ),
        (json!(3), json!(2))
    );
    assert_eq!(replay(&["--ignore", "10"], &path).status, 0);
    assert_eq!(replay(&["--tolerance", "1000"], &path).status, 0);
}

#[test]
fn a_scenario_and_a_profile_are_those_of_the_new_arm() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("session.pcapng");
    let device_name = [0xAA, 0xAA, 0x02, 0x01, 0x00, 0xFF];
    written(&path, &[(1, false, &device_name)]);
    let profile = run(&["sim", "--profile", "-"])
        .out
        .replace("Dobot 2.0", "Anna");
    let file = dir.path().join("profile.toml");
    fs::write(&file, profile).expect("written");
    let new = dir.path().join("new.pcapng");
    let new = new.to_str().expect("UTF-8");
    let done = replay(
        &["--profile", file.to_str().expect("UTF-8"), "--save", new],
        &path,
    );
    assert_eq!(done.status, 0, "{done:?}");
    let explained: Vec<Value> = run(&["decode", "--json", new]).objects();
    assert_eq!(explained[1]["params"]["device_name"], "Anna");
    let scenario = dir.path().join("scenario.toml");
    fs::write(&scenario, "nonsense = 1").expect("written");
    assert_eq!(
        replay(&["--scenario", scenario.to_str().expect("UTF-8")], &path).status,
        3
    );
}

#[test]
fn replay_to_the_decoder_matches_decode() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("session.pcapng");
    written(
        &path,
        &[
            (1, false, b"M10\r\n"),
            (2, false, &GET_POSE),
            (20_003, false, &GET_POSE),
        ],
    );
    let name = path.to_str().expect("UTF-8");
    for json in [&[][..], &["--json"]] {
        let decoded = run(&[&["decode", name], json].concat());
        for more in [&[][..], &["--speed", "1"]] {
            let replayed = replay(&[&["--to", "decode"], json, more].concat(), &path);
            assert_eq!(
                (replayed.status, &replayed.out),
                (decoded.status, &decoded.out)
            );
        }
    }
    assert_eq!(replay(&["--to", "decode", "--save", "x"], &path).status, 2);
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("session.pcapng");
    let refused = |about: &str| {
        let run = replay(&["--json"], &path);
        assert_eq!((run.status, run.out.as_str()), (3, ""), "{run:?}");
        let message = run.error()["message"]
            .as_str()
            .unwrap_or_default()
            .to_owned();
        assert!(message.contains(about), "{message}");
    };
    refused("cannot be read");
    fs::write(&path, b"").expect("written");
    refused("is empty");
    fs::write(&path, b"AA AA 02 0A 00 F6").expect("written");
    refused("not a trace");
    written(&path, &[(1, true, &GET_POSE)]);
    refused("no request");
    written(&path, &[(9, false, &GET_POSE), (2, false, &GET_POSE)]);
    refused("out of order");
    written(&path, &[(1, false, &GET_POSE)]);
    let whole = fs::read(&path).expect("there");
    fs::write(&path, &whole[..whole.len() - 1]).expect("written");
    refused("ends inside the block");
    // Sparse file of more than 1 GB, which takes no disk space.
    fs::File::options()
        .write(true)
        .open(&path)
        .and_then(|file| file.set_len((1 << 30) + 1))
        .expect("longer");
    refused("larger than 1 GB");
    fs::write(&path, &whole).expect("written");
    let none = replay(&["--link", "ble:x"], &path);
    assert_eq!(none.status, 3);
    assert!(none.err.contains("it has './arm'"), "{}", none.err);
    assert_eq!(replay(&["--ignore", "warmth"], &path).status, 2);
    assert_eq!(
        replay(&["--save", path.to_str().expect("UTF-8")], &path).status,
        2
    );
    assert_eq!(fs::read(&path).expect("there"), whole);
    assert_eq!(replay(&["--tolerance", "nan"], &path).status, 2);
}

#[test]
fn replay_can_be_interrupted_while_waiting() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("session.pcapng");
    written(
        &path,
        &[(1, false, &GET_POSE), (3_600_000_001, false, &GET_POSE)],
    );
    let mut replay = command();
    replay
        .args(["replay", "--to", "decode", "--speed", "1"])
        .arg(&path);
    let mut child = replay
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let mut first = [0; 1];
    std::io::Read::read_exact(child.stdout.as_mut().expect("stdout"), &mut first).expect("a byte");
    let kill = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
}

/// Public recording of a real arm and the jogs behind it; see the head of each file.
const RECORDING: &str =
    include_str!("../../../magician-sim/tests/virtual_arm/data/jog-recording.tsv");
const JOGS: &str = include_str!("../../../magician-sim/tests/virtual_arm/data/jog-commands.tsv");

/// Writes the recording as a trace of the host that made it: a pose every 100 ms, and a jog
/// whenever one began. `tool` is the bias that the host had set, which relates its poses to joints.
fn recorded_jogs(path: &Path, tool: ToolBias) {
    recorded_jogs_late(path, tool, 0);
}

/// Writes the same with every tenth pose `late` microseconds later.
fn recorded_jogs_late(path: &Path, tool: ToolBias, late: u64) {
    let rows = |text: &'static str| {
        let rows = text.lines().filter(|row| !row.starts_with('#'));
        rows.map(|row| row.split('\t').collect::<Vec<_>>())
    };
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let geometry = Geometry::magician(tool);
    let mut packets = Vec::new();
    for (nth, row) in rows(RECORDING).enumerate() {
        let late = if nth % 10 == 5 { late } else { 0 };
        let at = 1_000_000 + number(row[0]) as u64 * 1000 + late;
        let [x, y, z] = [1, 2, 3].map(|column| number(row[column]));
        let joints = geometry.inverse(&motion::Pose::new(x, y, z, 0.0));
        let joints = joints.expect("within reach").to_array();
        let pose = Pose {
            x: x as f32,
            y: y as f32,
            z: z as f32,
            r: 0.0,
            joint_angle: joints.map(|angle| angle as f32),
        };
        let reply = FrameBuf::encode(10, Ctrl::GET, &pose).expect("fits");
        packets.push((at, false, GET_POSE.to_vec()));
        packets.push((at + 2000, true, reply.bytes().to_vec()));
    }
    for row in rows(JOGS) {
        let at = 1_000_000 + number(row[0]) as u64 * 20_000;
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == row[1]);
        let cmd = match number(row[2]) {
            0.0 => 0,
            speed => 1 + 2 * axis.expect("an axis") as u8 + u8::from(speed < 0.0),
        };
        let jog = JogCmd {
            is_joint: Flag::OFF,
            cmd: JogCommand::from(cmd),
        };
        let request = FrameBuf::set(&Set::from(jog), Ctrl::SET).expect("fits");
        let reply = FrameBuf::new(request.frame().id(), Ctrl::SET, &[]).expect("fits");
        packets.push((at, false, request.bytes().to_vec()));
        packets.push((at + 1500, true, reply.bytes().to_vec()));
    }
    packets.sort_by_key(|(at, ..)| *at);
    let packets = packets.iter();
    let packets: Vec<_> = packets
        .map(|(at, reply, bytes)| (*at, *reply, &bytes[..]))
        .collect();
    written(path, &packets);
}

#[test]
fn recorded_jogs_of_a_real_arm_are_answered_to_15_micrometres_whatever_its_tool() {
    let dir = tempfile::tempdir().expect("a directory");
    for tool in [ToolBias::SUCTION, ToolBias::NONE, ToolBias::PEN] {
        let path = dir.path().join("jogs.pcapng");
        recorded_jogs(&path, tool);
        let poses = &["--json", "--tolerance", "0.015"][..];
        let law = replay(poses, &path);
        assert_eq!(law.status, 0, "{tool:?}: {law:?}");
        let summary = law.object();
        assert_eq!(
            (&summary["differences"], &summary["late"]),
            (&json!(0), &json!(0))
        );
        assert_eq!(summary["answers"], json!(120 + 14));
        // The continuous law misses the recording by millimetres.
        let before = replay(&[poses, &["--profile", "continuous"]].concat(), &path);
        assert_eq!(before.status, 10, "{before:?}");
        let found = before.objects().pop().expect("a summary");
        assert!(
            found["differences"]
                .as_u64()
                .is_some_and(|count| count > 100),
            "{found}"
        );
    }
}

#[test]
fn poses_of_another_period_are_differences() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("jogs.pcapng");
    recorded_jogs_late(&path, ToolBias::SUCTION, 20_000);
    let told = replay(&["--json", "--tolerance", "0.015"], &path);
    assert_eq!(told.status, 10, "{told:?}");
    let mut objects = told.objects();
    let summary = objects.pop().expect("a summary");
    let is_period = |object: &Value| object["difference"] == "period";
    assert!(
        objects.len() > 3 && objects.iter().all(is_period),
        "{told:?}"
    );
    assert_eq!(summary["differences"], json!(objects.len()));
}

#[test]
fn law_of_the_recorded_jogs_is_period_acceleration_and_ratio_and_continuous_is_far_off() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("jogs.pcapng");
    recorded_jogs(&path, ToolBias::SUCTION);
    let run = replay(&["--law", "--json"], &path);
    assert_eq!(run.status, 0, "{run:?}");
    let law = run.object();
    assert_eq!(law["basis"], "commands");
    assert_eq!(
        (&law["profile"], &law["period_ms"]),
        (&json!("3.6.14"), &json!(20.0))
    );
    let expected = json!([{
        "motion": "jog-space", "acceleration": 60.0, "speed": 30.0, "ratio": 50.0
    }]);
    assert_eq!((&law["speeds"], &law["not_told"]), (&expected, &json!([])));
    let residues = law["residues"].as_array().expect("a list");
    let off = |nth: usize| residues[nth]["mm"].as_f64().expect("a number");
    assert_eq!(residues[0]["profile"], "3.6.14");
    assert!(off(0) <= 0.015, "{law}");
    assert_eq!(residues[1]["profile"], "continuous");
    assert!(off(1) > 1.0, "{law}");
    let told = replay(&["--law"], &path);
    assert!(
        told.out
            .contains("profile 3.6.14 (3.7.0, 4.0.3 move identically): best fit, deviation 0.001")
            && told.out.contains("\n  period 20 ms\n")
            && told
                .out
                .contains("\n  jog in space: acceleration 60 mm/s2, speed 30 mm/s, ratio 50 %\n"),
        "{}",
        told.out
    );
    // A profile with the same law under another name is not reported twice.
    let same = replay(&["--law", "--json", "--profile", "4.0.3"], &path);
    assert_eq!(same.object(), law);
    // Poses with another period leave a residue.
    recorded_jogs_late(&path, ToolBias::SUCTION, 20_000);
    let law = replay(&["--law", "--json"], &path).object();
    assert!(law["residues"][0]["mm"].as_f64() > Some(0.1), "{law}");
}

#[test]
fn law_of_a_file_that_is_no_log_is_refused_with_the_reason() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("day.csv");
    let refused = |bytes: &[u8], about: &str| {
        fs::write(&path, bytes).expect("written");
        let run = replay(&["--law", "--json"], &path);
        assert_eq!((run.status, run.out.as_str()), (3, ""), "{run:?}");
        let error = run.error();
        let message = error["message"].as_str().unwrap_or_default();
        assert!(
            message.contains("day.csv") && message.contains(about),
            "{message}"
        );
    };
    refused(b"", "no readings");
    refused(b"t,x,y,z\n", "no readings");
    refused(b"G1 X10\n", "neither a trace nor readings");
    refused(&[0xFF, 0x00, 0x12], "neither a trace nor readings");
    refused(b"t,x,y,z\n0,1,NaN,3\n", "line 2: y is NaN");
    written(&path, &[(1, false, &GET_POSE)]);
    let whole = fs::read(&path).expect("there");
    refused(&whole[..whole.len() - 1], "ends inside the block");
    // A short log is still evaluated, and the report says what it cannot show.
    fs::write(&path, "t,x,y,z\n0,1,2,3\n").expect("written");
    let run = replay(&["--law", "--json"], &path);
    assert_eq!(
        (run.status, &run.object()["not_told"][0]["about"]),
        (0, &json!("law"))
    );
    for refused in ["--speed=1", "--tolerance=1", "--to=decode"] {
        assert_eq!(replay(&["--law", refused], &path).status, 2, "{refused}");
    }
    assert_eq!(
        replay(&["--law", "--profile", "continuous"], &path).status,
        0
    );
}
