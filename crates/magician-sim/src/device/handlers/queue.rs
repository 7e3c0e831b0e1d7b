//! The command queue (document 1.19, model section 14).

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};
use crate::event::Refusal;
use crate::fidelity::Assumption;

impl Apply for QueuedCmdStartDownload {
    /// What was said of the length binds nobody. While the program runs there is nothing to store it in (model
    /// section 12).
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        if core.start_download(self.total_loop, self.line_per_loop) {
            Step::Done
        } else {
            core.assume(Assumption::OfflineBusy);
            core.refuse(Self::ROW.id, Refusal::Busy)
        }
    }
}

impl Apply for QueuedCmdStopDownload {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        if core.is_mismatched() && !core.allows(Self::ROW.id, Assumption::OfflineMismatch) {
            core.download = None;
        }
        core.stop_download();
        Step::Done
    }
}

impl Apply for QueuedCmdStartExec {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.hosts_mut().started = true;
        core.replan_segment();
        Step::Done
    }
}

impl Apply for QueuedCmdStopExec {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.stop();
        Step::Done
    }
}

impl Apply for QueuedCmdForceStopExec {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.force_stop();
        Step::Done
    }
}

impl Apply for QueuedCmdClear {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.clear_queue();
        Step::Done
    }
}

impl Report for QueuedCmdCurrentIndex {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        Self {
            queued_cmd_current_index: core.hosts().current,
        }
    }
}

impl Report for QueuedCmdLeftSpace {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        let left_space = u32::try_from(core.hosts().left()).unwrap_or(u32::MAX);
        Self { left_space }
    }
}

impl Report for QueuedCmdMotionFinish {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        Self {
            is_finish: Flag::from(!core.motion.is_moving()),
        }
    }
}
