//! Builders of commands by their bytes: `data/builders.json` has each with arguments, id and
//! parameters. Python writes the builders again, and `test_words.py` holds them to the same file.

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::fs;
use std::path::Path;
use std::time::Duration;

use magician_host::words;
use magician_protocol::commands::{ColorSensor, IoAdc, IoDi, IrSwitch};
use magician_protocol::{Ctrl, FrameBuf, Readable};
use serde_json::Value;

const TABLE: &str = include_str!("data/builders.json");

/// Builders that take or give other things than numbers; they have tests of their own.
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

    /// A value with a name, by its number.
    fn named<T: From<u8>>(self, at: usize) -> T {
        self.whole::<u8>(at).into()
    }

    fn flag(self, at: usize) -> bool {
        self.0[at].as_bool().expect("true or false")
    }
}

/// What a builder makes of its arguments.
fn built(name: &str, args: Args<'_>) -> FrameBuf {
    let n = |at| args.number(at);
    let set = match name {
        "move_to" => words::move_to(n(0), n(1), n(2), n(3)),
        "line_to" => words::line_to(n(0), n(1), n(2), n(3)),
        "jump_to" => words::jump_to(n(0), n(1), n(2), n(3)),
        "jump_line_to" => words::jump_line_to(n(0), n(1), n(2), n(3)),
        "move_joints" => words::move_joints(n(0), n(1), n(2), n(3)),
        "line_joints" => words::line_joints(n(0), n(1), n(2), n(3)),
        "jump_joints" => words::jump_joints(n(0), n(1), n(2), n(3)),
        "move_by" => words::move_by(n(0), n(1), n(2), n(3)),
        "line_by" => words::line_by(n(0), n(1), n(2), n(3)),
        "move_joints_by" => words::move_joints_by(n(0), n(1), n(2), n(3)),
        "arc_to" => words::arc_to(args.four(0), args.four(1)),
        "circle" => words::circle(args.four(0), args.four(1), args.whole(2)),
        "path_to" => words::path_to(n(0), n(1), n(2)),
        "path_by" => words::path_by(n(0), n(1), n(2)),
        "engrave_to" => words::engrave_to(n(0), n(1), n(2), n(3)),
        "engrave_by" => words::engrave_by(n(0), n(1), n(2), n(3)),
        "home" => words::home(),
        "home_at" => words::home_at(n(0), n(1), n(2), n(3)),
        "check_lost_steps" => words::check_lost_steps(),
        "lost_step_threshold" => words::lost_step_threshold(n(0)),
        "speed" => words::speed(n(0), n(1)),
        "joint_speed" => words::joint_speed(args.four(0), args.four(1)),
        "line_speed" => words::line_speed(n(0), n(1)),
        "path_speed" => words::path_speed(n(0), n(1)),
        "arc_speed" => words::arc_speed(n(0), n(1)),
        "jump_height" => words::jump_height(n(0), n(1)),
        "jump_heights" => words::jump_heights(n(0), n(1), n(2)),
        "jog_speed" => words::jog_speed(n(0), n(1)),
        "jog_joint_speed" => words::jog_joint_speed(args.four(0), args.four(1)),
        "jog_axis_speed" => words::jog_axis_speed(args.four(0), args.four(1)),
        "jog_rail_speed" => words::jog_rail_speed(n(0), n(1)),
        "tool_named" => words::tool_named(args.0[0].as_str().expect("a name")).expect("a tool"),
        "suction" => words::suction(args.flag(0)),
        "grip" => words::grip(),
        "release" => words::release(),
        "pump_off" => words::pump_off(),
        "laser" => words::laser(args.flag(0)),
        "wait" => words::wait(Duration::from_secs_f32(n(0))),
        "wait_for_level" => words::wait_for_level(args.whole(0), args.flag(1)),
        "wait_below" => words::wait_below(args.whole(0), args.whole(1)),
        "wait_at_most" => words::wait_at_most(args.whole(0), args.whole(1)),
        "wait_at_least" => words::wait_at_least(args.whole(0), args.whole(1)),
        "wait_above" => words::wait_above(args.whole(0), args.whole(1)),
        "multiplex" => words::multiplex(args.whole(0), args.named(1)),
        "output" => words::output(args.whole(0), args.flag(1)),
        "pwm" => words::pwm(args.whole(0), n(1), n(2)),
        "servo" => words::servo(args.whole(0), n(1)),
        "rail" => words::rail(args.flag(0), args.named(1)),
        "move_with_rail" => words::move_with_rail(n(0), n(1), n(2), n(3), n(4)),
        "rail_by" => words::rail_by(n(0)),
        "rail_speed" => words::rail_speed(n(0), n(1)),
        "motor" => words::motor(args.named(0), args.whole(1)),
        "motor_by" => words::motor_by(args.named(0), args.whole(1), args.whole(2)),
        "conveyor" => words::conveyor(args.named(0), n(1)),
        "conveyor_by" => words::conveyor_by(args.named(0), n(1), n(2)),
        "color_sensor" => words::color_sensor(args.named(0), args.flag(1), args.named(2)),
        "infrared" => words::infrared(args.named(0), args.flag(1), args.named(2)),
        _ => return query(name, args),
    };
    FrameBuf::set(&set, Ctrl::QUEUED).expect("a frame")
}

fn query(name: &str, args: Args<'_>) -> FrameBuf {
    let query = match name {
        "color_at" => FrameBuf::get(&words::color_at(args.named(0)), ColorSensor::ROW),
        "infrared_at" => FrameBuf::get(&words::infrared_at(args.named(0)), IrSwitch::ROW),
        "level_at" => FrameBuf::get(&words::level_at(args.whole(0)), IoDi::ROW),
        "analog_at" => FrameBuf::get(&words::analog_at(args.whole(0)), IoAdc::ROW),
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
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/words");
    for file in fs::read_dir(sources).expect("the builders") {
        let source = fs::read_to_string(file.expect("a file").path()).expect("a source");
        let functions = source
            .lines()
            .filter_map(|line| line.strip_prefix("pub fn "));
        there.extend(functions.filter_map(|line| Some(line.split_once('(')?.0.to_owned())));
    }
    assert_eq!(there, known);
}
