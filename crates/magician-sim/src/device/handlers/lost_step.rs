//! Lost steps (document 1.18, model section 12).

use magician_protocol::commands::*;
use magician_protocol::{Alarm, Writable};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::Apply;
use crate::fidelity::Assumption;

/// Rounding allowance, deg. The motor step is 0.01125 deg.
const ROUNDING: f64 = 1e-6;

impl Apply for LostStepParams {
    const ASSUMPTION: Assumption = Assumption::LostSteps;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // Takes effect with the next comparison; there is no continuous one (model section 12).
        cx.store.settings.lost_step = *self;
        Effects::none()
    }
}

impl Apply for LostStepCmd {
    const ASSUMPTION: Assumption = Assumption::LostSteps;

    /// Compares the base encoder and the sensors of J2 and J3 with the commanded joints.
    ///
    /// J4 has no sensor, so 0x53 is never raised. The alarms hold the queue, and homing is the
    /// remedy: cleared without it, they come back with the next comparison.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let threshold = f64::from(cx.store.settings.lost_step.value);
        let codes = [
            Alarm::LoseStepAxis1,
            Alarm::LoseStepAxis2,
            Alarm::LoseStepAxis3,
        ];
        let mut effects = Effects::none();
        for (code, lost) in codes.into_iter().zip(cx.motion.lost(cx.now)) {
            // Only J2 and J3 have absolute sensors; whether the arm compares J1 is a choice (model
            // section 12).
            let base = code == Alarm::LoseStepAxis1;
            if lost.abs() > threshold + ROUNDING
                && (!base || cx.record.allows(Self::ROW.id, Assumption::LostBase))
            {
                effects = effects.and(Effect::Raise(code));
            }
        }
        effects
    }
}
