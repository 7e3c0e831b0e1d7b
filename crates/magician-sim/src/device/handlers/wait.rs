//! WAIT: waiting for a time (document 1.13).

use magician_protocol::commands::WaitCmd;

use crate::Micros;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::Apply;
use crate::fidelity::{Assumption, AssumptionSet};

impl Apply for WaitCmd {
    const ASSUMPTION: Assumption = Assumption::Wait;

    fn assumptions(&self, _: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        let at_once = mode == ExecMode::Immediate;
        AssumptionSet::from(Self::ASSUMPTION).and_if(at_once, Assumption::ImmediateWait)
    }

    /// In the queue it counts from its start. An immediate one has nothing to block (errata E34).
    fn apply(&self, cx: &mut Context<'_>, mode: ExecMode) -> Effects {
        match mode {
            ExecMode::Immediate => Effects::none(),
            ExecMode::Queued => {
                // The protocol counts milliseconds (E34).
                let span = Micros::from(self.timeout).saturating_mul(1000);
                Effect::WaitUntil(cx.now.after_micros(span)).into()
            }
        }
    }
}
