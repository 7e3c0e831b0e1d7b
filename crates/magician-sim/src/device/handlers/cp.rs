//! Continuous path (document 1.11, model section 8).

use magician_protocol::commands::*;
use magician_protocol::{NoArgs, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn, stored};

stored!(
    CpCommonParams in cp_common,
    CpRHeadHoldEnable in cp_hold_rotation,
);

impl Report for CpParams {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.cp
    }
}

impl Apply for CpParams {
    /// For the segments that begin from now on; with a speed of 0 the path ends at rest.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.settings.cp = *self;
        core.replan_segment();
        Step::Done
    }
}

impl Apply for CpCmd {
    fn apply(&self, core: &mut Device, turn: Turn) -> Step {
        let Self {
            cp_mode, x, y, z, ..
        } = *self;
        core.begin_segment(Self::ROW.id, (cp_mode, [x, y, z]), 0.0, turn)
    }
}

impl Apply for CpLeCmd {
    fn apply(&self, core: &mut Device, turn: Turn) -> Step {
        let Self {
            cp_mode,
            x,
            y,
            z,
            velocity_or_power: power,
        } = *self;
        core.begin_segment(Self::ROW.id, (cp_mode, [x, y, z]), power, turn)
    }
}
