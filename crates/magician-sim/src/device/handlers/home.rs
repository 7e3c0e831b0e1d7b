//! Homing (document 1.6, model section 11).

use magician_protocol::commands::*;
use magician_protocol::{NoArgs, Writable};

use crate::convert::to_wire;
use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};

impl Report for HomeParams {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.home.unwrap_or_else(|| {
            let joints = core.model.homing.joints;
            let [x, y, z, r] = to_wire(core.geometry().forward(&joints).to_array());
            Self { x, y, z, r }
        })
    }
}

impl Apply for HomeParams {
    /// Stored without a look: whether the arm can get there shows when it homes (model section 11).
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.settings.home = Some(*self);
        Step::Done
    }
}

impl Apply for HomeCmd {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.home()
    }
}

impl Report for AutoLeveling {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        Self {
            result: core.settings.auto_leveling.accuracy,
        }
    }
}

impl Apply for SetAutoLeveling {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.settings.auto_leveling = *self;
        core.not_simulated(Self::ROW)
    }
}
