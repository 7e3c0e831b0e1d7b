//! State of the stepper outputs, and of the conveyor that one of them drives.

use magician_protocol::commands::{EMotor, EMotorS};
use magician_protocol::{Ctrl, Frame, Set, Stepper, Writable};

/// Motor outputs of an arm. A stop switches both off, whoever started them.
pub const OUTPUTS: [Stepper; 2] = [Stepper::Stepper1, Stepper::Stepper2];

/// State of an output as this connection set it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Motor {
    /// Off.
    #[default]
    Off,
    /// Runs until switched off.
    Runs,
    /// Counts its pulses and then stands still; the arm does not report when.
    Counts,
    /// Stands still once the queue has run to its end.
    EndsInQueue,
}

/// State of both outputs as this connection set them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Motors([Motor; 2]);

impl Motors {
    /// Processes a sent frame: from now on a motor may run, with or without a reply.
    pub fn sent(&mut self, frame: &Frame<'_>) {
        let Some((output, motor)) = self.turned(frame) else {
            return;
        };
        let before = self.0[output];
        self.0[output] = match motor {
            // The output counts as off only once the arm has replied.
            Motor::Off => before,
            // A queued "off" leaves an output that is off unchanged.
            Motor::EndsInQueue if before == Motor::Off && !turns(frame) => before,
            motor => motor,
        };
    }

    /// Processes an answered frame.
    pub fn answered(&mut self, frame: &Frame<'_>) {
        if let Some((output, Motor::Off)) = self.turned(frame) {
            self.0[output] = Motor::Off;
        }
    }

    /// Outputs that run because of this connection, and continue until they are switched off.
    #[must_use = "they run until they are switched off"]
    pub fn running(&self) -> impl Iterator<Item = Stepper> + '_ {
        self.which(|motor| motor == Motor::Runs)
    }

    /// Outputs to switch off when the holder goes away. `moving` is true if the arm has not
    /// finished everything.
    #[must_use = "they run until they are switched off"]
    pub fn held(&self, moving: bool) -> impl Iterator<Item = Stepper> + '_ {
        self.which(move |motor| match motor {
            Motor::Off => false,
            Motor::Runs | Motor::Counts => true,
            Motor::EndsInQueue => moving,
        })
    }

    fn which(&self, wanted: impl Fn(Motor) -> bool) -> impl Iterator<Item = Stepper> {
        let found = OUTPUTS.into_iter().zip(self.0);
        found.filter_map(move |(output, motor)| wanted(motor).then_some(output))
    }

    /// Output of a frame and its resulting state. `None` for frames of other commands.
    fn turned(&self, frame: &Frame<'_>) -> Option<(usize, Motor)> {
        let (ctrl, id) = (frame.ctrl(), frame.id());
        if !(ctrl.write() || ctrl.queued()) || ![EMotor::ROW.id, EMotorS::ROW.id].contains(&id) {
            return None;
        }
        let command = Set::decode(id, frame.params()).ok()?;
        let (index, counts) = match &command {
            Set::EMotor(motor) => (motor.index, false),
            Set::EMotorS(motor) => (motor.index, true),
            _ => return None,
        };
        let output = OUTPUTS.iter().position(|output| *output == index)?;
        let motor = match (turns_motor(&command), counts, ctrl.queued()) {
            (true, false, _) => Motor::Runs,
            (true, true, false) => Motor::Counts,
            // The arm does not report when a queued command runs, not even an "off".
            (true, true, true) | (false, _, true) => Motor::EndsInQueue,
            (false, _, false) => Motor::Off,
        };
        Some((output, motor))
    }
}

/// True for a command that starts a motor output.
#[must_use]
pub fn turns_motor(command: &Set) -> bool {
    match command {
        Set::EMotor(motor) => motor.is_enabled.is_on() && motor.speed != 0,
        Set::EMotorS(motor) => motor.is_enabled.is_on() && motor.speed != 0 && motor.distance != 0,
        _ => false,
    }
}

fn turns(frame: &Frame<'_>) -> bool {
    Set::decode(frame.id(), frame.params()).is_ok_and(|command| turns_motor(&command))
}

/// True for a frame that switches a motor output off immediately, which is idempotent.
pub(crate) fn switches_off(frame: &Frame<'_>) -> bool {
    frame.ctrl() == Ctrl::SET
        && frame.id() == EMotor::ROW.id
        && Set::decode(frame.id(), frame.params()).is_ok_and(|command| !turns_motor(&command))
}
