//! The world outside the arm, as the controller's connectors see it.

use magician_protocol::Port;

use crate::Micros;

/// What lies outside the arm: levels on its inputs, what its sensors see.
///
/// Every answer must follow from the arm's time and what the world was told, nothing else, so that a run repeats
/// itself bit for bit. Addresses are EIO addresses, 1 to 20 (model section 13).
pub trait World: Send {
    /// Level of a digital input.
    fn digital(&self, _now: Micros, _address: u8) -> bool {
        false
    }

    /// Value of an analog input, 0 to 4095 for 0 to 3.3 V.
    fn analog(&self, _now: Micros, _address: u8) -> u16 {
        0
    }

    /// Red, green and blue under the colour sensor of a connector.
    fn color(&self, _now: Micros, _port: Port) -> [u8; 3] {
        [0; 3]
    }

    /// Whether something is in front of the infrared sensor of a connector.
    fn infrared(&self, _now: Micros, _port: Port) -> bool {
        false
    }

    /// Whether there is something that the suction cup or the gripper holds on to.
    fn graspable(&self, _now: Micros) -> bool {
        false
    }
}

/// A world with nothing in it: every input is low, every sensor sees nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmptyWorld;

impl World for EmptyWorld {}
