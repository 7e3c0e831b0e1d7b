//! Jogging (document 1.9, model section 10).

use magician_model::Capped;
use magician_protocol::JogCommand;
use magician_protocol::commands::*;

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::motion::beyond;
use crate::device::handlers::{Apply, stored};
use crate::fidelity::{Assumption, AssumptionSet};

stored! {
    // Stored up to the ceilings, as the vendor's code does (model section 6).
    JogJointParams in motion.jog_joint: Parameters,
        capped |set, ceilings| set.cap(ceilings);
    JogCoordinateParams in motion.jog_coordinate: Parameters,
        capped |set, ceilings| set.cap(ceilings);
    JogCommonParams in motion.jog_common: Parameters,
        beyond |set| beyond([set.velocity_ratio], [100.0]);
    JogLParams in motion.jog_rail: Parameters, at first RailDefaults;
}

impl Apply for JogCmd {
    const ASSUMPTION: Assumption = Assumption::Jog;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        let rail = matches!(self.cmd, JogCommand::RailPlus | JogCommand::RailMinus);
        let ignored = rail && !cx.has_rail();
        let set = AssumptionSet::from(Self::ASSUMPTION)
            .and_if(mode == ExecMode::Queued, Assumption::QueuedJog)
            .and_if(cx.alarms.hold_queue(), Assumption::JogWhileHeld)
            .and_if(ignored, Assumption::RailIgnored)
            .and_if(rail && !ignored, Assumption::RailRamps);
        match self.cmd {
            // The order of the arms matters: a stop and an unknown command do the same whatever the
            // arm does, and an ignored rail command does nothing.
            JogCommand::Stop => set,
            JogCommand::Unknown(_) => set.and(Assumption::UnknownJog),
            _ if ignored => set,
            _ if cx.motion.is_jogging() => {
                let other = cx.view().jogs_another(self.is_joint.is_on(), self.cmd);
                set.and_if(other, Assumption::JogAxisChange)
            }
            _ if mode == ExecMode::Immediate => set.union(cx.replacing_assumptions()),
            _ => set,
        }
    }

    /// Finished at once, in the queue too: the arm jogs on (model section 10).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::Jog(cx.view().jog(self.is_joint.is_on(), self.cmd)).into()
    }
}
