//! The command queue (document 1.19, model section 14).

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::core::Core;
use crate::dispatch::{Apply, Report, Step, Turn, not_simulated};

not_simulated!(QueuedCmdStartDownload, QueuedCmdStopDownload);

impl Apply for QueuedCmdStartExec {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.queue.started = true;
        core.replan_segment();
        Step::Done
    }
}

impl Apply for QueuedCmdStopExec {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.stop();
        Step::Done
    }
}

impl Apply for QueuedCmdForceStopExec {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.force_stop();
        Step::Done
    }
}

impl Apply for QueuedCmdClear {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.clear_queue();
        Step::Done
    }
}

impl Report for QueuedCmdCurrentIndex {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        Self {
            queued_cmd_current_index: core.queue.current,
        }
    }
}

impl Report for QueuedCmdLeftSpace {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        let left_space = u32::try_from(core.queue.left()).unwrap_or(u32::MAX);
        Self { left_space }
    }
}

impl Report for QueuedCmdMotionFinish {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        Self {
            is_finish: Flag::from(!core.motion.is_moving()),
        }
    }
}
