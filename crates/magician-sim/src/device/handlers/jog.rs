//! Jogging (document 1.9, model section 10).

use magician_protocol::commands::*;

use crate::device::Device;
use crate::device::dispatch::{Apply, Step, Turn, stored};

stored!(
    JogJointParams in jog_joint,
    JogCoordinateParams in jog_coordinate,
    JogCommonParams in jog_common,
    JogLParams in jog_rail,
);

impl Apply for JogCmd {
    /// In the queue too it has finished at once, and the arm goes on (model section 10).
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.jog(self.is_joint.is_on(), self.cmd)
    }
}
