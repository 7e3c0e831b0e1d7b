//! The command queue (document 1.19, model section 14).

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs, Writable};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::device::queue::Activity;
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

impl Apply for QueuedCmdStartDownload {
    const ASSUMPTION: Assumption = Assumption::OfflineProgram;

    /// Starts a download. The announced length is not binding.
    ///
    /// While a program runs the command does nothing, as in the vendor's code (model section 12).
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
    const ASSUMPTION: Assumption = Assumption::OfflineProgram;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // Another number of commands than announced is kept: the document does not define it (model
        // section 12).
        let keep = !cx.queues.is_mismatched()
            || cx.record.allows(Self::ROW.id, Assumption::OfflineMismatch);
        Effect::StopDownload { keep }.into()
    }
}

impl Apply for QueuedCmdStartExec {
    const ASSUMPTION: Assumption = Assumption::Start;

    fn assumptions(&self, cx: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION)
            .and_if(!cx.hosts().is_started(), Assumption::QueueStopped)
            .and_if(cx.motion.can_be_dropped(), Assumption::StartAgain)
    }

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::StartQueue.into()
    }
}

/// Assumptions of a stop, forced or not.
fn stop_assumptions(cx: &Context<'_>) -> AssumptionSet {
    let busy = cx.queues.active().busy();
    let waits = busy.is_some_and(|busy| busy != Activity::Moving);
    AssumptionSet::default()
        .and_if(waits, Assumption::StopCutsWait)
        .and_if(cx.motion.follows_path(), Assumption::CpStops)
}

impl Apply for QueuedCmdStopExec {
    const ASSUMPTION: Assumption = Assumption::StopFinishes;

    fn assumptions(&self, cx: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).union(stop_assumptions(cx))
    }

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::StopQueue.into()
    }
}

impl Apply for QueuedCmdForceStopExec {
    const ASSUMPTION: Assumption = Assumption::ForceStop;

    fn assumptions(&self, cx: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION)
            .and(Assumption::ForceStopStops)
            .union(stop_assumptions(cx))
    }

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ForceStop.into()
    }
}

impl Apply for QueuedCmdClear {
    const ASSUMPTION: Assumption = Assumption::Clear;

    fn assumptions(&self, cx: &Context<'_>, _: ExecMode) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION)
            .and(Assumption::IndexAfterClear)
            .and_if(cx.motion.can_be_dropped(), Assumption::ClearWhileMoving)
    }

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::ClearQueue.into()
    }
}

impl Report for QueuedCmdCurrentIndex {
    const ASSUMPTION: Assumption = Assumption::CurrentIndex;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        // 0 is not an index, so it only means that nothing has finished.
        let unused = cx.hosts().current() == 0 && cx.hosts().running().is_none();
        AssumptionSet::from(Self::ASSUMPTION).and_if(unused, Assumption::CurrentAtFirst)
    }

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            // The last finished index, also while the next one runs (E37); hosts wait for it (hosts
            // 6).
            queued_cmd_current_index: cx.hosts().current(),
        }
    }
}

impl Report for QueuedCmdLeftSpace {
    const ASSUMPTION: Assumption = Assumption::QueueDepth;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        let runs = cx.hosts().running().is_some();
        AssumptionSet::from(Self::ASSUMPTION).and_if(runs, Assumption::RunningPlace)
    }

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        // Four bytes: the answer of the Magician, unlike the M1's eight (E38).
        let left_space = u32::try_from(cx.hosts().left()).unwrap_or(u32::MAX);
        Self { left_space }
    }
}

impl Report for QueuedCmdMotionFinish {
    const ASSUMPTION: Assumption = Assumption::MotionFinish;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            is_finish: Flag::from(!cx.motion.is_moving()),
        }
    }
}
