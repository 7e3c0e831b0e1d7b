//! The tool at the end of the arm (document 1.8).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::device::io::tools::{AirTool, Commanded};

impl Report for EndEffectorParams {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.bias
    }
}

impl Apply for EndEffectorParams {
    /// The reported pose follows at once: it is computed from the joints when asked for. A motion under way goes where
    /// it was planned to go, a continuous path comes to rest at the end of its segment.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.bias = *self;
        Effect::ToolChanged.into()
    }
}

impl Report for EndEffectorLaser {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let Commanded { control, on } = cx.io.tools.laser_set();
        Self {
            is_ctrl_enabled: control,
            is_on: on,
        }
    }
}

impl Apply for SetEndEffectorLaser {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.on);
        cx.io.tools.set_laser(Commanded { control, on });
        Effects::none()
    }
}

impl Report for EndEffectorSuctionCup {
    /// As it was set, whichever tool has the air.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let Commanded { control, on } = cx.io.tools.air_set(AirTool::Suction);
        Self {
            is_ctrl_enabled: control,
            is_sucked: on,
        }
    }
}

impl Apply for SetEndEffectorSuctionCup {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.suck);
        cx.io
            .tools
            .set_air(AirTool::Suction, Commanded { control, on });
        Effects::none()
    }
}

impl Report for EndEffectorGripper {
    /// As it was set, whichever tool has the air.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let Commanded { control, on } = cx.io.tools.air_set(AirTool::Gripper);
        Self {
            is_ctrl_enabled: control,
            is_gripped: on,
        }
    }
}

impl Apply for SetEndEffectorGripper {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let (control, on) = (self.enable_ctrl, self.grip);
        cx.io
            .tools
            .set_air(AirTool::Gripper, Commanded { control, on });
        Effects::none()
    }
}
