//! Homing (document 1.6, model section 11).

use magician_protocol::NoArgs;
use magician_protocol::commands::*;

use crate::convert::to_wire;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report};
use crate::fidelity::{Assumption, AssumptionSet};

impl Report for HomeParams {
    const ASSUMPTION: Assumption = Assumption::HomeUnchecked;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        // Until a host sets a home point, the answer is the pose of the profile's home joints
        // (E44).
        match cx.store.settings.home {
            Some(_) => <Self as Report>::ASSUMPTION.into(),
            None => AssumptionSet::from(Assumption::HomeUnset)
                .and_if(cx.has_tool_of_power_up(), Assumption::PowerUpTool),
        }
    }

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.home.unwrap_or_else(|| {
            let joints = cx.firmware.model.homing.joints;
            let [x, y, z, r] = to_wire(cx.geometry().forward(&joints).to_array());
            Self { x, y, z, r }
        })
    }
}

impl Apply for HomeParams {
    const ASSUMPTION: Assumption = Assumption::HomeUnchecked;

    /// Stored unchecked: an unreachable point shows only when the arm homes (model section 11).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.home = Some(*self);
        Effects::none()
    }
}

impl Apply for HomeCmd {
    const ASSUMPTION: Assumption = Assumption::HomingSequence;

    fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
        let set = AssumptionSet::from(Self::ASSUMPTION)
            .and(Assumption::HomePoint)
            .and(Assumption::HomingFigures)
            .and_if(cx.has_rail(), Assumption::RailHome)
            .and_if(cx.alarms.hold_queue(), Assumption::HomeWhileHeld);
        match mode {
            // A queued homing starts when nothing moves, so it replaces nothing.
            ExecMode::Immediate => set.union(cx.replacing_assumptions()),
            ExecMode::Queued => set,
        }
    }

    fn apply(&self, _: &mut Context<'_>, _: ExecMode) -> Effects {
        Effect::Home.into()
    }
}

// Reports the accuracy last set: no source says in which unit the arm reports (E21).
impl Report for AutoLeveling {
    const ASSUMPTION: Assumption = Assumption::StoredWithoutEffect;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            result: cx.store.settings.auto_leveling.accuracy,
        }
    }
}

impl Apply for SetAutoLeveling {
    const ASSUMPTION: Assumption = Assumption::StoredWithoutEffect;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.auto_leveling = *self;
        Effect::NotSimulated.into()
    }
}
