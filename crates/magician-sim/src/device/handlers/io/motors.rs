//! The stepper outputs (document 1.15.6, errata E41).

use magician_protocol::commands::{EMotor, EMotorS};
use magician_protocol::{Flag, Stepper, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Step, Turn};
use crate::event::Refusal;

/// The place of an output among its kind.
fn output(index: Stepper) -> Option<usize> {
    match index {
        Stepper::Stepper1 => Some(0),
        Stepper::Stepper2 => Some(1),
        Stepper::Unknown(_) => None,
    }
}

/// A motor that is not enabled stands.
fn rate(enabled: Flag, pulses_per_second: f64) -> f64 {
    if enabled.is_on() {
        pulses_per_second
    } else {
        0.0
    }
}

impl Apply for EMotor {
    /// The motor runs on until it is told otherwise: the command has finished at once (model section 14).
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let Some(output) = output(self.index) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        core.turn(
            output,
            rate(self.is_enabled, self.pulses_per_second()),
            None,
        )
    }
}

impl Apply for EMotorS {
    /// In the queue it has finished when the motor has: hosts wait for its index and then take from the belt.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        let Some(output) = output(self.index) else {
            return core.refuse(Self::ROW.id, Refusal::Pin);
        };
        let rate = rate(self.is_enabled, self.pulses_per_second());
        core.turn(output, rate, Some(self.distance))
    }
}
