//! State of an arm in the forms of the API: JSON, changes since the previous state, and binary
//! frame.

use std::time::Duration;

use magician::Pin;
use magician::report::PoseReport;
use magician_protocol::commands::Pose;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::api::{FRAME_FLAGS, RpcError};
use crate::frame::{FRAME_FIELDS, StateFrame};

/// Names that a subscription in JSON may ask for.
pub const STATE_FIELDS: [&str; 23] = [
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

/// State of the tools. `None` means unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolReading {
    /// Name of the mounted tool, if the offset of the tip is that of a known tool.
    pub name: Option<&'static str>,
    /// Offset of the tip from the flange, mm.
    pub bias: Option<[f32; 3]>,
    /// True if the suction cup is on.
    pub suction: Option<bool>,
    /// `open`, `closed` or `off`.
    pub gripper: Option<&'static str>,
    /// True if the laser may burn.
    pub laser: Option<bool>,
}

/// Reading of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmReading {
    /// Age of the pose when it was reported.
    pub age: Duration,
    /// Position of the tip and joint angles.
    pub pose: Pose,
    /// Index of the last finished command of the queue.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Codes of the active alarms.
    pub alarms: Vec<u8>,
    /// True if one of the alarms holds the queue.
    pub alarm_holds: bool,
    /// True if there is a line to the arm.
    pub link: bool,
    /// True if the arm moves or may be moving.
    pub moving: bool,
    /// True if the arm was homed since it was switched on. `None` if unknown.
    pub homed: Option<bool>,
    /// Position on the rail, mm. `None` without a rail.
    pub rail: Option<f32>,
    /// State of the tools.
    pub tool: ToolReading,
    /// Share of the set speed of moves, percent. `None` if unknown.
    pub speed: Option<f32>,
    /// Levels of the watched pins: kind, address, value.
    pub pins: Vec<(&'static str, u8, u16)>,
}

/// Members that the station adds to a reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StateContext {
    /// Time of the pose, Unix seconds.
    pub(crate) t: f64,
    pub(crate) arm: String,
    pub(crate) job: Option<String>,
    pub(crate) job_runs: bool,
    pub(crate) jog: Option<String>,
    pub(crate) holder: Value,
}

/// Returns a single-precision number as JSON with its shortest decimal digits.
pub(crate) fn short(number: f32) -> Value {
    number
        .to_string()
        .parse::<f64>()
        .map_or(Value::Null, |number| json!(number))
}

/// Converts a value to JSON through text. Direct conversion would widen single-precision numbers to
/// long decimals such as 0.10000000149.
pub(crate) fn to_value(value: &impl Serialize) -> Result<Value, RpcError> {
    let text = serde_json::to_string(value);
    let value = text.and_then(|text| serde_json::from_str(&text));
    value.map_err(|error| RpcError::internal(error.to_string()))
}

/// Returns the name of a pin's kind in the API.
pub(crate) const fn pin_kind(pin: Pin) -> &'static str {
    match pin {
        Pin::Input(_) => "input",
        Pin::Output(_) => "output",
        Pin::Analog(_) => "analog",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Returns a pose in the form of `pose --json`.
pub(crate) fn pose(pose: &Pose) -> Map<String, Value> {
    match to_value(&PoseReport::from(*pose)) {
        Ok(Value::Object(fields)) => fields,
        // Cannot happen: a pose report is an object of numbers.
        _ => Map::new(),
    }
}

impl ArmReading {
    /// True if all these pins are in the reading.
    pub(crate) fn has(&self, pins: &[Pin]) -> bool {
        let mut pins = pins.iter();
        pins.all(|pin| {
            let known = |(kind, address, _): &(&str, u8, u16)| {
                *kind == pin_kind(*pin) && *address == pin.address()
            };
            self.pins.iter().any(known)
        })
    }

    /// Returns all fields as JSON.
    pub(crate) fn fields(&self, context: &StateContext) -> Map<String, Value> {
        let tool = &self.tool;
        let pins = self.pins.iter().map(
            |(kind, address, value)| json!({"kind": kind, "address": address, "value": value}),
        );
        let rest = json!({
            "t": context.t,
            "arm": context.arm,
            "current_index": self.current_index,
            "left_space": self.left_space,
            // Only codes: `arm.alarms` explains them.
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
            "job": context.job,
            "jog": context.jog,
            "holder": context.holder,
        });
        let mut fields = pose(&self.pose);
        if let Value::Object(rest) = rest {
            fields.extend(rest);
        }
        fields
    }

    /// Returns the binary frame.
    pub(crate) fn frame(
        &self,
        context: &StateContext,
        subscription: u16,
        sequence: u32,
    ) -> Vec<u8> {
        let bits = [
            self.link,
            self.moving,
            self.alarm_holds,
            self.tool.laser == Some(true),
            context.jog.is_some(),
            context.job_runs,
            !context.holder.is_null(),
        ];
        // Same order as the table FRAME_FLAGS, from which the API's description is generated.
        let flags = FRAME_FLAGS.iter().zip(bits).filter(|(_, on)| *on);
        let flags: u32 = flags.map(|((bit, ..), _)| bit).sum();
        let [j1, j2, j3, j4] = self.pose.joint_angle.map(f64::from);
        let Pose { x, y, z, r, .. } = self.pose;
        let values = [
            context.t,
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

/// Returns the fields that differ, and always `t`.
pub(crate) fn changes(before: &Map<String, Value>, now: &Map<String, Value>) -> Map<String, Value> {
    let changed = now
        .iter()
        .filter(|(name, value)| name.as_str() == "t" || before.get(name.as_str()) != Some(value));
    changed
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

/// Returns the fields that a binary frame does not carry.
pub(crate) fn fields_outside_frames(fields: &Map<String, Value>) -> Map<String, Value> {
    // `t` is in both: each message needs its own time.
    let carried = |name: &str| name != "t" && FRAME_FIELDS.contains(&name);
    let rest = fields.iter().filter(|(name, _)| !carried(name));
    rest.map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}
