//! Enabled sensors at the connectors (document 1.15.7 and 1.15.8).

use magician_protocol::{Flag, Port};

/// Connectors at which a kind of sensor is enabled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnabledSensors {
    enabled: [bool; 4],
    /// Connector that a get without one refers to.
    last: Port,
}

impl Default for EnabledSensors {
    fn default() -> Self {
        Self {
            enabled: [false; 4],
            // GP1 at power-up: a choice (model section 15a).
            last: Port::Gp1,
        }
    }
}

impl EnabledSensors {
    /// Enables or disables the sensor at a connector. Returns false if there is no such connector.
    pub(crate) fn enable(&mut self, port: Port, enabled: Flag) -> bool {
        let Some(place) = self.enabled.get_mut(usize::from(u8::from(port))) else {
            return false;
        };
        *place = enabled.is_on();
        self.last = port;
        true
    }

    /// Connector that a get refers to; `None` if its sensor is off.
    pub(crate) fn asked(&self, port: Option<Port>) -> Option<Port> {
        let port = port.unwrap_or(self.last);
        let enabled = self.enabled.get(usize::from(u8::from(port)));
        enabled.is_some_and(|enabled| *enabled).then_some(port)
    }
}
