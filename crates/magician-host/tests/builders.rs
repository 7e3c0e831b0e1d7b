//! Builders of commands, compared with their bytes: `data/builders.json` has each one with
//! arguments, id and parameters.
//!
//! Python has its own builders, and `test_words.py` compares them with the same file.

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::fs;
use std::path::Path;
use std::time::Duration;

use magician_host::build;
use magician_protocol::commands::{ColorSensor, IoAdc, IoDi, IrSwitch};
use magician_protocol::{Ctrl, FrameBuf, Readable};
use serde_json::Value;

const TABLE: &str = include_str!("data/builders.json");

/// Builders whose arguments or results are not numbers; they have separate tests.
const ELSEWHERE: [&str; 6] = [
    "conveyor_speed",
    "rail_to",
    "tool",
    "wait_for_analog",
    "with_outputs",
    "with_rail",
];

#[derive(Clone, Copy)]
struct Args<'a>(&'a [Value]);

impl Args<'_> {
    fn number(self, at: usize) -> f32 {
        self.0[at].as_f64().expect("a number") as f32
    }

    fn four(self, at: usize) -> [f32; 4] {
        let list = Args(self.0[at].as_array().expect("four numbers"));
        [0, 1, 2, 3].map(|at| list.number(at))
    }

    fn whole<T: TryFrom<i64, Error: Debug>>(self, at: usize) -> T {
        let whole = self.0[at].as_i64().expect("a whole number");
        whole.try_into().expect("in range")
    }

    /// A named value, by its number.
    fn named<T: From<u8>>(self, at: usize) -> T {
        self.whole::<u8>(at).into()
    }

    fn flag(self, at: usize) -> bool {
        self.0[at].as_bool().expect("true or false")
    }
}

/// Result of a builder for its arguments.
fn built(name: &str, args: Args<'_>) -> FrameBuf {
    let n = |at| args.number(at);
    let set = match name {
        "move_to" => build::move_to(n(0), n(1), n(2), n(3)),
        "line_to" => build::line_to(n(0), n(1), n(2), n(3)),
        "jump_to" => build::jump_to(n(0), n(1), n(2), n(3)),
        "jump_line_to" => build::jump_line_to(n(0), n(1), n(2), n(3)),
        "move_joints" => build::move_joints(n(0), n(1), n(2), n(3)),
        "line_joints" => build::line_joints(n(0), n(1), n(2), n(3)),
        "jump_joints" => build::jump_joints(n(0), n(1), n(2), n(3)),
        "move_by" => build::move_by(n(0), n(1), n(2), n(3)),
        "line_by" => build::line_by(n(0), n(1), n(2), n(3)),
        "move_joints_by" => build::move_joints_by(n(0), n(1), n(2), n(3)),
        "arc_to" => build::arc_to(args.four(0), args.four(1)),
        "circle" => build::circle(args.four(0), args.four(1), args.whole(2)),
        "path_to" => build::path_to(n(0), n(1), n(2)),
        "path_by" => build::path_by(n(0), n(1), n(2)),
        "engrave_to" => build::engrave_to(n(0), n(1), n(2), n(3)),
        "engrave_by" => build::engrave_by(n(0), n(1), n(2), n(3)),
        "home" => build::home(),
        "home_at" => build::home_at(n(0), n(1), n(2), n(3)),
        "check_lost_steps" => build::check_lost_steps(),
        "lost_step_threshold" => build::lost_step_threshold(n(0)),
        "speed" => build::speed(n(0), n(1)),
        "joint_speed" => build::joint_speed(args.four(0), args.four(1)),
        "line_speed" => build::line_speed(n(0), n(1)),
        "path_speed" => build::path_speed(n(0), n(1)),
        "arc_speed" => build::arc_speed(n(0), n(1)),
        "jump_height" => build::jump_height(n(0), n(1)),
        "jump_heights" => build::jump_heights(n(0), n(1), n(2)),
        "jog_speed" => build::jog_speed(n(0), n(1)),
        "jog_joint_speed" => build::jog_joint_speed(args.four(0), args.four(1)),
        "jog_axis_speed" => build::jog_axis_speed(args.four(0), args.four(1)),
        "jog_rail_speed" => build::jog_rail_speed(n(0), n(1)),
        "tool_named" => build::tool_named(args.0[0].as_str().expect("a name")).expect("a tool"),
        "suction" => build::suction(args.flag(0)),
        "grip" => build::grip(),
        "release" => build::release(),
        "pump_off" => build::pump_off(),
        "laser" => build::laser(args.flag(0)),
        "wait" => build::wait(Duration::from_secs_f32(n(0))),
        "wait_for_level" => build::wait_for_level(args.whole(0), args.flag(1)),
        "wait_below" => build::wait_below(args.whole(0), args.whole(1)),
        "wait_at_most" => build::wait_at_most(args.whole(0), args.whole(1)),
        "wait_at_least" => build::wait_at_least(args.whole(0), args.whole(1)),
        "wait_above" => build::wait_above(args.whole(0), args.whole(1)),
        "multiplex" => build::multiplex(args.whole(0), args.named(1)),
        "output" => build::output(args.whole(0), args.flag(1)),
        "pwm" => build::pwm(args.whole(0), n(1), n(2)),
        "servo" => build::servo(args.whole(0), n(1)),
        "rail" => build::rail(args.flag(0), args.named(1)),
        "move_with_rail" => build::move_with_rail(n(0), n(1), n(2), n(3), n(4)),
        "rail_by" => build::rail_by(n(0)),
        "rail_speed" => build::rail_speed(n(0), n(1)),
        "motor" => build::motor(args.named(0), args.whole(1)),
        "motor_by" => build::motor_by(args.named(0), args.whole(1), args.whole(2)),
        "conveyor" => build::conveyor(args.named(0), n(1)),
        "conveyor_by" => build::conveyor_by(args.named(0), n(1), n(2)),
        "color_sensor" => build::color_sensor(args.named(0), args.flag(1), args.named(2)),
        "infrared" => build::infrared(args.named(0), args.flag(1), args.named(2)),
        _ => return query(name, args),
    };
    FrameBuf::set(&set, Ctrl::QUEUED).expect("a frame")
}

fn query(name: &str, args: Args<'_>) -> FrameBuf {
    let query = match name {
        "color_at" => FrameBuf::get(&build::color_at(args.named(0)), ColorSensor::ROW),
        "infrared_at" => FrameBuf::get(&build::infrared_at(args.named(0)), IrSwitch::ROW),
        "level_at" => FrameBuf::get(&build::level_at(args.whole(0)), IoDi::ROW),
        "analog_at" => FrameBuf::get(&build::analog_at(args.whole(0)), IoAdc::ROW),
        _ => panic!("{name} is no builder"),
    };
    query.expect("a frame")
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn builders_give_the_bytes_of_the_table() {
    let table: Vec<Value> = serde_json::from_str(TABLE).expect("JSON");
    for entry in &table {
        let name = entry["name"].as_str().expect("a name");
        let frame = built(name, Args(entry["args"].as_array().expect("arguments")));
        let frame = frame.frame();
        let found = (u64::from(frame.id()), hex(frame.params()));
        let wanted = (&entry["id"], &entry["params"]);
        assert_eq!((&found.0.into(), &found.1.into()), wanted, "{name}");
    }
}

#[test]
fn each_builder_is_in_the_table() {
    let table: Vec<Value> = serde_json::from_str(TABLE).expect("JSON");
    let names = table.iter().map(|entry| entry["name"].as_str());
    let mut known: BTreeSet<_> = names.map(|name| name.expect("a name").to_owned()).collect();
    known.extend(ELSEWHERE.map(str::to_owned));
    let mut there = BTreeSet::new();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/build");
    for file in fs::read_dir(sources).expect("the builders") {
        let source = fs::read_to_string(file.expect("a file").path()).expect("a source");
        let functions = source
            .lines()
            .filter_map(|line| line.strip_prefix("pub fn "));
        there.extend(functions.filter_map(|line| Some(line.split_once('(')?.0.to_owned())));
    }
    assert_eq!(there, known);
}
