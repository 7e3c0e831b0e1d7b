//! Alarms (document 1.5).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::fidelity::Assumption;

impl Report for AlarmsState {
    const ASSUMPTION: Assumption = Assumption::AlarmBits;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            // 16 bytes, as a Magician sends (E20).
            alarms_state: cx.alarms.standing(),
        }
    }
}

impl Apply for ClearAlarmsState {
    const ASSUMPTION: Assumption = Assumption::ClearAlarms;

    // Alarms whose cause persists stay set; the device knows which (`clear_alarms`).
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ClearAlarms.into()
    }
}

impl Apply for ClearAllAlarmsState {
    // Id 21, which the document has for this; most hosts clear with id 20 (E19).
    const ASSUMPTION: Assumption = Assumption::ClearBy21;

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ClearAlarms.into()
    }
}
