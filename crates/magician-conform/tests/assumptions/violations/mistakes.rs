//! Mistakes that break no assumption of the list: what every controller of this kind would have to do.

use magician_protocol::commands::*;
use magician_protocol::{Effect, PtpMode};

use super::{profile, sets, time};
use crate::arm::{Violation, tell};

/// All hosts are one.
pub(crate) fn one_link() -> Violation {
    Violation::OneLink
}

/// However long a line is silent, the frame that has begun there goes on: time passes in pieces that are too short to notice.
pub(crate) fn no_timeout() -> Violation {
    time(|_| {})
}

/// Each piece of a frame is given up on its own.
pub(crate) fn impatience() -> Violation {
    Violation::Bytes(Box::new(|bytes| match bytes {
        [0xAA, 0xAA, count, ..] if bytes.len() == usize::from(*count) + 4 => bytes.to_vec(),
        _ => Vec::new(),
    }))
}

/// A queued parameter takes effect when it is received.
pub(crate) fn at_receipt() -> Violation {
    sets(|arm, set, queued| {
        if queued && matches!(set.row().effect, Effect::Setting | Effect::Laser) {
            tell(arm, set);
        }
    })
}

/// Joints that speed up and turn less than they may.
pub(crate) fn weak_joints() -> Violation {
    profile(|profile| {
        profile.ceilings.joint_acceleration = 250.0;
        profile.ceilings.joint_velocity[0] = 300.0;
    })
}

/// The acceleration goes by the ratio of the speed.
pub(crate) fn one_ratio() -> Violation {
    sets(|_, set, _| match set {
        Set::PtpCommonParams(ratios) => ratios.acceleration_ratio = ratios.velocity_ratio,
        Set::ArcCommonParams(ratios) => ratios.acceleration_ratio = ratios.velocity_ratio,
        _ => {}
    })
}

/// A jump lifts before its corners are looked at.
pub(crate) fn lifts_first() -> Violation {
    sets(|_, set, _| {
        if let Set::PtpCmd(ptp) = set
            && matches!(ptp.ptp_mode, PtpMode::JumpXyz | PtpMode::JumpMovlXyz)
        {
            *ptp = PtpCmd {
                ptp_mode: PtpMode::MovlXyzInc,
                x: 0.0,
                y: 0.0,
                z: 20.0,
                r: 0.0,
            };
        }
    })
}
