//! Arcs and circles (document 1.12, model section 9).

use magician_motion::Pose;
use magician_protocol::commands::*;

use crate::convert::from_wire;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, stored};

stored!(ArcParams in arc, ArcCommonParams in arc_common);

impl Apply for ArcCmd {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let view = cx.view();
        let planner = view.planner(view.settings.arc_speeds());
        Effect::Move(view.plan_path(planner.arc(&view.arm(), &via, &to))).into()
    }
}

impl Apply for CircleCmd {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let view = cx.view();
        let planner = view.planner(view.settings.arc_speeds());
        let plan = planner.circle(&view.arm(), &via, &to, self.count);
        Effect::Move(view.plan_path(plan)).into()
    }
}
