//! The tool of the arm (document 1.8).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::device::io::tools::{AirTool, ToolCommand};
use crate::fidelity::{Assumption, AssumptionSet};

impl Report for EndEffectorParams {
    const ASSUMPTION: Assumption = Assumption::ToolBias;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        AssumptionSet::from(<Self as Report>::ASSUMPTION)
            .and_if(cx.has_tool_of_power_up(), Assumption::PowerUpTool)
    }

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.motion.tool
    }
}

impl Apply for EndEffectorParams {
    const ASSUMPTION: Assumption = Assumption::ToolBias;

    /// Sets the tool bias. The reported pose follows at once, because it is computed from the
    /// joints.
    ///
    /// A running motion goes to its planned target; a continuous path comes to rest at the end of
    /// its segment.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // Not checked: no source says that an arm refuses any bias.
        cx.store.settings.motion.tool = *self;
        Effect::ToolChanged.into()
    }
}

impl Report for EndEffectorLaser {
    const ASSUMPTION: Assumption = Assumption::Tools;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let ToolCommand { control, on } = cx.io.tools.laser_set();
        Self {
            is_ctrl_enabled: control,
            is_on: on,
        }
    }
}

impl Apply for SetEndEffectorLaser {
    const ASSUMPTION: Assumption = Assumption::Tools;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.on);
        cx.io.tools.set_laser(ToolCommand { control, on });
        Effects::none()
    }
}

impl Report for EndEffectorSuctionCup {
    const ASSUMPTION: Assumption = Assumption::Tools;

    /// The command as it was set, whichever tool has the air.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let ToolCommand { control, on } = cx.io.tools.air_set(AirTool::Suction);
        Self {
            is_ctrl_enabled: control,
            is_sucked: on,
        }
    }
}

impl Apply for SetEndEffectorSuctionCup {
    const ASSUMPTION: Assumption = Assumption::Tools;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).and(Assumption::VacuumDelay)
    }

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.suck);
        cx.io
            .tools
            .set_air(AirTool::Suction, ToolCommand { control, on });
        Effects::none()
    }
}

impl Report for EndEffectorGripper {
    const ASSUMPTION: Assumption = Assumption::Tools;

    /// The command as it was set, whichever tool has the air.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let ToolCommand { control, on } = cx.io.tools.air_set(AirTool::Gripper);
        Self {
            is_ctrl_enabled: control,
            is_gripped: on,
        }
    }
}

impl Apply for SetEndEffectorGripper {
    const ASSUMPTION: Assumption = Assumption::Tools;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).and(Assumption::GripperDelay)
    }

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.grip);
        cx.io
            .tools
            .set_air(AirTool::Gripper, ToolCommand { control, on });
        Effects::none()
    }
}
