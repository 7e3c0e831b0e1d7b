//! Speeds, accelerations and jump heights.

use magician_protocol::commands::{
    ArcParams, CpParams, JogCommonParams, JogCoordinateParams, JogJointParams, PtpCommonParams,
    PtpCoordinateParams, PtpJointParams, PtpJump2Params, PtpJumpParams,
};
use magician_protocol::{Flag, Set};

/// Sets the ratios of speed and acceleration of point-to-point moves, percent: above 0; more than
/// 100 counts as 100 (document 1.10.4).
#[must_use]
pub fn speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    PtpCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}

/// Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves, above 0
/// (document 1.10.1). The arm's ceilings are 320 deg/s, 480 for J4, and 300 deg/s2 (model section
/// 6).
#[must_use]
pub fn joint_speed(velocity: [f32; 4], acceleration: [f32; 4]) -> Set {
    PtpJointParams {
        velocity,
        acceleration,
    }
    .into()
}

/// Sets speed (mm/s) and acceleration (mm/s2) of the tool on straight lines (document 1.10.2). Its
/// rotation gets half of each in degrees, as at power-up. The ceilings are 300 mm/s and 400 mm/s2
/// (model section 6).
#[must_use]
pub fn line_speed(velocity: f32, acceleration: f32) -> Set {
    PtpCoordinateParams {
        xyz_velocity: velocity,
        // Derived, to save callers a parameter: the ratio is that of the arm at power-up.
        r_velocity: velocity / 2.0,
        xyz_acceleration: acceleration,
        r_acceleration: acceleration / 2.0,
    }
    .into()
}

/// Sets the largest speed (mm/s) and acceleration (mm/s2) on a continuous path (document 1.11.1,
/// errata E31). The arm slows down at corners by itself.
#[must_use]
pub fn path_speed(velocity: f32, acceleration: f32) -> Set {
    CpParams {
        plan_acc: acceleration,
        junction_vel: velocity,
        // The field is a period only if the host clocks the path (`real_time_track`).
        acc_or_period: acceleration,
        real_time_track: Flag::OFF,
    }
    .into()
}

/// Sets speed (mm/s) and acceleration (mm/s2) on arcs and circles, and of the rotation (deg/s,
/// deg/s2) (document 1.12.1). According to the vendor's code arcs use the speeds of [`line_speed`]
/// instead (model section 9): set both.
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

/// Sets the height of a jump above the higher of its ends, and the highest z, mm (document 1.10.3,
/// errata E30).
#[must_use]
pub fn jump_height(height: f32, z_limit: f32) -> Set {
    PtpJumpParams {
        jump_height: height,
        z_limit,
    }
    .into()
}

/// Sets the heights of a jump above its start and above its end, and the highest z, mm (document
/// 1.10.8, errata E27).
#[must_use]
pub fn jump_heights(start: f32, end: f32, z_limit: f32) -> Set {
    PtpJump2Params {
        start_jump_height: start,
        end_jump_height: end,
        z_limit,
    }
    .into()
}

/// Sets the ratio of jog speeds, percent: above 0; more than 100 counts as 100 (document 1.9.3).
/// The acceleration of jogs is not scaled (model section 6).
#[must_use]
pub fn jog_speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    JogCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}

/// Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in jogs of joints (document 1.9.1).
#[must_use]
pub fn jog_joint_speed(velocity: [f32; 4], acceleration: [f32; 4]) -> Set {
    JogJointParams {
        velocity,
        acceleration,
    }
    .into()
}

/// Sets speeds (mm/s; deg/s for r) and accelerations (mm/s2; deg/s2) of x, y, z and r in jogs along
/// coordinates (document 1.9.2).
#[must_use]
pub fn jog_axis_speed(velocity: [f32; 4], acceleration: [f32; 4]) -> Set {
    JogCoordinateParams {
        velocity,
        acceleration,
    }
    .into()
}
