//! Where the arm is: joints and pose of one instant.

use crate::{
    Bound, Geometry, JointAngles, LIMIT_TOLERANCE, Limits, MotionError, Pose, Unreachable,
};

/// J1 as a pose gives it goes half a turn either way, degrees.
const HALF_TURN: f64 = 180.0;
/// J2 - J3 at which the elbow is straight, degrees; a pose gives no joints beyond.
const STRAIGHT: f64 = 90.0;
/// Joints closer to each other than this are the same but for rounding, degrees.
const SAME: f64 = 1e-3;

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

    /// Whether the pose leads back to these joints, so that a path in space may begin or end here. Limits wider than
    /// the arm's, lost steps, or homing cut short while J1 knows nothing can leave it with the base more than half a
    /// turn round, the elbow past straight, or the wrist behind the base axis.
    ///
    /// # Errors
    ///
    /// [`MotionError::Limit`] for J1 or J2 - J3, or [`MotionError::Unreachable`], where it does not.
    pub(crate) fn check_invertible(&self, geometry: &Geometry) -> Result<(), MotionError> {
        let JointAngles { j1, j2, j3, .. } = self.joints;
        for (value, farthest, [below, above]) in [
            (j1, HALF_TURN, [Bound::J1Min, Bound::J1Max]),
            (j2 - j3, STRAIGHT, [Bound::J23Min, Bound::J23Max]),
        ] {
            if libm::fabs(value) > farthest + LIMIT_TOLERANCE {
                return Err(MotionError::Limit {
                    bound: if value > 0.0 { above } else { below },
                    value,
                    limit: libm::copysign(farthest, value),
                });
            }
        }
        let pose = self.pose;
        let solved = (geometry.inverse_at_edge(&pose)).ok_or(Unreachable::NotFinite)?;
        let (solved, joints) = (solved.to_array(), self.joints.to_array());
        let mut pairs = solved.iter().zip(joints);
        if pairs.all(|(solved, joint)| libm::fabs(solved - joint) < SAME) {
            return Ok(());
        }
        Err(Unreachable::TooNear {
            distance: libm::hypot(pose.x, pose.y),
            limit: libm::fabs(geometry.tool.y),
        }
        .into())
    }
}
