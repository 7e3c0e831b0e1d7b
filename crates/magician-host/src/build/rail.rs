//! The sliding rail under the arm, with a carriage from 0 to 1000 mm (model section 12).

use magician_protocol::commands::{
    JogLParams, Pose, PtpLParams, PtpPoWithLCmd, PtpWithLCmd, SetDeviceWithL,
};
use magician_protocol::{PtpMode, RailVersion, Set};

use crate::{Error, ErrorCode, Result, message};

/// Declares that the arm is on a rail, and its generation (document 1.3.4, errata E15). Without
/// this the arm ignores rail positions silently.
#[must_use]
pub fn rail(on: bool, version: RailVersion) -> Set {
    SetDeviceWithL {
        with_l: on.into(),
        version: Some(version),
    }
    .into()
}

/// Moves to a pose, as [`move_to`](super::move_to), and to `l` mm on the rail (0 to 1000) at the
/// same time (document 1.10.7).
#[must_use]
pub fn move_with_rail(x: f32, y: f32, z: f32, r: f32, l: f32) -> Set {
    let ptp_mode = PtpMode::MovjXyz;
    PtpWithLCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
        l,
    }
    .into()
}

/// Makes any point-to-point move include the rail: to `l` mm (0 to 1000), or by that distance if
/// the move is an increment (document 1.10.7 and 1.10.10).
///
/// Arm and rail start and end together. Outputs that the move switches are kept.
///
/// ```
/// use magician_host::build;
///
/// let over_there = build::with_rail(build::jump_to(220.0, 0.0, -20.0, 0.0), 600.0)?;
/// assert!(build::with_rail(build::suction(true), 600.0).is_err());
/// # Ok::<(), magician_host::Error>(())
/// ```
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) for any other command than a point-to-point
/// move, and for a move with more than 56 outputs.
pub fn with_rail(command: Set, l: f32) -> Result<Set> {
    macro_rules! on_rail {
        ($to:ident, $ptp:ident $(, $po:ident)?) => {
            $to {
                ptp_mode: $ptp.ptp_mode,
                x: $ptp.x,
                y: $ptp.y,
                z: $ptp.z,
                r: $ptp.r,
                l,
                $($po: $ptp.$po,)?
            }
            .into()
        };
    }
    match command {
        Set::PtpCmd(ptp) => Ok(on_rail!(PtpWithLCmd, ptp)),
        Set::PtpWithLCmd(ptp) => Ok(on_rail!(PtpWithLCmd, ptp)),
        // The list fits the frame without a rail position, but not with one.
        Set::PtpPoCmd(ptp) if ptp.po.as_slice().len() > MAX_OUTPUTS => {
            Err(Error::invalid(message!(
                "a move with the rail can switch at most {most} outputs",
                most = MAX_OUTPUTS
            )))
        }
        Set::PtpPoCmd(ptp) => Ok(on_rail!(PtpPoWithLCmd, ptp, po)),
        Set::PtpPoWithLCmd(ptp) => Ok(on_rail!(PtpPoWithLCmd, ptp, po)),
        other => Err(no_move(&other)),
    }
}

/// Largest number of outputs of a move with the rail (errata E29).
pub(super) const MAX_OUTPUTS: usize = 56;

pub(super) fn no_move(command: &Set) -> Error {
    let message = message!("it is not a point-to-point move");
    Error::new(ErrorCode::WrongCommand, message).with_command(command.row().set_name)
}

/// Moves only the carriage to `l` mm (0 to 1000); the arm keeps the joint angles of this pose, as
/// it last reported. [`rail_by`] needs no pose.
#[must_use]
pub fn rail_to(l: f32, pose: &Pose) -> Set {
    let [x, y, z, r] = pose.joint_angle;
    PtpWithLCmd {
        // There is no command for the carriage alone, so this command keeps the arm at its joints.
        ptp_mode: PtpMode::MovjAngle,
        x,
        y,
        z,
        r,
        l,
    }
    .into()
}

/// Moves only the carriage, by this distance, mm; the arm keeps its joint angles.
#[must_use]
pub fn rail_by(dl: f32) -> Set {
    PtpWithLCmd {
        // Increments of 0 keep the joints whatever they are, so no pose is needed.
        ptp_mode: PtpMode::MovjAngleInc,
        x: 0.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        l: dl,
    }
    .into()
}

/// Sets speed (mm/s) and acceleration (mm/s2) on the rail in point-to-point moves. The ratios of
/// [`speed`](super::speed()) scale them (document 1.10.6, errata E26).
#[must_use]
pub fn rail_speed(velocity: f32, acceleration: f32) -> Set {
    PtpLParams {
        velocity,
        acceleration,
    }
    .into()
}

/// Sets speed (mm/s) and acceleration (mm/s2) of jogs on the rail. [`jog_speed`](super::jog_speed)
/// scales the speed (document 1.9.5, errata E25).
#[must_use]
pub fn jog_rail_speed(velocity: f32, acceleration: f32) -> Set {
    JogLParams {
        velocity,
        acceleration,
    }
    .into()
}
