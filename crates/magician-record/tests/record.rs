//! Recordings: samples are on the exact grid, values are those of the arm, and an incomplete file
//! is readable as far as it goes.

mod recording;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician_motion::Pose;
use magician_protocol::commands;
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable};
use magician_record::mcap::Recorder;
use magician_sim::{
    ArmInstant, Controller, HostInstant, LineTiming, LinkId, Observer, Profile, Runner, Scenario,
    Speed, World,
};
use proptest::prelude::*;
use recording::{EPOCH, Micros, RecordedMessage, of, read};
use serde_json::{Value, json};

const USB: LinkId = LinkId(0);
/// A second of the arm's clock.
const SECOND: Micros = 1_000_000;
const PERIOD: Micros = 20_000;
const RUNNER_SPEEDS: [Speed; 4] = [
    Speed::Times(1.0),
    Speed::Times(20.0),
    Speed::Times(0.3),
    Speed::Max,
];

fn at(micros: Micros) -> ArmInstant {
    ArmInstant::from_micros(micros)
}

/// Parses a line of hex.
fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).expect("hex"))
        .collect()
}

fn request(id: u8, ctrl: Ctrl, params: &[u8]) -> Vec<u8> {
    FrameBuf::new(id, ctrl, params).unwrap().bytes().to_vec()
}

/// A point-to-point move.
fn ptp(mode: u8, target: [f32; 4]) -> Vec<u8> {
    let target = target.map(f32::to_le_bytes).concat();
    request(84, Ctrl::QUEUED, &[&[mode][..], &target].concat())
}

fn wait(ms: u32) -> Vec<u8> {
    request(110, Ctrl::QUEUED, &ms.to_le_bytes())
}

fn start() -> Vec<u8> {
    [request(20, Ctrl::SET, &[]), request(240, Ctrl::SET, &[])].concat()
}

/// A bit of everything: joint moves and lines, a wait, the suction cup, damaged bytes.
fn programme() -> Vec<u8> {
    [
        start(),
        ptp(1, [220.0, 60.0, 40.0, 15.0]),
        ptp(2, [200.0, -50.0, 10.0, -20.0]),
        request(62, Ctrl::QUEUED, &[1, 1]),
        wait(130),
        ptp(0, [230.0, 30.0, 20.0, 0.0]),
    ]
    .concat()
}

fn get_pose() -> Vec<u8> {
    FrameBuf::get(&NoArgs, commands::Pose::ROW)
        .unwrap()
        .bytes()
        .to_vec()
}

/// Records a program in virtual time until `end`, advancing the clock to each of `cuts` on the way.
fn recorded(programme: &[u8], end: Micros, cuts: &[Micros]) -> Vec<u8> {
    let mut arm = Controller::default();
    let mut recorder = Recorder::new(Vec::new(), EPOCH).unwrap();
    recorder.observe(&arm);
    arm.receive(USB, programme);
    recorder.observe(&arm);
    for cut in cuts {
        arm.advance_observed(at(*cut), &mut recorder);
    }
    arm.advance_observed(at(end), &mut recorder);
    recorder.finish().unwrap()
}

#[test]
fn samples_are_every_20_ms_and_equal_get_pose() {
    let (all, cut_off) = read(&recorded(&programme(), 8 * SECOND + 7, &[]));
    assert!(!cut_off);
    let (poses, joints) = (of(&all, "/pose"), of(&all, "/joints"));
    let grid: Vec<Micros> = (0..=400).map(|k| k * PERIOD).collect();
    for samples in [&poses, &joints] {
        let times: Vec<Micros> = samples.iter().map(|sample| sample.at).collect();
        assert_eq!(times, grid);
    }
    let mut arm = Controller::default();
    arm.receive(USB, &programme());
    let (mut before, mut moved) = (None, 0);
    for (pose, joint) in poses.iter().zip(&joints) {
        arm.advance(at(pose.at));
        arm.close(USB);
        let reply = arm.exchange(USB, &get_pose()).remove(0);
        let said: commands::Pose = reply.frame().read().unwrap();
        let position = &pose.value["pose"]["position"];
        let millimetres = |axis| (position[axis].as_f64().unwrap() * 1000.0) as f32;
        let turn = &pose.value["pose"]["orientation"];
        let (sine, cosine) = (turn["z"].as_f64().unwrap(), turn["w"].as_f64().unwrap());
        let r = (2.0 * libm::atan2(sine, cosine)).to_degrees() as f32;
        let angle = |at: usize| {
            let angle = &joint.value["joints"][at]["position"];
            angle.as_f64().unwrap().to_degrees() as f32
        };
        assert_eq!(
            (
                [millimetres("x"), millimetres("y"), millimetres("z"), r],
                [0, 1, 2, 3].map(angle)
            ),
            ([said.x, said.y, said.z, said.r], said.joint_angle),
            "at {}",
            pose.at
        );
        moved += usize::from(before.replace(said).is_some_and(|before| before != said));
    }
    assert!(moved > 100, "{moved}");
}

#[test]
fn rotation_above_180_degrees_is_kept() {
    let mut profile = Profile::default();
    profile.power_up.joints = [130.0, 45.0, 45.0, 140.0];
    let arm = Controller::new(profile);
    let Pose { r, .. } = arm.state().pose;
    assert_eq!(r, 270.0);
    let mut recorder = Recorder::new(Vec::new(), EPOCH).unwrap();
    recorder.observe(&arm);
    let (all, _) = read(&recorder.finish().unwrap());
    let turn = &of(&all, "/pose")[0].value["pose"]["orientation"];
    let half = libm::atan2(turn["z"].as_f64().unwrap(), turn["w"].as_f64().unwrap());
    assert!((2.0 * half.to_degrees() - 270.0).abs() < 1e-9);
}

#[test]
fn what_changes_is_written_when_it_changes_and_every_second() {
    let (all, _) = read(&recorded(&programme(), 8 * SECOND, &[]));
    let on = |read: &&&RecordedMessage| read.value["suction"]["commanded"] == true;
    let io = of(&all, "/io");
    let first = io.iter().find(on).unwrap();
    let finished = |index: u64| {
        let queue = of(&all, "/queue");
        let found = queue
            .iter()
            .find(|read| read.value["current_index"] == index);
        found.unwrap().at
    };
    // Switching the suction cup takes no time, so the commands of index 3 and 4 finish together.
    assert_eq!(first.at, finished(4));
    assert_eq!(finished(5), finished(4) + 130_000);
    for topic in ["/queue", "/io", "/alarms", "/status"] {
        let times: Vec<Micros> = of(&all, topic).iter().map(|read| read.at).collect();
        assert!(
            (0..=8).all(|second| times.contains(&(second * SECOND))),
            "{topic}"
        );
    }
    let status = of(&all, "/status");
    assert!(status.iter().any(|read| read.value["moving"] == true));
}

#[test]
fn alarms_and_events_have_the_instant_at_which_they_came() {
    // A target out of reach raises alarm 0x12 or another planning alarm, at its turn in the queue.
    let programme = [start(), wait(333), ptp(1, [400.0, 0.0, 0.0, 0.0])].concat();
    let (all, _) = read(&recorded(&programme, SECOND, &[]));
    let alarms = of(&all, "/alarms");
    assert_eq!(alarms[0].value["standing"][0]["code"], 0);
    assert_eq!(alarms[1].value["standing"], json!([]));
    let raised = alarms[2];
    assert_eq!(
        (raised.at, &raised.value["blocking"]),
        (333_000, &json!(true))
    );
    let events = of(&all, "/events");
    let time_of = |text: &str| {
        let found = events.iter().find(|read| {
            let message = read.value["message"].as_str().unwrap();
            message.starts_with(text)
        });
        found.unwrap_or_else(|| panic!("{text}: {events:#?}")).at
    };
    assert_eq!(time_of("alarm 0x00"), 0);
    assert_eq!(time_of("2 WAITCmd finished"), 333_000);
    let name = raised.value["standing"][0]["name"].as_str().unwrap();
    let code = raised.value["standing"][0]["code"].as_u64().unwrap();
    assert_eq!(
        time_of(&format!("alarm {code:#04x} {name} raised")),
        333_000
    );
}

#[test]
fn rail_and_pins_are_recorded_after_they_are_set() {
    let programme = [
        start(),
        request(3, Ctrl::SET, &[1, 0]),
        request(130, Ctrl::SET, &[4, 1]),
        request(131, Ctrl::SET, &[4, 1]),
    ]
    .concat();
    let (all, _) = read(&recorded(&programme, PERIOD, &[]));
    let names = |read: &RecordedMessage| -> Vec<String> {
        let joints = read.value["joints"].as_array().unwrap();
        let names = joints.iter().map(|joint| joint["name"].as_str().unwrap());
        names.map(str::to_owned).collect()
    };
    let joints = of(&all, "/joints");
    assert_eq!(names(joints[0]), ["J1", "J2", "J3", "J4"]);
    assert_eq!(names(joints[1]), ["J1", "J2", "J3", "J4", "L"]);
    let io = of(&all, "/io");
    assert_eq!(io[0].value["pins"], json!([]));
    assert_eq!(
        io[1].value["pins"],
        json!([{"address": 4, "function": 1, "able": true, "level": true, "frequency": 0.0,
            "duty_cycle": 0.0, "high": 100.0, "input": false, "analog": 0}])
    );
}

const BRICK: &str = r#"
[tool]
kind = "suction"
[table]
height = -70
[[object]]
name = "brick"
size = [20, 20, 20]
at = [220, 0]
"#;

#[test]
fn world_events_name_the_object() {
    let scenario = Scenario::from_toml(BRICK).unwrap();
    let mut arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    let mut recorder = Recorder::new(Vec::new(), EPOCH).unwrap();
    recorder.observe(&arm);
    let programme = [
        start(),
        request(
            60,
            Ctrl::QUEUED,
            &[59.7f32, 0.0, 0.0].map(f32::to_le_bytes).concat(),
        ),
        ptp(0, [220.0, 0.0, -50.0, 0.0]),
        request(62, Ctrl::QUEUED, &[1, 1]),
        wait(1000),
        ptp(0, [220.0, 60.0, 80.0, 0.0]),
    ]
    .concat();
    arm.receive(USB, &programme);
    arm.advance_observed(at(8 * SECOND), &mut recorder);
    let (all, _) = read(&recorder.finish().unwrap());
    let events = of(&all, "/events");
    let is_recorded = |text| events.iter().any(|read| read.value["message"] == text);
    assert!(is_recorded("the tool takes brick"), "{events:#?}");
    assert_eq!(of(&all, "/io").last().unwrap().value["holding"], true);
}

/// Feeds a runner with a list of (wall time, link, bytes) until the wall time `end`. Wakes it at
/// its timeouts and at the `extra` times.
fn drive(
    runner: &mut Runner,
    inputs: &[(Micros, LinkId, Vec<u8>)],
    extra: &[Micros],
    end: Micros,
) -> Vec<(Micros, FrameBuf)> {
    let (mut now, mut inputs, mut replies) = (0, inputs.iter(), Vec::new());
    let mut input = inputs.next();
    loop {
        let wall = HostInstant::from_micros(now);
        while let Some((_, link, bytes)) = input.filter(|(at, ..)| *at <= now) {
            runner.receive(wall, *link, bytes);
            input = inputs.next();
        }
        runner.handle_timeout(wall);
        for link in [LinkId(0), LinkId(1)] {
            while let Some(reply) = runner.poll_transmit(wall, link) {
                replies.push((now, reply));
            }
        }
        if now >= end {
            return replies;
        }
        let due = runner.poll_timeout();
        let due = due.map(|due| due.as_micros().max(now + 1));
        let given = input.map(|(at, ..)| *at);
        let more = extra.iter().copied().find(|at| *at > now);
        let next = [due, given, more].into_iter().flatten().min();
        now = next.unwrap_or(end).min(end);
    }
}

type SharedRecorder = Arc<Mutex<Recorder<Shared>>>;

/// Records a runner's arm from now on.
fn watch(runner: &mut Runner, out: Shared) -> SharedRecorder {
    let recorder = Recorder::new(out, EPOCH).unwrap();
    let recorder = Arc::new(Mutex::new(recorder));
    runner.observe(Arc::clone(&recorder));
    recorder
}

/// The finished file.
fn file_of(mut runner: Runner, recorder: SharedRecorder) -> Vec<u8> {
    runner.unobserve();
    let recorder = Arc::into_inner(recorder).unwrap().into_inner().unwrap();
    recorder.finish().unwrap().0.lock().unwrap().clone()
}

fn timed_inputs() -> Vec<(Micros, LinkId, Vec<u8>)> {
    vec![
        (5_000, LinkId(0), programme()),
        (31_007, LinkId(1), get_pose()),
        (31_007, LinkId(0), get_pose()),
        (400_001, LinkId(1), ptp(1, [240.0, 0.0, 50.0, 0.0])),
        (
            900_000,
            LinkId(0),
            hex("AA AA 02 0A 00 F6 AA AA 02 0A 00 F7 41 42"),
        ),
        (1_900_000, LinkId(0), get_pose()),
    ]
}

fn line() -> LineTiming {
    LineTiming {
        baud: Some(115_200),
        turnaround: Duration::from_micros(300),
    }
}

#[test]
fn recording_changes_neither_replies_nor_state() {
    for speed in RUNNER_SPEEDS {
        let mut plain = Runner::new(Controller::default(), speed, line());
        let mut watched = Runner::new(Controller::default(), speed, line());
        watched.observe(Recorder::new(Vec::new(), EPOCH).unwrap());
        let seen = [
            drive(&mut plain, &timed_inputs(), &[], 2 * SECOND),
            drive(&mut watched, &timed_inputs(), &[], 2 * SECOND),
        ];
        assert_eq!(seen[0], seen[1], "{speed}");
        assert_eq!(seen[0].len(), 12);
        assert_eq!(plain.controller().state(), watched.controller().state());
    }
}

#[test]
fn the_grid_is_exact_at_every_speed_and_however_the_clock_leaps() {
    for speed in RUNNER_SPEEDS {
        let run = |extra: &[Micros]| {
            let mut runner = Runner::new(Controller::default(), speed, line());
            let recorder = watch(&mut runner, Shared::default());
            drive(&mut runner, &timed_inputs(), extra, 2 * SECOND);
            let end = runner.controller().now().as_micros();
            let file = file_of(runner, recorder);
            (file, end)
        };
        let (file, end) = run(&[]);
        let (all, _) = read(&file);
        let times: Vec<Micros> = of(&all, "/pose").iter().map(|read| read.at).collect();
        let grid: Vec<Micros> = (0..=end / PERIOD).map(|k| k * PERIOD).collect();
        assert_eq!(times, grid, "{speed}");
        let extra: Vec<Micros> = (1..2000).map(|k| k * 977).collect();
        if speed != Speed::Max {
            assert!(run(&extra).0 == file, "{speed}");
        }
    }
}

#[test]
fn recorded_frames_have_direction_link_and_error() {
    let mut runner = Runner::new(
        Controller::default(),
        Speed::default(),
        LineTiming::default(),
    );
    let recorder = watch(&mut runner, Shared::default());
    recorder.lock().unwrap().name(LinkId(0), "./arm");
    let damaged = "AA AA 02 0A 00 F7";
    for (at, bytes) in [
        (1_000, get_pose()),
        (2_000, wait(5)),
        (3_000, hex(damaged)),
        (70_000, request(199, Ctrl::GET, &[])),
        (71_000, request(84, Ctrl::SET, &[1, 2])),
        (72_000, b"M10".to_vec()),
        (200_000, hex("AA AA 02")),
    ] {
        runner.receive(HostInstant::from_micros(at), LinkId(0), &bytes);
    }
    runner.receive(HostInstant::from_micros(200_000), LinkId(7), &get_pose());
    runner.handle_timeout(HostInstant::from_micros(300_000));
    let file = file_of(runner, recorder);
    let (all, _) = read(&file);
    let frames: Vec<Value> = of(&all, "/frames")
        .into_iter()
        .map(|read| {
            let mut value = read.value.clone();
            value.as_object_mut().unwrap().remove("timestamp");
            value["at"] = json!(read.at);
            value
        })
        .collect();
    assert_eq!(
        frames[0],
        json!({"link": "./arm", "direction": "request", "hex": "AAAA020A00F6", "ok": true, "id": 10,
            "command": "GetPose", "write": false, "queued": false, "params": {}, "at": 1000})
    );
    assert_eq!(
        (
            &frames[1]["direction"],
            &frames[1]["params"]["joint_angle"],
            &frames[1]["at"]
        ),
        (
            &json!("reply"),
            &json!([0.0, 45.0, 45.0, 0.0]),
            &json!(1000)
        )
    );
    assert_eq!(frames[2]["command"], "SetWAITCmd");
    assert_eq!(frames[2]["params"], json!({"timeout": 5}));
    assert_eq!(frames[3]["params"], json!({"queued_cmd_index": 2}));
    let rest: Vec<(&str, &str, &str, u64)> = frames[4..]
        .iter()
        .map(|frame| {
            (
                frame["link"].as_str().unwrap(),
                frame["direction"].as_str().unwrap(),
                frame["error"].as_str().unwrap_or("none"),
                frame["at"].as_u64().unwrap(),
            )
        })
        .collect();
    assert!(
        rest.contains(&("./arm", "request", "checksum", 3_000)),
        "{rest:?}"
    );
    assert!(
        rest.contains(&("./arm", "request", "unknown", 70_000)),
        "{rest:?}"
    );
    assert!(
        rest.contains(&("./arm", "request", "length", 71_000)),
        "{rest:?}"
    );
    assert!(
        rest.contains(&("./arm", "request", "noise", 72_000)),
        "{rest:?}"
    );
    assert!(
        rest.contains(&("link 7", "reply", "none", 200_000)),
        "{rest:?}"
    );
    assert!(
        rest.contains(&("./arm", "request", "truncated", 250_000)),
        "{rest:?}"
    );
}

/// A file that outlives its writer and fails on request.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>, Arc<Mutex<Option<usize>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut file = self.0.lock().unwrap();
        if self
            .1
            .lock()
            .unwrap()
            .is_some_and(|most| file.len() >= most)
        {
            return Err(io::ErrorKind::StorageFull.into());
        }
        file.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_killed_recorder_leaves_all_up_to_the_last_second() {
    let shared = Shared::default();
    let mut arm = Controller::default();
    let mut recorder = Recorder::new(shared.clone(), EPOCH).unwrap();
    recorder.observe(&arm);
    arm.receive(USB, &programme());
    arm.advance_observed(at(3 * SECOND + 500_000), &mut recorder);
    std::mem::forget(recorder);
    let file = shared.0.lock().unwrap().clone();
    let last = |file: &[u8]| {
        let (all, _) = read(file);
        let times: Vec<Micros> = of(&all, "/pose").iter().map(|read| read.at).collect();
        let grid: Vec<Micros> = (0..times.len() as u64).map(|k| k * PERIOD).collect();
        assert_eq!(times, grid);
        times.last().copied()
    };
    assert_eq!(last(&file), Some(3 * SECOND));
    // Killed while writing: every complete message is readable.
    let mut before = None;
    for end in (file.len() / 3..file.len()).step_by(997) {
        let now = last(&file[..end]);
        assert!(now >= before);
        before = now;
    }
    assert!(before >= Some(2 * SECOND));
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_arm() {
    let shared = Shared::default();
    let mut runner = Runner::new(
        Controller::default(),
        Speed::default(),
        LineTiming::default(),
    );
    let recorder = watch(&mut runner, shared.clone());
    *shared.1.lock().unwrap() = Some(20_000);
    let replies = drive(&mut runner, &timed_inputs(), &[], 3 * SECOND);
    assert_eq!(replies.len(), 12);
    let recorder = recorder.lock().unwrap();
    assert_eq!(recorder.next_sample(), None);
    let error = recorder.error().unwrap();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
}

#[test]
fn a_finished_file_has_index_statistics_and_metadata() {
    let file = recorded(&programme(), 2 * SECOND, &[]);
    let summary = mcap::Summary::read(&file).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    let counts: BTreeMap<&str, u64> = summary
        .channels
        .values()
        .map(|channel| {
            let count = statistics.channel_message_counts.get(&channel.id);
            (&*channel.topic, count.copied().unwrap_or(0))
        })
        .collect();
    assert_eq!((counts["/pose"], counts["/joints"]), (101, 101));
    assert_eq!(counts.len(), 10);
    assert_eq!(
        (statistics.message_start_time, statistics.message_end_time),
        (EPOCH, EPOCH + 2_000_000_000)
    );
    let index = &summary.metadata_indexes[0];
    let metadata = mcap::read::metadata(&file, index).unwrap();
    assert_eq!(metadata.name, "magician");
    assert_eq!(metadata.metadata["epoch_ns"], EPOCH.to_string());
    assert_eq!(metadata.metadata["samples_per_second"], "50");
    // Every message can be found by the index.
    let chunks: usize = (summary.chunk_indexes.iter())
        .flat_map(|chunk| summary.read_message_indexes(&file, chunk).unwrap())
        .map(|(_, entries)| entries.len())
        .sum();
    assert_eq!(chunks as u64, statistics.message_count);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn advancing_in_steps_gives_the_same_file(
        mut cuts in prop::collection::vec(0u64..4 * SECOND, 0..12),
    ) {
        cuts.sort_unstable();
        let whole = recorded(&programme(), 4 * SECOND, &[]);
        prop_assert!(recorded(&programme(), 4 * SECOND, &cuts) == whole);
    }
}
