//! Point-to-point motion (document 1.10, model section 7).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::core::Core;
use crate::dispatch::{Apply, Report, Step, Turn, not_simulated, stored};

stored!(
    PtpJointParams in ptp_joint,
    PtpCoordinateParams in ptp_coordinate,
    PtpJump2Params in ptp_jump2,
    PtpCommonParams in ptp_common,
    PtpLParams in ptp_rail,
);
not_simulated!(PtpCmd, PtpWithLCmd, PtpPoCmd, PtpPoWithLCmd);

impl Report for PtpJumpParams {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        core.settings.ptp_jump
    }
}

impl Apply for PtpJumpParams {
    /// One height is both heights of the second set (model section 7).
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.settings.ptp_jump = *self;
        core.settings.ptp_jump2 = PtpJump2Params {
            start_jump_height: self.jump_height,
            end_jump_height: self.jump_height,
            z_limit: self.z_limit,
        };
        Step::Done
    }
}

impl Report for PtpTime {
    fn report(_: &mut Core, _: &GetPtpTime) -> Self {
        Self { ptp_time: 0 }
    }
}
