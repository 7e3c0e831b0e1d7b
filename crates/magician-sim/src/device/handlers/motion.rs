//! What all that moves the arm rests on, and the parameters that say how fast.

use crate::device::context::Context;
use crate::device::effect::ExecMode;
use crate::device::queue::Busy;
use crate::fidelity::{Assumption, AssumptionSet};

impl Context<'_> {
    /// What a motion rests on that is not homing or a jog, with the numbers of its target.
    pub(super) fn motion_assumptions(&self, target: &[f32], mode: ExecMode) -> AssumptionSet {
        let finite = target.iter().all(|number| number.is_finite());
        let set =
            AssumptionSet::from(Assumption::PlannedAtStart).and_if(!finite, Assumption::NotFinite);
        match mode {
            ExecMode::Queued => set,
            ExecMode::Immediate => set
                .and_if(self.alarms.hold_queue(), Assumption::ImmediateWhileHeld)
                .union(self.replacing_assumptions()),
        }
    }

    /// What anything rests on that moves the arm at once, whatever else is going on.
    pub(super) fn replacing_assumptions(&self) -> AssumptionSet {
        let queue = self.queues.active();
        let moves = queue.busy() == Some(Busy::Moving);
        let waits = queue.is_started() && queue.waiting() > 0;
        let goes_on = (moves || waits) && !self.alarms.hold_queue();
        AssumptionSet::default()
            .and_if(self.teaching.held(), Assumption::MotionWhileUnlocked)
            .and_if(self.motion.is_moving(), Assumption::ReplacedMotion)
            .and_if(goes_on, Assumption::QueueMeanwhile)
    }
}

/// Whether a value is above its ceiling.
pub(super) fn beyond<const N: usize>(values: [f32; N], ceilings: [f64; N]) -> bool {
    let mut pairs = values.into_iter().zip(ceilings);
    pairs.any(|(value, ceiling)| f64::from(value) > ceiling)
}
