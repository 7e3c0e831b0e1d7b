//! Hand teaching (document 1.7, model section 12).
//!
//! While the unlock key on the forearm is held the motors are released, a hand may move the arm,
//! and the queue waits. The host polls for new points; the controller never sends one by itself.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::device::context::Context;
use crate::device::effect::{Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::fidelity::{Assumption, AssumptionSet};

impl Context<'_> {
    /// Accounts for a periodic point that has fallen due.
    pub(crate) fn look_for_point(&mut self) {
        if (self.teaching).look_for_point(self.now, &self.store.settings) {
            self.record.assume(Assumption::TeachPeriod);
        }
    }

    /// True if there is a point that was not read.
    pub(crate) fn has_new_point(&mut self) -> bool {
        self.look_for_point();
        self.teaching.has_point()
    }
}

impl Report for HhtTrigMode {
    const ASSUMPTION: Assumption = Assumption::TeachSettings;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.teach_mode
    }
}

impl Apply for HhtTrigMode {
    const ASSUMPTION: Assumption = Assumption::TeachSettings;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // Account under the old mode first.
        cx.look_for_point();
        cx.store.settings.teach_mode = *self;
        Effects::none()
    }
}

impl Report for HhtTrigOutputEnabled {
    const ASSUMPTION: Assumption = Assumption::TeachSettings;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.teach_enabled
    }
}

impl Apply for HhtTrigOutputEnabled {
    const ASSUMPTION: Assumption = Assumption::TeachSettings;

    /// Disabling also drops a point that was not read.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.look_for_point();
        cx.store.settings.teach_enabled = *self;
        if !self.is_enabled.is_on() {
            cx.teaching.take_point();
        }
        Effects::none()
    }
}

impl Report for HhtTrigOutput {
    const ASSUMPTION: Assumption = Assumption::TeachSettings;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        AssumptionSet::from(Self::ASSUMPTION).and_if(cx.has_new_point(), Assumption::PointCleared)
    }

    /// True once for each point: reading clears it (model section 12).
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.look_for_point();
        let new_point = cx.teaching.take_point();
        Self {
            is_triggered: Flag::from(new_point),
        }
    }
}
