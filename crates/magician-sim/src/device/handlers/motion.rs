//! Assumptions that all motions share.

use crate::device::context::Context;
use crate::device::effect::ExecMode;
use crate::device::queue::Activity;
use crate::fidelity::{Assumption, AssumptionSet};

impl Context<'_> {
    /// Assumptions of a motion other than homing and jogs, given the numbers of its target.
    pub(super) fn motion_assumptions(&self, target: &[f32], mode: ExecMode) -> AssumptionSet {
        let finite = target.iter().all(|number| number.is_finite());
        let set =
            AssumptionSet::from(Assumption::PlannedAtStart).and_if(!finite, Assumption::NotFinite);
        match mode {
            // A queued motion starts when nothing moves and no alarm holds the queue.
            ExecMode::Queued => set,
            ExecMode::Immediate => set
                .and_if(self.alarms.hold_queue(), Assumption::ImmediateWhileHeld)
                .union(self.replacing_assumptions()),
        }
    }

    /// Assumptions of any immediate motion, depending on what is under way.
    pub(super) fn replacing_assumptions(&self) -> AssumptionSet {
        let queue = self.queues.active();
        let moves = queue.busy() == Some(Activity::Moving);
        let waits = queue.is_started() && queue.waiting() > 0;
        // Only then does it matter what the queue does after the immediate motion.
        let goes_on = (moves || waits) && !self.alarms.hold_queue();
        AssumptionSet::default()
            .and_if(self.teaching.held(), Assumption::MotionWhileUnlocked)
            .and_if(self.motion.is_moving(), Assumption::ReplacedMotion)
            .and_if(goes_on, Assumption::QueueMeanwhile)
    }
}

/// True if a value is above its ceiling. NaN is not.
pub(super) fn beyond<const N: usize>(values: [f32; N], ceilings: [f64; N]) -> bool {
    let mut pairs = values.into_iter().zip(ceilings);
    pairs.any(|(value, ceiling)| f64::from(value) > ceiling)
}
