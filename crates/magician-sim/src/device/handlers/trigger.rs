//! TRIG: waiting for an input (document 1.14).

use magician_protocol::Writable;
use magician_protocol::commands::TrigCmd;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::Apply;
use crate::device::io::trigger::Trigger;
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

impl Apply for TrigCmd {
    const ASSUMPTION: Assumption = Assumption::Trigger;

    fn assumptions(&self, _: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        let at_once = mode == ExecMode::Immediate;
        AssumptionSet::from(Self::ASSUMPTION).and_if(at_once, Assumption::ImmediateWait)
    }

    /// Blocks the queue until the condition is met; there is no timeout (model section 14).
    ///
    /// An immediate one has nothing to block (E34). An undefined condition would block forever and
    /// is refused.
    fn apply(&self, cx: &mut Context<'_>, mode: ExecMode) -> Effects {
        let Some(trigger) = Trigger::new(self) else {
            return if cx
                .record
                .allows(Self::ROW.id, Assumption::MeaninglessTrigger)
            {
                Effect::Refuse(Refusal::Trigger).into()
            } else {
                Effects::none()
            };
        };
        // A condition that holds already must not wait for the next change of the input.
        if mode == ExecMode::Immediate || trigger.is_met(&cx.io.pins, cx.world, cx.now) {
            Effects::none()
        } else {
            Effect::WaitFor(trigger).into()
        }
    }
}
