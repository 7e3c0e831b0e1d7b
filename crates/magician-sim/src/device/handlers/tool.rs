//! The tool at the end of the arm (document 1.8).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};
use crate::device::io::tools::{AirTool, Told};

impl Report for EndEffectorParams {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.bias
    }
}

impl Apply for EndEffectorParams {
    /// The reported pose follows at once: it is computed from the joints when asked for. A motion under way goes where
    /// it was planned to go, a continuous path comes to rest at the end of its segment.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.settings.bias = *self;
        core.tool_changes();
        Step::Done
    }
}

impl Report for EndEffectorLaser {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        let Told { control, on } = core.actuators.laser_told;
        Self {
            is_ctrl_enabled: control,
            is_on: on,
        }
    }
}

impl Apply for SetEndEffectorLaser {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let (control, on) = (self.enable_ctrl, self.on);
        core.actuators.tell_laser(Told { control, on });
        Step::Done
    }
}

impl Report for EndEffectorSuctionCup {
    /// As it was set, whichever tool has the air.
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        let Told { control, on } = core.actuators.suction_told;
        Self {
            is_ctrl_enabled: control,
            is_sucked: on,
        }
    }
}

impl Apply for SetEndEffectorSuctionCup {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let (control, on) = (self.enable_ctrl, self.suck);
        core.actuators
            .tell_air(AirTool::Suction, Told { control, on });
        Step::Done
    }
}

impl Report for EndEffectorGripper {
    /// As it was set, whichever tool has the air.
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        let Told { control, on } = core.actuators.gripper_told;
        Self {
            is_ctrl_enabled: control,
            is_gripped: on,
        }
    }
}

impl Apply for SetEndEffectorGripper {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let (control, on) = (self.enable_ctrl, self.grip);
        core.actuators
            .tell_air(AirTool::Gripper, Told { control, on });
        Step::Done
    }
}
