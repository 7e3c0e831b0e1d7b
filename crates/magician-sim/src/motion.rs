//! Where the arm is and how it moves.

use magician_motion::{JointAngles, Pose};

use crate::Micros;
use crate::core::Core;

/// The commanded position of the arm.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    joints: JointAngles,
}

impl Motion {
    pub(crate) fn at(joints: JointAngles) -> Self {
        Self { joints }
    }

    pub(crate) fn is_moving(&self) -> bool {
        false
    }

    pub(crate) fn next_event(&self) -> Option<Micros> {
        None
    }
}

impl Core {
    pub(crate) fn motion_event(&mut self) {}

    pub(crate) fn joints(&self) -> JointAngles {
        self.motion.joints
    }

    pub(crate) fn pose(&self) -> Pose {
        self.geometry().forward(&self.joints())
    }
}

impl Core {
    /// Puts the arm's commanded joints there without a motion.
    pub(crate) fn place_at(&mut self, joints: JointAngles) {
        self.motion.joints = joints;
    }

    pub(crate) fn brake(&mut self) {}
}
