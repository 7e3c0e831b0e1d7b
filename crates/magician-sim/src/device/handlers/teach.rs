//! Hand teaching (document 1.7, model section 12).
//!
//! While the unlock key on the forearm is held the motors are released and a hand may move the arm;
//! the queue waits. What the controller then reports as a new point is asked for and not sent, so
//! it is worked out when it is asked for.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::device::context::Context;
use crate::device::effect::{Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::fidelity::{Assumption, AssumptionSet};

impl Context<'_> {
    /// Finds out whether a point has become due by now.
    pub(crate) fn look_for_point(&mut self) {
        if (self.teaching).look_for_point(self.now, &self.store.settings) {
            self.record.assume(Assumption::TeachPeriod);
        }
    }

    /// Whether a point waits that was not read yet.
    pub(crate) fn has_new_point(&mut self) -> bool {
        self.look_for_point();
        self.teaching.has_point()
    }
}

impl Report for HhtTrigMode {
    const RESTS_ON: Assumption = Assumption::TeachSettings;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.teach_mode
    }
}

impl Apply for HhtTrigMode {
    const RESTS_ON: Assumption = Assumption::TeachSettings;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.look_for_point();
        cx.store.settings.teach_mode = *self;
        Effects::none()
    }
}

impl Report for HhtTrigOutputEnabled {
    const RESTS_ON: Assumption = Assumption::TeachSettings;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.teach_enabled
    }
}

impl Apply for HhtTrigOutputEnabled {
    const RESTS_ON: Assumption = Assumption::TeachSettings;

    /// Disabled, it forgets a point that was not read yet.
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
    const RESTS_ON: Assumption = Assumption::TeachSettings;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        AssumptionSet::from(Self::RESTS_ON).and_if(cx.has_new_point(), Assumption::PointCleared)
    }

    /// Once for each point: reading it clears it.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.look_for_point();
        let new_point = cx.teaching.take_point();
        Self {
            is_triggered: Flag::from(new_point),
        }
    }
}
