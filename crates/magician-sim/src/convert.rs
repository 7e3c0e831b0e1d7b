//! Conversion between the binary32 of the protocol and the binary64 of the planner.
//!
//! All conversions are here, so that a value is rounded once and only at the output (model section
//! 3).

use magician_motion::ArmState;
use magician_protocol::commands;

/// Rounds to the nearest binary32.
pub(crate) fn to_wire<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

/// Widens to binary64; exact.
pub(crate) fn from_wire<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// Answer to GetPose.
pub(crate) fn pose_to_wire(arm: &ArmState) -> commands::Pose {
    let [x, y, z, r] = to_wire(arm.pose.to_array());
    let joint_angle = to_wire(arm.joints.to_array());
    commands::Pose {
        x,
        y,
        z,
        r,
        joint_angle,
    }
}

/// Converts seconds to the nearest whole microsecond. Negative values and NaN give 0, and what is
/// too large the maximum.
pub(crate) fn micros(seconds: f64) -> crate::Micros {
    // A cast of a float saturates, and takes NaN to 0.
    (seconds * 1e6).round() as crate::Micros
}
