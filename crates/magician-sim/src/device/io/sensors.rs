//! Which of the connectors' sensors are on (document 1.15.7 and 1.15.8).

use magician_protocol::{Flag, Port};

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
    pub(crate) fn enable(&mut self, port: Port, enabled: Flag) -> bool {
        let Some(place) = self.enabled.get_mut(usize::from(u8::from(port))) else {
            return false;
        };
        *place = enabled.is_on();
        self.last = port;
        true
    }

    /// The connector that a get asks for, if the sensor there is on.
    pub(crate) fn asked(&self, port: Option<Port>) -> Option<Port> {
        let port = port.unwrap_or(self.last);
        let enabled = self.enabled.get(usize::from(u8::from(port)));
        enabled.is_some_and(|enabled| *enabled).then_some(port)
    }
}
