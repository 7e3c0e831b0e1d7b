//! Continuous path (document 1.11, model section 8).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::motion::beyond;
use crate::device::handlers::{Apply, Report, stored};
use crate::device::motion::PathPoint;
use crate::fidelity::{Assumption, AssumptionSet};

stored! {
    // Neither has an effect: the vendor's simulator leaves r to drift with J1 (model section 8).
    CpCommonParams in cp_common: StoredWithoutEffect;
    CpRHeadHoldEnable in cp_hold_rotation: StoredWithoutEffect;
}

impl Report for CpParams {
    const ASSUMPTION: Assumption = Assumption::Parameters;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.motion.cp
    }
}

impl Apply for CpParams {
    const ASSUMPTION: Assumption = Assumption::Parameters;

    fn assumptions(&self, cx: &Context<'_>, _: ExecMode) -> AssumptionSet {
        let ceilings = &cx.firmware.model.ceilings;
        let ceilings = [ceilings.linear_velocity, ceilings.linear_acceleration];
        let beyond = beyond([self.junction_vel, self.plan_acc], ceilings);
        AssumptionSet::from(<Self as Apply>::ASSUMPTION).and_if(beyond, Assumption::BeyondCeilings)
    }

    /// Applies to segments that start from now on. With invalid speeds the path ends at rest.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.motion.cp = *self;
        Effect::PathChanged.into()
    }
}

/// Assumptions of a segment to a point.
fn segment_assumptions(
    cx: &Context<'_>,
    basis: Assumption,
    point: [f32; 3],
    mode: ExecMode,
) -> AssumptionSet {
    AssumptionSet::from(basis)
        .and(Assumption::CpRotation)
        .and(Assumption::CpTimes)
        .and(Assumption::CpFollows)
        .union(cx.motion_assumptions(&point, mode))
}

impl Apply for CpCmd {
    const ASSUMPTION: Assumption = Assumption::CpLaw;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        segment_assumptions(cx, Self::ASSUMPTION, [self.x, self.y, self.z], mode)
    }

    fn apply(&self, _: &mut Context<'_>, mode: ExecMode) -> Effects {
        let point = PathPoint {
            mode: self.cp_mode,
            numbers: [self.x, self.y, self.z],
        };
        // A plain segment switches the laser off.
        Effect::Segment(point, 0.0, mode).into()
    }
}

impl Apply for CpLeCmd {
    const ASSUMPTION: Assumption = Assumption::CpLaser;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        segment_assumptions(cx, Self::ASSUMPTION, [self.x, self.y, self.z], mode)
    }

    fn apply(&self, _: &mut Context<'_>, mode: ExecMode) -> Effects {
        let point = PathPoint {
            mode: self.cp_mode,
            numbers: [self.x, self.y, self.z],
        };
        Effect::Segment(point, self.velocity_or_power, mode).into()
    }
}
