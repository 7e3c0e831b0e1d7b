//! How fast, and how high.

use magician_protocol::commands::{
    ArcParams, CpParams, JogCommonParams, PtpCommonParams, PtpCoordinateParams, PtpJointParams,
    PtpJump2Params, PtpJumpParams,
};
use magician_protocol::{Flag, Set};

/// Share of the set speeds and accelerations that point-to-point moves use, percent.
#[must_use]
pub fn speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    PtpCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}

/// Speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves.
#[must_use]
pub fn joint_speed(velocity: [f32; 4], acceleration: [f32; 4]) -> Set {
    PtpJointParams {
        velocity,
        acceleration,
    }
    .into()
}

/// Speed (mm/s) and acceleration (mm/s2) of the tool on straight lines; its rotation has half of
/// each in degrees, as at power-up.
#[must_use]
pub fn line_speed(velocity: f32, acceleration: f32) -> Set {
    PtpCoordinateParams {
        xyz_velocity: velocity,
        r_velocity: velocity / 2.0,
        xyz_acceleration: acceleration,
        r_acceleration: acceleration / 2.0,
    }
    .into()
}

/// Most speed (mm/s) and acceleration (mm/s2) on a continuous path.
#[must_use]
pub fn path_speed(velocity: f32, acceleration: f32) -> Set {
    CpParams {
        plan_acc: acceleration,
        junction_vel: velocity,
        acc_or_period: acceleration,
        real_time_track: Flag::OFF,
    }
    .into()
}

/// Speed (mm/s) and acceleration (mm/s2) on arcs and circles, and of the rotation (deg/s, deg/s2).
#[must_use]
pub fn arc_speed(velocity: f32, acceleration: f32) -> Set {
    ArcParams {
        xyz_velocity: velocity,
        r_velocity: velocity,
        xyz_acceleration: acceleration,
        r_acceleration: acceleration,
    }
    .into()
}

/// How far a jump lifts above the higher of its ends, and the z it stays below.
#[must_use]
pub fn jump_height(height: f32, z_limit: f32) -> Set {
    PtpJumpParams {
        jump_height: height,
        z_limit,
    }
    .into()
}

/// How far a jump lifts above its start and above its end, and the z it stays below.
#[must_use]
pub fn jump_heights(start: f32, end: f32, z_limit: f32) -> Set {
    PtpJump2Params {
        start_jump_height: start,
        end_jump_height: end,
        z_limit,
    }
    .into()
}

/// Share of the set jog speeds and accelerations, percent.
#[must_use]
pub fn jog_speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    JogCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}
