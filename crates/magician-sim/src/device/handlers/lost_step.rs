//! Lost steps (document 1.18, model section 12).

use magician_protocol::commands::*;
use magician_protocol::{Alarm, Writable};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::Apply;
use crate::fidelity::Assumption;

/// Differences below this are rounding, deg; the arm's step is 0.01125.
const ROUNDING: f64 = 1e-6;

impl Apply for LostStepParams {
    const RESTS_ON: Assumption = Assumption::LostSteps;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.lost_step = *self;
        Effects::none()
    }
}

impl Apply for LostStepCmd {
    const RESTS_ON: Assumption = Assumption::LostSteps;

    /// Compares the base encoder and the sensors of J2 and J3 with where the joints are commanded
    /// to be. J4 has no sensor, so 0x53 is never raised. The alarms hold the queue; homing is the
    /// remedy; if they are cleared without it, the next comparison raises them again.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let threshold = f64::from(cx.store.settings.lost_step.value);
        let codes = [
            Alarm::LoseStepAxis1,
            Alarm::LoseStepAxis2,
            Alarm::LoseStepAxis3,
        ];
        let mut effects = Effects::none();
        for (code, lost) in codes.into_iter().zip(cx.motion.lost(cx.now)) {
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
