//! The messages. Their schemas stand in `schema/`.

use magician_motion::{JointAngles, Pose};
use magician_protocol::{Alarm, AlarmSet};
use serde::Serialize;

use crate::{Event, Output, QueueState, State};

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

#[derive(Serialize)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
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
    joints: [Joint; 4],
}

#[derive(Serialize)]
struct Joint {
    name: &'static str,
    position: f64,
}

impl Joints {
    pub(super) fn new(timestamp: Time, joints: &JointAngles) -> Self {
        let [j1, j2, j3, j4] = joints.to_array().map(f64::to_radians);
        let joint = |name, position| Joint { name, position };
        Self {
            timestamp,
            joints: [
                joint("J1", j1),
                joint("J2", j2),
                joint("J3", j3),
                joint("J4", j4),
            ],
        }
    }
}

#[derive(Serialize)]
pub(super) struct Queue {
    timestamp: Time,
    capacity: usize,
    waiting: usize,
    running: Option<u64>,
    current_index: u64,
    started: bool,
    held: bool,
    overflows: u64,
}

impl Queue {
    pub(super) fn new(timestamp: Time, queue: &QueueState) -> Self {
        Self {
            timestamp,
            capacity: queue.capacity,
            waiting: queue.waiting,
            running: queue.running,
            current_index: queue.current_index,
            started: queue.started,
            held: queue.held,
            overflows: queue.overflows,
        }
    }
}

/// Tools and pins.
#[derive(Clone, PartialEq, Serialize)]
pub(super) struct Io {
    suction: Switch,
    gripper: Switch,
    holding: bool,
    laser: bool,
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
    pub(super) fn of(state: &State) -> Self {
        Self {
            suction: state.suction.into(),
            gripper: state.gripper.into(),
            holding: state.holding,
            laser: state.laser,
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
    not_simulated: u64,
    events_lost: u64,
}

impl Status {
    pub(super) fn of(state: &State) -> Self {
        Self {
            moving: state.moving,
            homed: state.homed,
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

    pub(super) fn event(timestamp: Time, event: &Event) -> Self {
        let level = match event {
            Event::Accepted { .. } | Event::Started { .. } => Self::DEBUG,
            Event::Finished { .. } | Event::Dropped { .. } | Event::AlarmCleared { .. } => {
                Self::INFO
            }
            _ => Self::WARNING,
        };
        Self::new(timestamp, level, event.to_string())
    }

    pub(super) fn missed(timestamp: Time, count: u64) -> Self {
        let message = format!("{count} events are missing here");
        Self::new(timestamp, Self::WARNING, message)
    }
}
