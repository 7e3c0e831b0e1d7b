//! Stepper outputs (document 1.15.6, errata E41).

use magician_protocol::commands::{EMotor, EMotorS};
use magician_protocol::{Flag, Stepper};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::Apply;
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

/// Index of an output; `None` if it does not exist.
fn output(index: Stepper) -> Option<usize> {
    match index {
        Stepper::Stepper1 => Some(0),
        Stepper::Stepper2 => Some(1),
        Stepper::Unknown(_) => None,
    }
}

/// Rate of a motor; a disabled one stands.
fn rate(enabled: Flag, pulses_per_second: f64) -> f64 {
    if enabled.is_on() {
        pulses_per_second
    } else {
        0.0
    }
}

impl Apply for EMotor {
    const ASSUMPTION: Assumption = Assumption::Steppers;

    /// Runs the motor until the next command. It has finished at once (model section 14).
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(output) = output(self.index) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        Effect::Turn {
            output,
            rate: rate(self.is_enabled, self.pulses_per_second()),
            pulses: None,
        }
        .into()
    }
}

impl Apply for EMotorS {
    const ASSUMPTION: Assumption = Assumption::Steppers;

    fn assumptions(&self, _: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).and(Assumption::StepperDistance)
    }

    /// Runs the motor for a number of pulses. In the queue it finishes with the motor, because
    /// hosts wait for its index before they take from the belt.
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        let Some(output) = output(self.index) else {
            return Effect::Refuse(Refusal::Pin).into();
        };
        Effect::Turn {
            output,
            rate: rate(self.is_enabled, self.pulses_per_second()),
            pulses: Some(self.distance),
        }
        .into()
    }
}
