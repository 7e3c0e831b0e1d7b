//! Lost steps (document 1.18).

use magician_protocol::commands::*;

use crate::core::Core;
use crate::dispatch::{Apply, Step, Turn, not_simulated};

not_simulated!(LostStepCmd);

impl Apply for LostStepParams {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        core.settings.lost_step = *self;
        Step::Done
    }
}
