//! The state of an arm as the API has it: as JSON, as what has changed, and as a frame of bytes.

use std::time::Duration;

use magician::Pin;
use magician::report::PoseReport;
use magician_protocol::commands::Pose;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::api::{FRAME_FLAGS, RpcError};
use crate::frame::{FRAME_FIELDS, StateFrame};

/// The names of a subscription in JSON.
pub const FIELDS: [&str; 23] = [
    "t",
    "arm",
    "x",
    "y",
    "z",
    "r",
    "j1",
    "j2",
    "j3",
    "j4",
    "rail",
    "current_index",
    "left_space",
    "alarms",
    "link",
    "moving",
    "homed",
    "tool",
    "speed",
    "pins",
    "job",
    "jog",
    "holder",
];

/// What the tools of an arm do, as far as is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolReading {
    /// The tool that is mounted, if its tip is that of one with a name.
    pub name: Option<&'static str>,
    /// Its tip from the flange, mm.
    pub bias: Option<[f32; 3]>,
    /// Whether the suction cup is on.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`.
    pub gripper: Option<&'static str>,
    /// Whether the laser may burn.
    pub laser: Option<bool>,
}

/// An arm as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmReading {
    /// How long ago the pose was read when it was reported.
    pub age: Duration,
    /// Where the tip is, and the joints.
    pub pose: Pose,
    /// The command of the queue that was finished last.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Codes of the alarms that stand.
    pub alarms: Vec<u8>,
    /// Whether one of them holds the queue.
    pub alarm_holds: bool,
    /// Whether there is a line to the arm.
    pub link: bool,
    /// Whether it moves, or may.
    pub moving: bool,
    /// Whether it was homed since it was switched on, if that is known.
    pub homed: Option<bool>,
    /// Where on the rail, mm, if it has one.
    pub rail: Option<f32>,
    /// Its tools.
    pub tool: ToolReading,
    /// Share of the set speed of moves, percent, if it is known.
    pub speed: Option<f32>,
    /// Levels of the pins that are watched: kind, address, value.
    pub pins: Vec<(&'static str, u8, u16)>,
}

/// What the station knows of an arm beside its reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StateContext {
    /// When the pose was read, Unix seconds.
    pub(crate) t: f64,
    pub(crate) arm: String,
    pub(crate) job: Option<String>,
    pub(crate) job_runs: bool,
    pub(crate) jog: Option<String>,
    pub(crate) holder: Value,
}

/// A number of the wire in its shortest form.
pub(crate) fn short(number: f32) -> Value {
    number
        .to_string()
        .parse::<f64>()
        .map_or(Value::Null, |number| json!(number))
}

/// An object as its text has it: by way of the text, because a value in memory makes long decimals of single-precision numbers.
pub(crate) fn to_value(value: &impl Serialize) -> Result<Value, RpcError> {
    let text = serde_json::to_string(value);
    let value = text.and_then(|text| serde_json::from_str(&text));
    value.map_err(|error| RpcError::internal(error.to_string()))
}

/// What the API calls such a pin.
pub(crate) const fn pin_kind(pin: Pin) -> &'static str {
    match pin {
        Pin::Input(_) => "input",
        Pin::Output(_) => "output",
        Pin::Analog(_) => "analog",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// A pose as `pose --json` has it.
pub(crate) fn pose(pose: &Pose) -> Map<String, Value> {
    match to_value(&PoseReport::from(*pose)) {
        Ok(Value::Object(fields)) => fields,
        // It is an object of numbers.
        _ => Map::new(),
    }
}

impl ArmReading {
    /// Whether these pins are among those that were read.
    pub(crate) fn has(&self, pins: &[Pin]) -> bool {
        let mut pins = pins.iter();
        pins.all(|pin| {
            let known = |(kind, address, _): &(&str, u8, u16)| {
                *kind == pin_kind(*pin) && *address == pin.address()
            };
            self.pins.iter().any(known)
        })
    }

    /// All fields as JSON.
    pub(crate) fn fields(&self, beside: &StateContext) -> Map<String, Value> {
        let tool = &self.tool;
        let pins = self.pins.iter().map(
            |(kind, address, value)| json!({"kind": kind, "address": address, "value": value}),
        );
        let rest = json!({
            "t": beside.t,
            "arm": beside.arm,
            "current_index": self.current_index,
            "left_space": self.left_space,
            "alarms": self.alarms,
            "link": if self.link { "up" } else { "lost" },
            "moving": self.moving,
            "homed": self.homed,
            "rail": self.rail.map(short),
            "tool": {
                "name": tool.name,
                "bias": tool.bias.map(|bias| bias.map(short)),
                "suction": tool.suction,
                "gripper": tool.gripper,
                "laser": tool.laser,
            },
            "speed": self.speed.map(short),
            "pins": pins.collect::<Vec<_>>(),
            "job": beside.job,
            "jog": beside.jog,
            "holder": beside.holder,
        });
        let mut fields = pose(&self.pose);
        if let Value::Object(rest) = rest {
            fields.extend(rest);
        }
        fields
    }

    /// A frame of bytes.
    pub(crate) fn frame(&self, beside: &StateContext, subscription: u16, sequence: u32) -> Vec<u8> {
        let bits = [
            self.link,
            self.moving,
            self.alarm_holds,
            self.tool.laser == Some(true),
            beside.jog.is_some(),
            beside.job_runs,
            !beside.holder.is_null(),
        ];
        // In the order of the table that clients are shown.
        let flags = FRAME_FLAGS.iter().zip(bits).filter(|(_, on)| *on);
        let flags: u32 = flags.map(|((bit, ..), _)| bit).sum();
        let [j1, j2, j3, j4] = self.pose.joint_angle.map(f64::from);
        let Pose { x, y, z, r, .. } = self.pose;
        let values = [
            beside.t,
            f64::from(x),
            f64::from(y),
            f64::from(z),
            f64::from(r),
            j1,
            j2,
            j3,
            j4,
            self.rail.map_or(f64::NAN, f64::from),
            self.current_index as f64,
            f64::from(self.left_space),
            f64::from(flags),
        ];
        let frame = StateFrame {
            subscription,
            sequence,
            values,
        };
        frame.to_bytes()
    }
}

/// The fields that differ, with `t`.
pub(crate) fn changes(before: &Map<String, Value>, now: &Map<String, Value>) -> Map<String, Value> {
    let changed = now
        .iter()
        .filter(|(name, value)| name.as_str() == "t" || before.get(name.as_str()) != Some(value));
    changed
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

/// The fields that no frame of bytes carries.
pub(crate) fn beside_frames(fields: &Map<String, Value>) -> Map<String, Value> {
    let carried = |name: &str| name != "t" && FRAME_FIELDS.contains(&name);
    let rest = fields.iter().filter(|(name, _)| !carried(name));
    rest.map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}
