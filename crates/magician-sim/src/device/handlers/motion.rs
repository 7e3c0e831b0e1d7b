//! What all that moves the arm rests on, and the parameters that say how fast.

use magician_motion::Ceilings;

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

/// Whether speeds of joints are beyond what motions are planned with.
pub(super) fn joints_beyond(velocity: &[f32; 4], acceleration: &[f32; 4], most: &Ceilings) -> bool {
    beyond(*velocity, most.joint_velocity) || beyond(*acceleration, most.joint_acceleration)
}

/// Whether speeds of the tool are, each along a line and round.
pub(super) fn tool_beyond(velocity: [f32; 2], acceleration: [f32; 2], most: &Ceilings) -> bool {
    beyond(velocity, [most.linear_velocity, most.rotation_velocity])
        || beyond(
            acceleration,
            [most.linear_acceleration, most.rotation_acceleration],
        )
}

/// Whether a value is above its ceiling.
pub(super) fn beyond<const N: usize>(values: [f32; N], ceilings: [f64; N]) -> bool {
    let mut pairs = values.into_iter().zip(ceilings);
    pairs.any(|(value, ceiling)| f64::from(value) > ceiling)
}
