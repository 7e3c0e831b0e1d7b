//! Mistakes that violate no listed assumption. Every controller of this kind has to avoid them.

use magician_protocol::commands::*;
use magician_protocol::{Effect, PtpMode};

use super::{profile, sets, time};
use crate::arm::{Violation, tell};

/// Treats all hosts as one.
pub(crate) fn one_link() -> Violation {
    Violation::OneLink
}

/// Never times out an incomplete frame, however long the line is silent: time passes in steps that
/// are shorter than the timeout.
pub(crate) fn never_times_out() -> Violation {
    time(|_| {})
}

/// Drops a frame that arrives in several pieces.
pub(crate) fn drops_split_frames() -> Violation {
    Violation::Bytes(Box::new(|bytes| match bytes {
        [0xAA, 0xAA, count, ..] if bytes.len() == usize::from(*count) + 4 => bytes.to_vec(),
        _ => Vec::new(),
    }))
}

/// Applies a queued parameter on receipt.
pub(crate) fn applies_at_receipt() -> Violation {
    sets(|arm, set, queued| {
        if queued && matches!(set.row().effect, Effect::Setting | Effect::Laser) {
            tell(arm, set);
        }
    })
}

/// Accelerates and turns the joints less than they may.
pub(crate) fn weak_joints() -> Violation {
    profile(|profile| {
        profile.ceilings.joint_acceleration = 250.0;
        profile.ceilings.joint_velocity[0] = 300.0;
    })
}

/// Uses the ratio of the speed for the acceleration too.
pub(crate) fn one_ratio_for_both() -> Violation {
    sets(|_, set, _| match set {
        Set::PtpCommonParams(ratios) => ratios.acceleration_ratio = ratios.velocity_ratio,
        Set::ArcCommonParams(ratios) => ratios.acceleration_ratio = ratios.velocity_ratio,
        _ => {}
    })
}

/// Lifts a jump before its corners are checked.
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
