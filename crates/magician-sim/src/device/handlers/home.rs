//! Homing (document 1.6, model section 11).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::convert::to_wire;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};

impl Report for HomeParams {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.home.unwrap_or_else(|| {
            let joints = cx.firmware.model.homing.joints;
            let [x, y, z, r] = to_wire(cx.geometry().forward(&joints).to_array());
            Self { x, y, z, r }
        })
    }
}

impl Apply for HomeParams {
    /// Stored without a look: whether the arm can get there shows when it homes (model section 11).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.home = Some(*self);
        Effects::none()
    }
}

impl Apply for HomeCmd {
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::Home.into()
    }
}

impl Report for AutoLeveling {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            result: cx.store.settings.auto_leveling.accuracy,
        }
    }
}

impl Apply for SetAutoLeveling {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.auto_leveling = *self;
        Effect::NotSimulated.into()
    }
}
