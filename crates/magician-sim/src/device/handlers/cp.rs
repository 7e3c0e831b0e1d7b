//! Continuous path (document 1.11, model section 8).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report, stored};
use crate::device::motion::PathPoint;

stored!(
    CpCommonParams in cp_common,
    CpRHeadHoldEnable in cp_hold_rotation,
);

impl Report for CpParams {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.cp
    }
}

impl Apply for CpParams {
    /// For the segments that begin from now on; with a speed of 0 the path ends at rest.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.cp = *self;
        Effect::PathChanged.into()
    }
}

impl Apply for CpCmd {
    fn apply(&self, _: &mut Context<'_>, mode: ExecMode) -> Effects {
        let point = PathPoint {
            mode: self.cp_mode,
            numbers: [self.x, self.y, self.z],
        };
        Effect::Segment(point, 0.0, mode).into()
    }
}

impl Apply for CpLeCmd {
    fn apply(&self, _: &mut Context<'_>, mode: ExecMode) -> Effects {
        let point = PathPoint {
            mode: self.cp_mode,
            numbers: [self.x, self.y, self.z],
        };
        Effect::Segment(point, self.velocity_or_power, mode).into()
    }
}
