//! Messages of all recordings. Their schemas are in `schema/`.

use magician_motion::{JointAngles, Pose};
use magician_protocol::{Alarm, AlarmSet};
use serde::Serialize;

const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// Name of the coordinate frame of poses: the arm's own coordinates.
const BASE: &str = "base";

/// An instant in the form of Foxglove's schemas.
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
pub(super) struct Vector3 {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
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
        // The sign is not normalised to w >= 0, so that r = 2 atan2(z, w) also gives angles beyond
        // half a turn.
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
    /// Creates the message from joint angles in degrees, and the rail's position in mm if there is
    /// a rail.
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

/// The command queue as a host sees it: without running command and state.
#[derive(Serialize)]
pub(super) struct HostQueue {
    pub(super) timestamp: Time,
    pub(super) capacity: u32,
    pub(super) waiting: u32,
    pub(super) current_index: u64,
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
    pub(super) const INFO: u8 = 2;
    pub(super) const WARNING: u8 = 3;

    /// Creates the message of an event noticed by a host.
    pub(super) fn noticed(timestamp: Time, warning: bool, message: &str) -> Self {
        let level = if warning { Self::WARNING } else { Self::INFO };
        Self::new(timestamp, level, message.to_owned())
    }

    pub(super) fn new(timestamp: Time, level: u8, message: String) -> Self {
        Self {
            timestamp,
            level,
            message,
            name: "arm",
            file: "",
            line: 0,
        }
    }
}
