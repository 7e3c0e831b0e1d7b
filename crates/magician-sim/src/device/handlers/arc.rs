//! Arcs and circles (document 1.12, model section 9).

use magician_motion::Pose;
use magician_protocol::Writable;
use magician_protocol::commands::*;

use crate::convert::from_wire;
use crate::device::Device;
use crate::device::dispatch::{Apply, Step, Turn, stored};

stored!(ArcParams in arc, ArcCommonParams in arc_common);

impl Apply for ArcCmd {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let plan = core.planner(core.arc_speeds()).arc(&core.arm(), &via, &to);
        core.follow(Self::ROW.id, plan)
    }
}

impl Apply for CircleCmd {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let [via, to] = [self.cir_point, self.to_point].map(|point| Pose::from(from_wire(point)));
        let plan = core
            .planner(core.arc_speeds())
            .circle(&core.arm(), &via, &to, self.count);
        core.follow(Self::ROW.id, plan)
    }
}
