//! Settings that a program changes and that are given back at its end.

use magician::commands::{
    ArcParams, CpParams, PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpJump2Params,
    PtpLParams,
};
use magician::{Arm, Set};

use crate::debts::Debts;
use crate::failure::Failure;

/// Owes the arm what these commands change, as it is now: speeds and heights of jumps. The tool stays, and so does what is no
/// setting of a motion.
pub(super) async fn owe<'s>(
    arm: &Arm,
    debts: &Debts,
    changes: impl Iterator<Item = &'s Set>,
) -> Result<(), Failure> {
    let mut known = Vec::new();
    for change in changes {
        let kind = std::mem::discriminant(change);
        if known.contains(&kind) {
            continue;
        }
        known.push(kind);
        match change {
            Set::PtpJointParams(_) => debts.owe(arm.get::<PtpJointParams>().await?),
            Set::PtpCoordinateParams(_) => debts.owe(arm.get::<PtpCoordinateParams>().await?),
            Set::PtpCommonParams(_) => debts.owe(arm.get::<PtpCommonParams>().await?),
            // One height is both heights of the second set.
            Set::PtpJumpParams(_) | Set::PtpJump2Params(_) => {
                debts.owe(arm.get::<PtpJump2Params>().await?);
            }
            Set::PtpLParams(_) => debts.owe(arm.get::<PtpLParams>().await?),
            Set::CpParams(_) => debts.owe(arm.get::<CpParams>().await?),
            Set::ArcParams(_) => debts.owe(arm.get::<ArcParams>().await?),
            _ => {}
        }
    }
    Ok(())
}
