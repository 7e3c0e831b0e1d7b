//! Jogging (document 1.9, model section 10).

use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, stored};

stored!(
    JogJointParams in jog_joint,
    JogCoordinateParams in jog_coordinate,
    JogCommonParams in jog_common,
    JogLParams in jog_rail,
);

impl Apply for JogCmd {
    /// In the queue too it has finished at once, and the arm goes on (model section 10).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::Jog(cx.view().jog(self.is_joint.is_on(), self.cmd)).into()
    }
}
