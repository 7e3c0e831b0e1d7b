//! Arcs and circles (document 1.12, model section 9).

use magician_motion::Pose;
use magician_protocol::commands::*;

use crate::convert::from_wire;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, stored};
use crate::fidelity::{Assumption, AssumptionSet};

stored! {
    // Stored and read back only: arcs take the point-to-point speeds (model section 9).
    ArcParams in motion.arc: Parameters;
    ArcCommonParams in motion.arc_common: ArcRatio;
}

/// Assumptions of an arc through two points, also as part of a circle.
fn arc_assumptions(
    cx: &Context<'_>,
    basis: Assumption,
    [via, to]: [[f32; 4]; 2],
    mode: ExecMode,
) -> AssumptionSet {
    AssumptionSet::from(basis)
        .and(Assumption::ArcSpeeds)
        .union(cx.motion_assumptions(&[via, to].concat(), mode))
}

impl Apply for ArcCmd {
    const ASSUMPTION: Assumption = Assumption::ArcPath;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        arc_assumptions(cx, Self::ASSUMPTION, [self.cir_point, self.to_point], mode)
    }

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // The planner ignores the r of cirPoint (model section 9).
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let view = cx.view();
        let planner = view.planner(view.settings.motion.arc_speeds());
        Effect::Move(view.plan_path(planner.arc(&view.arm(), &via, &to))).into()
    }
}

impl Apply for CircleCmd {
    const ASSUMPTION: Assumption = Assumption::CircleTurns;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        arc_assumptions(cx, Self::ASSUMPTION, [self.cir_point, self.to_point], mode)
    }

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let view = cx.view();
        let planner = view.planner(view.settings.motion.arc_speeds());
        let plan = planner.circle(&view.arm(), &via, &to, self.count);
        Effect::Move(view.plan_path(plan)).into()
    }
}
