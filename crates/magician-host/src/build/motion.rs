//! Motions of the arm, and homing.

use magician_protocol::commands::{
    ArcCmd, CircleCmd, CpCmd, CpLeCmd, HomeCmd, HomeParams, LostStepCmd, LostStepParams, PtpCmd,
};
use magician_protocol::{CpMode, PtpMode, Set};

fn ptp(ptp_mode: PtpMode, [x, y, z, r]: [f32; 4]) -> Set {
    PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
    .into()
}

/// Moves to a pose, all joints together; the tool follows a curve (document 1.10.5, MOVJ).
#[must_use]
pub fn move_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::MovjXyz, [x, y, z, r])
}

/// Moves to a pose on a straight line (MOVL).
#[must_use]
pub fn line_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::MovlXyz, [x, y, z, r])
}

/// Moves to a pose over obstacles: up, across with all joints together, down (JUMP).
/// [`jump_height`](super::jump_height) sets the height.
#[must_use]
pub fn jump_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::JumpXyz, [x, y, z, r])
}

/// Like [`jump_to`], with a straight line across (errata E28: seen to do nothing on some firmware).
#[must_use]
pub fn jump_line_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::JumpMovlXyz, [x, y, z, r])
}

/// Moves to joint angles.
#[must_use]
pub fn move_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::MovjAngle, [j1, j2, j3, j4])
}

/// Moves to joint angles with the tool on a straight line.
#[must_use]
pub fn line_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::MovlAngle, [j1, j2, j3, j4])
}

/// Moves to joint angles over obstacles.
#[must_use]
pub fn jump_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::JumpAngle, [j1, j2, j3, j4])
}

/// Moves by a displacement (mm, deg) from the arm's pose at that time, all joints together.
#[must_use]
pub fn move_by(dx: f32, dy: f32, dz: f32, dr: f32) -> Set {
    ptp(PtpMode::MovjXyzInc, [dx, dy, dz, dr])
}

/// Moves by a displacement (mm, deg) from the arm's pose at that time, on a straight line.
#[must_use]
pub fn line_by(dx: f32, dy: f32, dz: f32, dr: f32) -> Set {
    ptp(PtpMode::MovlXyzInc, [dx, dy, dz, dr])
}

/// Turns the joints by increments (deg) from their angles at that time.
#[must_use]
pub fn move_joints_by(d1: f32, d2: f32, d3: f32, d4: f32) -> Set {
    ptp(PtpMode::MovjAngleInc, [d1, d2, d3, d4])
}

/// Moves to `to` along the arc through `via`; both are x, y, z, r, and the r of `via` is ignored
/// (document 1.12.2, errata E33).
///
/// The three points, of which the arm's pose is the first, must be distinct and not on one line.
/// [`arc_speed`](super::arc_speed) sets the speed.
#[must_use]
pub fn arc_to(via: [f32; 4], to: [f32; 4]) -> Set {
    ArcCmd {
        cir_point: via,
        to_point: to,
    }
    .into()
}

/// Moves around the circle through the arm's pose, `via` and `over`, this number of turns, and ends
/// where it began; r does not change. Not in the vendor's document (errata E33).
#[must_use]
pub fn circle(via: [f32; 4], over: [f32; 4], turns: u32) -> Set {
    CircleCmd {
        cir_point: via,
        to_point: over,
        count: turns,
    }
    .into()
}

/// Adds a segment to a point to a continuous path (document 1.11.2, errata E31 and E32).
///
/// The tool does not stop between consecutive segments, and J4 does not turn.
/// [`path_speed`](super::path_speed) sets the speed.
#[must_use]
pub fn path_to(x: f32, y: f32, z: f32) -> Set {
    // The last field is reserved in CPCmd; in CPLECmd it is the laser power (errata E32).
    let (cp_mode, velocity_or_power) = (CpMode::Absolute, 0.0);
    CpCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    }
    .into()
}

/// Adds a segment to a continuous path, by a displacement from the end of the previous one.
#[must_use]
pub fn path_by(dx: f32, dy: f32, dz: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Relative, 0.0);
    CpCmd {
        cp_mode,
        x: dx,
        y: dy,
        z: dz,
        velocity_or_power,
    }
    .into()
}

/// Like [`path_to`], with the laser at this power on the way, 0 to 100 percent (document 1.11.3,
/// errata E32). End the path with [`laser(false)`](super::laser) or a segment of power 0.
#[must_use]
pub fn engrave_to(x: f32, y: f32, z: f32, power: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Absolute, power);
    CpLeCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    }
    .into()
}

/// Like [`engrave_to`], by a displacement from the end of the previous segment.
#[must_use]
pub fn engrave_by(dx: f32, dy: f32, dz: f32, power: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Relative, power);
    CpLeCmd {
        cp_mode,
        x: dx,
        y: dy,
        z: dz,
        velocity_or_power,
    }
    .into()
}

/// Finds the reference of J1 and moves to the home point (document 1.6.2). `Arm::home` also waits,
/// and clears the alarm that the arm raises at power-up.
#[must_use]
pub fn home() -> Set {
    // Reserved, and sent as 0 (errata E22).
    HomeCmd { reserved: 0 }.into()
}

/// Sets the home point, at which [`home`] ends from now on (document 1.6.1).
#[must_use]
pub fn home_at(x: f32, y: f32, z: f32, r: f32) -> Set {
    HomeParams { x, y, z, r }.into()
}

/// Compares the joints with their sensors. A lost step raises an alarm (errata E36).
#[must_use]
pub fn check_lost_steps() -> Set {
    LostStepCmd {}.into()
}

/// Sets the deviation from which a joint counts as lost, degrees; 5 at power-up (document 1.18.1).
/// Not queueable: send it as an immediate set.
#[must_use]
pub fn lost_step_threshold(degrees: f32) -> Set {
    LostStepParams { value: degrees }.into()
}
