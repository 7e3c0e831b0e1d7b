//! What all that moves the arm rests on, and the parameters that say how fast.

use magician_motion::Ceilings;

use crate::convert::to_wire;
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

/// Lowers speeds and accelerations of joints to their ceilings; true if any was above.
pub(super) fn cap_joints(
    velocity: &mut [f32; 4],
    acceleration: &mut [f32; 4],
    most: &Ceilings,
) -> bool {
    let velocity = cap(velocity.each_mut(), most.joint_velocity);
    cap(acceleration.each_mut(), [most.joint_acceleration; 4]) || velocity
}

/// Lowers values to their ceilings; true if any was above.
pub(super) fn cap<const N: usize>(values: [&mut f32; N], ceilings: [f64; N]) -> bool {
    let mut above = false;
    for (value, ceiling) in values.into_iter().zip(to_wire(ceilings)) {
        if *value > ceiling {
            (*value, above) = (ceiling, true);
        }
    }
    above
}

/// Whether a value is above its ceiling.
pub(super) fn beyond<const N: usize>(values: [f32; N], ceilings: [f64; N]) -> bool {
    let mut pairs = values.into_iter().zip(ceilings);
    pairs.any(|(value, ceiling)| f64::from(value) > ceiling)
}
