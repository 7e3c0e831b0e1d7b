//! Jogging (document 1.9).

use magician_protocol::commands::*;
use magician_protocol::{JogCommand, Writable};

use crate::core::Core;
use crate::dispatch::{Apply, Step, Turn, stored};

stored!(
    JogJointParams in jog_joint,
    JogCoordinateParams in jog_coordinate,
    JogCommonParams in jog_common,
    JogLParams in jog_rail,
);

impl Apply for JogCmd {
    fn apply(&self, core: &mut Core, _: Turn) -> Step {
        match self.cmd {
            JogCommand::Stop => core.rail_jog_stop(),
            JogCommand::RailPlus => core.rail_jog(Self::ROW, true),
            JogCommand::RailMinus => core.rail_jog(Self::ROW, false),
            _ => core.not_simulated(Self::ROW),
        }
    }
}
