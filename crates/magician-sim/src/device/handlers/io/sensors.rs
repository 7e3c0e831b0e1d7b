//! The colour sensor and the infrared sensor (document 1.15.7 and 1.15.8, errata E42 and E43).

use magician_protocol::commands::*;
use magician_protocol::{Flag, Port, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};
use crate::event::Refusal;

/// Which connectors a kind of sensor was enabled at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detectors {
    enabled: [bool; 4],
    /// What a get without a connector asks for.
    last: Port,
}

impl Default for Detectors {
    fn default() -> Self {
        Self {
            enabled: [false; 4],
            last: Port::Gp1,
        }
    }
}

impl Detectors {
    /// Whether there is such a connector.
    fn enable(&mut self, port: Port, enabled: Flag) -> bool {
        let Some(place) = self.enabled.get_mut(usize::from(u8::from(port))) else {
            return false;
        };
        *place = enabled.is_on();
        self.last = port;
        true
    }

    /// The connector that a get asks for, if the sensor there is on.
    fn asked(&self, port: Option<Port>) -> Option<Port> {
        let port = port.unwrap_or(self.last);
        let enabled = self.enabled.get(usize::from(u8::from(port)));
        enabled.is_some_and(|enabled| *enabled).then_some(port)
    }
}

impl Report for ColorSensor {
    /// A sensor that is off sees nothing.
    fn report(core: &mut Device, query: &GetColorSensor) -> Self {
        let port = core.color_sensors.asked(query.port);
        let [r, g, b] = port.map_or([0; 3], |port| core.world.color(core.now, port));
        Self { r, g, b }
    }
}

impl Apply for SetColorSensor {
    /// The sensor's version changes nothing here.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        if core.color_sensors.enable(self.port, self.is_enabled) {
            Step::Done
        } else {
            core.refuse(Self::ROW.id, Refusal::Pin)
        }
    }
}

impl Report for IrSwitch {
    /// A sensor that is off sees nothing.
    fn report(core: &mut Device, query: &GetIrSwitch) -> Self {
        let port = core.infrared_sensors.asked(query.port);
        let seen = port.is_some_and(|port| core.world.infrared(core.now, port));
        Self {
            state: Flag::from(seen),
        }
    }
}

impl Apply for SetIrSwitch {
    /// The sensor's version changes nothing here.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        if core.infrared_sensors.enable(self.port, self.is_enabled) {
            Step::Done
        } else {
            core.refuse(Self::ROW.id, Refusal::Pin)
        }
    }
}
