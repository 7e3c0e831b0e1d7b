//! The one place where the wire's 32-bit numbers become the planner's 64-bit ones, and are rounded back.

use magician_motion::ArmState;
use magician_protocol::commands;

/// Rounds once, to the nearest number that the wire has.
pub(crate) fn to_wire<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

/// Widens; exact.
pub(crate) fn from_wire<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// The answer to GetPose.
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

/// Seconds as whole microseconds, to the nearest; what is no such time is 0 or the end of time.
pub(crate) fn micros(seconds: f64) -> crate::Micros {
    // A cast of a float saturates, and takes NaN to 0.
    (seconds * 1e6).round() as crate::Micros
}
