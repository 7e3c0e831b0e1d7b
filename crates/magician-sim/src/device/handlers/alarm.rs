//! Alarms (document 1.5).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};

impl Report for AlarmsState {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        Self {
            alarms_state: core.alarms.standing(),
        }
    }
}

impl Apply for ClearAlarmsState {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.clear_alarms();
        Step::Done
    }
}

impl Apply for ClearAllAlarmsState {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.clear_alarms();
        Step::Done
    }
}
