//! Colour sensor and infrared sensor (document 1.15.7 and 1.15.8, errata E42 and E43).

use magician_protocol::Flag;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

impl Report for ColorSensor {
    const ASSUMPTION: Assumption = Assumption::Sensors;

    /// A sensor that is off reads 0.
    fn report(cx: &mut Context<'_>, query: &GetColorSensor) -> Self {
        // Hosts send none, the port, or the port with a version (E42).
        let port = cx.io.color_sensors.asked(query.port);
        let [r, g, b] = port.map_or([0; 3], |port| cx.world.color(cx.now, port));
        Self { r, g, b }
    }
}

impl Apply for SetColorSensor {
    const ASSUMPTION: Assumption = Assumption::Sensors;

    /// The version of the sensor has no effect here.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        if cx.io.color_sensors.enable(self.port, self.is_enabled) {
            Effects::none()
        } else {
            Effect::Refuse(Refusal::Pin).into()
        }
    }
}

impl Report for IrSwitch {
    const ASSUMPTION: Assumption = Assumption::Sensors;

    fn assumptions(_: &mut Context<'_>, query: &GetIrSwitch) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).and_if(query.port.is_none(), Assumption::InfraredPort)
    }

    /// A sensor that is off sees nothing.
    fn report(cx: &mut Context<'_>, query: &GetIrSwitch) -> Self {
        let port = cx.io.infrared_sensors.asked(query.port);
        let seen = port.is_some_and(|port| cx.world.infrared(cx.now, port));
        Self {
            state: Flag::from(seen),
        }
    }
}

impl Apply for SetIrSwitch {
    const ASSUMPTION: Assumption = Assumption::Sensors;

    /// The version of the sensor has no effect here.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        if cx.io.infrared_sensors.enable(self.port, self.is_enabled) {
            Effects::none()
        } else {
            Effect::Refuse(Refusal::Pin).into()
        }
    }
}
