//! The arm in 3D: coordinate frames from the base to the tip, shapes of the links, and strokes.

mod recording;

use std::collections::BTreeMap;

use magician_motion::ToolBias;
use magician_protocol::commands::Pose;
use magician_protocol::{Ctrl, FrameBuf};
use magician_record::mcap::{Plane, Readings, Recorder};
use magician_record::{Reading, WriteReadings};
use magician_sim::{ArmInstant, Controller, LinkId, Observer, Profile, Scenario, World};
use recording::{EPOCH, Micros, RecordedMessage, of, read};
use serde_json::Value;

const USB: LinkId = LinkId(0);
const SECOND: Micros = 1_000_000;
const PAPER: &str = "[tool]\nkind = \"pen\"\n[table]\nheight = -60\n";

type Vector = [f64; 3];
type Matrix = [Vector; 3];

fn xyz(value: &Value) -> Vector {
    ["x", "y", "z"].map(|axis| value[axis].as_f64().expect("a number"))
}

fn rotation(value: &Value) -> Matrix {
    let [x, y, z] = xyz(value);
    let w = value["w"].as_f64().expect("a number");
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

fn times(matrix: &Matrix, vector: Vector) -> Vector {
    matrix.map(|row| (0..3).map(|at| row[at] * vector[at]).sum())
}

/// Returns the root of a coordinate frame, and the position in the root of a point given in that
/// frame, by the transforms in `/tf` up to an instant.
fn placed(all: &[RecordedMessage], until: Micros, frame: &str, point: Vector) -> (String, Vector) {
    let mut frames = BTreeMap::new();
    for read in of(all, "/tf").into_iter().filter(|read| read.at <= until) {
        frames.insert(read.value["child_frame_id"].as_str().unwrap(), &read.value);
    }
    let (mut frame, mut point) = (frame.to_owned(), point);
    while let Some(value) = frames.get(&*frame) {
        let turned = times(&rotation(&value["rotation"]), point);
        let moved = xyz(&value["translation"]);
        point = [0, 1, 2].map(|axis| turned[axis] + moved[axis]);
        frame = value["parent_frame_id"].as_str().unwrap().to_owned();
    }
    (frame, point)
}

fn distance(a: Vector, b: Vector) -> f64 {
    (0..3).map(|at| (a[at] - b[at]).powi(2)).sum::<f64>().sqrt()
}

fn queued(id: u8, params: &[u8]) -> Vec<u8> {
    let frame = FrameBuf::new(id, Ctrl::QUEUED, params).unwrap();
    frame.bytes().to_vec()
}

/// Returns the requests that start the queue and move along a straight line to each point.
fn moves(points: &[[f32; 4]]) -> Vec<u8> {
    let start = FrameBuf::new(240, Ctrl::SET, &[]).unwrap();
    let clear = FrameBuf::new(20, Ctrl::SET, &[]).unwrap();
    let mut all = [clear.bytes(), start.bytes()].concat();
    for point in points {
        let target = point.map(f32::to_le_bytes).concat();
        all.extend(queued(84, &[&[2][..], &target].concat()));
    }
    all
}

fn recorded(mut arm: Controller, program: &[u8], seconds: Micros) -> (Vec<u8>, Controller) {
    let mut recorder = Recorder::new(Vec::new(), EPOCH).unwrap();
    recorder.observe(&arm);
    arm.receive(USB, program);
    arm.advance_observed(ArmInstant::from_micros(seconds * SECOND), &mut recorder);
    (recorder.finish().unwrap(), arm)
}

fn drawn() -> (Vec<RecordedMessage>, Controller) {
    let scenario = Scenario::from_toml(PAPER).unwrap();
    let world = World::from_scenario(&scenario);
    let arm = Controller::in_world(Profile::default(), world).with_tool(ToolBias::PEN);
    let square = [
        [220.0, 0.0, -40.0, 0.0],
        [220.0, 0.0, -60.0, 0.0],
        [260.0, 0.0, -60.0, 0.0],
        [260.0, 40.0, -60.0, 0.0],
        [260.0, 40.0, -40.0, 0.0],
        [200.0, -40.0, -40.0, 90.0],
        [200.0, -40.0, -60.0, 90.0],
        [230.0, -20.0, -60.0, 90.0],
        [230.0, -20.0, -20.0, 90.0],
    ];
    let (file, arm) = recorded(arm, &moves(&square), 12);
    (read(&file).0, arm)
}

#[test]
fn transforms_compose_to_the_recorded_pose() {
    let (all, _) = drawn();
    let mut turned = 0;
    for pose in of(&all, "/pose") {
        // Frames are written five times per second.
        if pose.at % 200_000 != 0 {
            continue;
        }
        let (root, tip) = placed(&all, pose.at, "tip", [0.0; 3]);
        assert_eq!(root, pose.value["frame_id"]);
        let wanted = xyz(&pose.value["pose"]["position"]);
        assert!(
            distance(tip, wanted) < 5e-6,
            "{tip:?} {wanted:?} at {}",
            pose.at
        );
        let ahead = placed(&all, pose.at, "tip", [1.0, 0.0, 0.0]).1;
        let facing = times(
            &rotation(&pose.value["pose"]["orientation"]),
            [1.0, 0.0, 0.0],
        );
        let facing = [0, 1, 2].map(|axis| tip[axis] + facing[axis]);
        assert!(distance(ahead, facing) < 1e-4, "{ahead:?} {facing:?}");
        turned += 1;
    }
    assert_eq!(turned, 61);
}

#[test]
fn transform_is_written_when_changed_at_most_every_tenth_sample() {
    let (all, _) = drawn();
    let mut written = BTreeMap::<_, Vec<Micros>>::new();
    for read in of(&all, "/tf") {
        let name = read.value["child_frame_id"].as_str().unwrap();
        written.entry(name).or_default().push(read.at);
    }
    let names: Vec<&str> = written.keys().copied().collect();
    let links = [
        "bracket", "elbow", "forearm", "rear_arm", "tip", "turret", "wrist",
    ];
    assert_eq!(names, links);
    assert_eq!(written["bracket"], [0]);
    assert!(written["turret"].len() > 10);
    assert!(written.values().flatten().all(|at| at % 200_000 == 0));
}

/// Lines visible at the end: pairs of points, m.
fn lines(all: &[RecordedMessage]) -> Vec<[Vector; 2]> {
    let mut entities = BTreeMap::new();
    for read in of(all, "/scene") {
        if read.value["deletions"]
            .as_array()
            .is_some_and(|all| !all.is_empty())
        {
            entities.clear();
        }
        for entity in read.value["entities"].as_array().unwrap() {
            entities.insert(entity["id"].as_str().unwrap().to_owned(), entity.clone());
        }
    }
    let mut pairs = Vec::new();
    for (id, entity) in entities {
        for line in entity["lines"].as_array().unwrap() {
            assert!(id.starts_with("strokes") && line["type"] == 2, "{id}");
            let points: Vec<Vector> = line["points"].as_array().unwrap().iter().map(xyz).collect();
            let ends = line["indices"].as_array().unwrap();
            let ends: Vec<usize> = ends
                .iter()
                .map(|at| at.as_u64().unwrap() as usize)
                .collect();
            pairs.extend(
                ends.chunks(2)
                    .map(|pair| [points[pair[0]], points[pair[1]]]),
            );
        }
    }
    pairs
}

fn length(lines: &[[Vector; 2]]) -> f64 {
    lines.iter().map(|[from, to]| distance(*from, *to)).sum()
}

#[test]
fn what_the_pen_drew_is_seen_as_lists_of_lines() {
    let (all, arm) = drawn();
    let drawing = arm.drawing();
    let drawn = drawing
        .strokes()
        .iter()
        .flat_map(|stroke| stroke.points.windows(2));
    let drawn: f64 = drawn
        .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
        .sum();
    assert!(drawn > 115.0, "{drawn}");
    let lines = lines(&all);
    assert!(
        (length(&lines) * 1000.0 - drawn).abs() < 0.05,
        "{}",
        length(&lines)
    );
    assert!(
        lines
            .iter()
            .flatten()
            .all(|point| (point[2] + 0.06).abs() < 1e-9)
    );
}

#[test]
fn every_link_is_seen_in_a_frame_of_its_own_from_the_beginning_on() {
    let (all, _) = drawn();
    let scene = of(&all, "/scene")[0];
    let entities = scene.value["entities"].as_array().unwrap();
    let ids: Vec<&str> = entities
        .iter()
        .map(|entity| entity["id"].as_str().unwrap())
        .collect();
    let links = [
        "base", "turret", "rear_arm", "elbow", "forearm", "wrist", "bracket", "tip",
    ];
    assert_eq!(ids, links.map(|link| format!("arm/{link}")));
    assert!(
        entities
            .iter()
            .all(|entity| ids.contains(&&*format!("arm/{}", entity["frame_id"].as_str().unwrap())))
    );
    // The rear arm reaches from the shoulder to the elbow.
    let middle = xyz(&entities[2]["cubes"][0]["pose"]["position"]);
    assert_eq!((scene.at, middle), (0, [0.0, 0.0, 0.0675]));
    // The foot of the base stands on the table.
    let foot = xyz(&entities[0]["cubes"][0]["pose"]["position"]);
    let height = xyz(&entities[0]["cubes"][0]["size"])[2];
    assert!((foot[2] - height / 2.0 + 0.138).abs() < 1e-9);
}

/// Readings of an arm that draws a line on paper, 20 per second.
fn readings(paper: Option<Plane>) -> Vec<RecordedMessage> {
    let mut readings = Readings::new(Vec::new(), EPOCH, 20.0).unwrap();
    if let Some(paper) = paper {
        readings = readings.on_paper(paper);
    }
    let geometry = magician_motion::Geometry::magician(ToolBias::new(61.0, 0.0, 12.0));
    for nth in 0..100 {
        let (x, z) = (
            200.0 + f64::from(nth),
            if (20..=60).contains(&nth) {
                -50.0
            } else {
                -40.0
            },
        );
        let pose = magician_motion::Pose::new(x, 30.0, z, 10.0);
        let joints = geometry.inverse(&pose).unwrap();
        let place = pose.to_array().map(|value| value as f32);
        let pose = Pose {
            x: place[0],
            y: place[1],
            z: place[2],
            r: place[3],
            joint_angle: joints.to_array().map(|value| value as f32),
        };
        let reading = Reading {
            t: f64::from(nth) / 20.0,
            step: None,
            pose,
            rail: None,
            index: 0,
            left_space: 32,
            capacity: 32,
            alarms: magician_protocol::AlarmSet::default(),
        };
        readings.write(&reading).unwrap();
    }
    read(&readings.into_file().unwrap()).0
}

#[test]
fn a_host_finds_the_tool_of_its_readings_and_the_frames_lead_to_the_pose() {
    let all = readings(None);
    for pose in of(&all, "/pose")
        .into_iter()
        .filter(|pose| pose.at % 500_000 == 0)
    {
        let (_, tip) = placed(&all, pose.at, "tip", [0.0; 3]);
        let wanted = xyz(&pose.value["pose"]["position"]);
        assert!(distance(tip, wanted) < 5e-6, "{tip:?} {wanted:?}");
    }
}

#[test]
fn host_recording_has_strokes_only_with_a_paper_plane() {
    assert_eq!(lines(&readings(None)), Vec::<[Vector; 2]>::new());
    let paper = Plane {
        height: -50.0,
        slope: [0.0; 2],
    };
    let lines = lines(&readings(Some(paper)));
    assert!((length(&lines) - 0.04).abs() < 1e-6, "{}", length(&lines));
}

#[test]
fn scene_and_transforms_add_less_than_30_percent_to_the_file() {
    let there_and_back: Vec<[f32; 4]> = (0..30)
        .map(|nth| {
            [
                200.0 + (nth % 3) as f32 * 30.0,
                (nth % 5) as f32 * 40.0 - 80.0,
                (nth % 2) as f32 * 30.0,
                (nth % 4) as f32 * 20.0,
            ]
        })
        .collect();
    let (file, _) = recorded(Controller::default(), &moves(&there_and_back), 20);
    let (mut before, mut after) = (0, 0);
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        // Header of the record, and its entry in the index.
        let bytes = message.data.len() + 31 + 16;
        match &*message.channel.topic {
            "/tf" | "/scene" => after += bytes,
            _ => before += bytes,
        }
    }
    let more = 100 * after / before;
    println!("{more} % more: {before} bytes, {after}");
    assert!((10..30).contains(&more), "{more} %");
}
