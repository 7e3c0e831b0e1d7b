//! Hand teaching (document 1.7). Nobody presses the unlock key yet, so there is never a new point.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::core::Core;
use crate::dispatch::{Report, stored};

stored!(HhtTrigMode in teach_mode, HhtTrigOutputEnabled in teach_enabled);

impl Report for HhtTrigOutput {
    fn report(_: &mut Core, _: &NoArgs) -> Self {
        Self {
            is_triggered: Flag::OFF,
        }
    }
}
