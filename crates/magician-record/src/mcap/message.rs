//! The messages. Their schemas stand in `schema/`.

use std::fmt;

use magician_motion::{JointAngles, Pose, ToolBias};
use magician_protocol::{Alarm, AlarmSet, IoFunction};
use serde::Serialize;

use magician_sim::{Controller, Event, Output, PinState, QueueState, State, StepperState};

const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// The frame in which poses stand: that of the arm's own coordinates.
const BASE: &str = "base";

/// An instant as Foxglove's schemas have it.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Time {
    sec: u64,
    nsec: u64,
}

impl Time {
    pub(super) const fn at(nanos: u64) -> Self {
        Self {
            sec: nanos / NANOS_PER_SECOND,
            nsec: nanos % NANOS_PER_SECOND,
        }
    }
}

/// Something that is so at a time.
#[derive(Serialize)]
pub(super) struct At<'a, T> {
    timestamp: Time,
    #[serde(flatten)]
    value: &'a T,
}

#[derive(Serialize)]
pub(super) struct PoseInFrame {
    timestamp: Time,
    frame_id: &'static str,
    pose: Placed,
}

#[derive(Serialize)]
struct Placed {
    position: Vector3,
    orientation: Quaternion,
}

#[derive(Clone, PartialEq, Serialize)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}

impl From<ToolBias> for Vector3 {
    fn from(bias: ToolBias) -> Self {
        let ToolBias { x, y, z } = bias;
        Self { x, y, z }
    }
}

#[derive(Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl PoseInFrame {
    pub(super) fn new(timestamp: Time, pose: &Pose) -> Self {
        let [x, y, z, r] = pose.to_array();
        // Not brought into half a turn: the whole angle, turns and all, is twice the one of (z, w).
        let half = r.to_radians() / 2.0;
        Self {
            timestamp,
            frame_id: BASE,
            pose: Placed {
                position: Vector3 {
                    x: x / 1000.0,
                    y: y / 1000.0,
                    z: z / 1000.0,
                },
                orientation: Quaternion {
                    x: 0.0,
                    y: 0.0,
                    z: libm::sin(half),
                    w: libm::cos(half),
                },
            },
        }
    }
}

#[derive(Serialize)]
pub(super) struct Joints {
    timestamp: Time,
    joints: Vec<Joint>,
}

#[derive(Serialize)]
struct Joint {
    name: &'static str,
    position: f64,
}

impl Joints {
    /// Of joint angles in degrees and a rail's place in mm, if there is a rail.
    pub(super) fn new(timestamp: Time, joints: &JointAngles, rail: Option<f64>) -> Self {
        let angles = joints.to_array().map(f64::to_radians);
        let rail = rail.map(|mm| mm / 1000.0);
        let named = ["J1", "J2", "J3", "J4", "L"]
            .into_iter()
            .zip(angles.into_iter().chain(rail));
        Self {
            timestamp,
            joints: (named)
                .map(|(name, position)| Joint { name, position })
                .collect(),
        }
    }
}

#[derive(Serialize)]
pub(super) struct Queue {
    timestamp: Time,
    capacity: usize,
    waiting: usize,
    running: Option<u64>,
    running_id: Option<u8>,
    current_index: u64,
    started: bool,
    held: bool,
    overflows: u64,
}

/// The command queue as a host sees it, which is told less.
#[derive(Serialize)]
pub(super) struct QueueFromOutside {
    pub(super) timestamp: Time,
    pub(super) capacity: u32,
    pub(super) waiting: u32,
    pub(super) current_index: u64,
}

impl Queue {
    pub(super) fn new(timestamp: Time, queue: &QueueState) -> Self {
        Self {
            timestamp,
            capacity: queue.capacity,
            waiting: queue.waiting,
            running: queue.running,
            running_id: queue.running_id,
            current_index: queue.current_index,
            started: queue.started,
            held: queue.held,
            overflows: queue.overflows,
        }
    }
}

/// Tools, pins and stepper outputs.
#[derive(Clone, PartialEq, Serialize)]
pub(super) struct Io {
    suction: Switch,
    gripper: Switch,
    holding: bool,
    laser: bool,
    laser_power: f64,
    /// Those that were told anything.
    pins: Vec<Pin>,
    /// Pulses a second.
    steppers: [f64; 2],
}

#[derive(Clone, PartialEq, Serialize)]
struct Pin {
    address: u8,
    function: u8,
    able: bool,
    level: bool,
    frequency: f32,
    duty_cycle: f32,
    high: Option<f64>,
    input: bool,
    analog: u16,
}

impl Pin {
    fn of(pin: &PinState) -> Option<Self> {
        let told = pin.function != IoFunction::None
            || pin.level
            || pin.frequency != 0.0
            || pin.duty_cycle != 0.0;
        told.then(|| Self {
            address: pin.address,
            function: pin.function.into(),
            able: pin.able,
            level: pin.level,
            frequency: finite(pin.frequency),
            duty_cycle: finite(pin.duty_cycle),
            high: pin.signal.share(),
            input: pin.input,
            analog: pin.analog,
        })
    }
}

/// What JSON has no number for counts as the 0 that it is good for.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

#[derive(Clone, Copy, PartialEq, Serialize)]
struct Switch {
    commanded: bool,
    reached: bool,
}

impl From<Output> for Switch {
    fn from(output: Output) -> Self {
        Self {
            commanded: output.commanded,
            reached: output.reached,
        }
    }
}

impl Io {
    pub(super) fn of(arm: &Controller, state: &State) -> Self {
        let rate = |stepper: StepperState| stepper.pulses_per_second;
        Self {
            suction: state.suction.into(),
            gripper: state.gripper.into(),
            holding: state.holding,
            laser: state.laser,
            laser_power: state.laser_power,
            pins: arm.pins().iter().filter_map(Pin::of).collect(),
            steppers: arm.steppers().map(rate),
        }
    }

    pub(super) fn at(&self, timestamp: Time) -> At<'_, Self> {
        At {
            timestamp,
            value: self,
        }
    }
}

/// The arm as a whole.
#[derive(Clone, PartialEq, Serialize)]
pub(super) struct Status {
    moving: bool,
    homed: bool,
    unlocked: bool,
    program: bool,
    awaits_input: Option<u8>,
    plugged: bool,
    tool: Vector3,
    not_simulated: u64,
    events_lost: u64,
}

impl Status {
    pub(super) fn of(state: &State) -> Self {
        Self {
            moving: state.moving,
            homed: state.homed,
            unlocked: state.unlocked,
            program: state.program,
            awaits_input: state.awaits_input,
            plugged: state.line.plugged,
            tool: state.tool.into(),
            not_simulated: state.not_simulated,
            events_lost: state.events_lost,
        }
    }

    pub(super) fn at(&self, timestamp: Time) -> At<'_, Self> {
        At {
            timestamp,
            value: self,
        }
    }
}

#[derive(Serialize)]
pub(super) struct Alarms {
    timestamp: Time,
    blocking: bool,
    standing: Vec<Standing>,
}

#[derive(Serialize)]
struct Standing {
    code: u8,
    name: Option<&'static str>,
    blocks: bool,
}

impl Alarms {
    pub(super) fn new(timestamp: Time, alarms: &AlarmSet) -> Self {
        let standing = |code| Standing {
            code,
            name: Alarm::with_code(code).map(|alarm| alarm.name),
            blocks: Alarm::blocks(code),
        };
        Self {
            timestamp,
            blocking: alarms.blocking(),
            standing: alarms.codes().map(standing).collect(),
        }
    }
}

#[derive(Serialize)]
pub(super) struct Log {
    timestamp: Time,
    level: u8,
    message: String,
    name: &'static str,
    file: &'static str,
    line: u32,
}

impl Log {
    const DEBUG: u8 = 1;
    const INFO: u8 = 2;
    const WARNING: u8 = 3;

    /// What a host has noticed.
    pub(super) fn noticed(timestamp: Time, warning: bool, message: &str) -> Self {
        let level = if warning { Self::WARNING } else { Self::INFO };
        Self::new(timestamp, level, message.to_owned())
    }

    fn new(timestamp: Time, level: u8, message: String) -> Self {
        Self {
            timestamp,
            level,
            message,
            name: "arm",
            file: "",
            line: 0,
        }
    }

    pub(super) fn event(timestamp: Time, event: &Event, words: impl fmt::Display) -> Self {
        let level = match event {
            Event::Accepted { .. } | Event::Started { .. } | Event::RestsOn { .. } => Self::DEBUG,
            Event::QueueFull { .. }
            | Event::Refused { .. }
            | Event::AlarmRaised { .. }
            | Event::ToolUnknown { .. }
            | Event::HomeOutOfReach
            | Event::Slipped { .. }
            | Event::Reset
            | Event::Cable { plugged: false }
            | Event::NotSimulated { .. }
            | Event::BadFrame { .. }
            | Event::UnknownId { .. }
            | Event::Overrun { .. } => Self::WARNING,
            _ => Self::INFO,
        };
        Self::new(timestamp, level, words.to_string())
    }

    pub(super) fn missed(timestamp: Time, count: u64) -> Self {
        let message = format!("{count} events are missing here");
        Self::new(timestamp, Self::WARNING, message)
    }
}
