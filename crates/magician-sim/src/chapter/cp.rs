//! Continuous path (document 1.11, model section 8).

use magician_protocol::Writable;
use magician_protocol::commands::*;

use crate::core::Core;
use crate::dispatch::{Apply, Step, Turn, stored};

stored!(
    CpParams in cp,
    CpCommonParams in cp_common,
    CpRHeadHoldEnable in cp_hold_rotation,
);

impl Apply for CpCmd {
    fn apply(&self, core: &mut Core, turn: Turn) -> Step {
        let Self {
            cp_mode, x, y, z, ..
        } = *self;
        core.begin_segment(Self::ROW.id, (cp_mode, [x, y, z]), 0.0, turn)
    }
}

impl Apply for CpLeCmd {
    fn apply(&self, core: &mut Core, turn: Turn) -> Step {
        let Self {
            cp_mode,
            x,
            y,
            z,
            velocity_or_power: power,
        } = *self;
        core.begin_segment(Self::ROW.id, (cp_mode, [x, y, z]), power, turn)
    }
}
