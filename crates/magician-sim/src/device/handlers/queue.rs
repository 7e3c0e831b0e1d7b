//! The command queue (document 1.19, model section 14).

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs, Writable};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::event::Refusal;
use crate::fidelity::Assumption;

impl Apply for QueuedCmdStartDownload {
    /// What was said of the length binds nobody. While the program runs there is nothing to store it in (model
    /// section 12).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        if cx.queues.program_is_off() {
            Effect::StartDownload {
                loops: self.total_loop,
                announced: self.line_per_loop,
            }
            .into()
        } else {
            cx.record.assume(Assumption::OfflineBusy);
            Effect::Refuse(Refusal::Busy).into()
        }
    }
}

impl Apply for QueuedCmdStopDownload {
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let keep = !cx.queues.is_mismatched()
            || cx.record.allows(Self::ROW.id, Assumption::OfflineMismatch);
        Effect::StopDownload { keep }.into()
    }
}

impl Apply for QueuedCmdStartExec {
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::StartQueue.into()
    }
}

impl Apply for QueuedCmdStopExec {
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::StopQueue.into()
    }
}

impl Apply for QueuedCmdForceStopExec {
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ForceStop.into()
    }
}

impl Apply for QueuedCmdClear {
    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ClearQueue.into()
    }
}

impl Report for QueuedCmdCurrentIndex {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            queued_cmd_current_index: cx.hosts().current(),
        }
    }
}

impl Report for QueuedCmdLeftSpace {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let left_space = u32::try_from(cx.hosts().left()).unwrap_or(u32::MAX);
        Self { left_space }
    }
}

impl Report for QueuedCmdMotionFinish {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            is_finish: Flag::from(!cx.motion.is_moving()),
        }
    }
}
