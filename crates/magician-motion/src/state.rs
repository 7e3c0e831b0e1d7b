//! Where the arm is: joints and pose of one instant.

use crate::{Geometry, JointAngles, Limits, MotionError, Pose};

/// Joints and pose of one instant, under one tool bias.
///
/// Both are kept, because the target of a motion is reached exactly as it was given: a pose to the last bit of x, y,
/// z and r, joint angles to the last bit of theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmState {
    /// The joint angles.
    pub joints: JointAngles,
    /// The pose of the tool.
    pub pose: Pose,
}

impl ArmState {
    /// The arm at these joint angles.
    #[must_use]
    pub fn at_joints(geometry: &Geometry, joints: &JointAngles) -> Self {
        Self {
            joints: *joints,
            pose: geometry.forward(joints),
        }
    }

    /// The arm with its tool at this pose.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] or [`MotionError::Limit`] if it cannot be there.
    pub fn at_pose(geometry: &Geometry, pose: &Pose, limits: &Limits) -> Result<Self, MotionError> {
        Ok(Self {
            joints: geometry.inverse_within(pose, limits)?,
            pose: *pose,
        })
    }
}
