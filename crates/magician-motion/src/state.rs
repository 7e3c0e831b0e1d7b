//! State of the arm at one instant: joints and pose.

use crate::{
    Bound, Geometry, JointAngles, LIMIT_TOLERANCE, Limits, MotionError, Pose, Unreachable,
};

/// A pose determines J1 only within half a turn either way, degrees.
const HALF_TURN: f64 = 180.0;
/// J2 - J3 at which the elbow is straight, degrees. A pose yields no joints beyond.
const STRAIGHT_ELBOW: f64 = 90.0;
/// Joints closer than this are equal but for rounding, degrees.
const JOINT_TOLERANCE: f64 = 1e-3;

/// Joints and pose at one instant, with one tool bias.
///
/// Both are stored, because a target is reached exactly as it was given: a pose to the last bit of
/// x, y, z and r, joint angles to their last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmState {
    /// Joint angles.
    pub joints: JointAngles,
    /// Pose of the tool.
    pub pose: Pose,
}

impl ArmState {
    /// Returns the state at these joint angles.
    #[must_use]
    pub fn at_joints(geometry: &Geometry, joints: &JointAngles) -> Self {
        Self {
            joints: *joints,
            pose: geometry.forward(joints),
        }
    }

    /// Returns the state with the tool at this pose.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] or [`MotionError::Limit`] if the pose is out of reach or beyond
    /// a limit.
    pub fn at_pose(geometry: &Geometry, pose: &Pose, limits: &Limits) -> Result<Self, MotionError> {
        Ok(Self {
            joints: geometry.inverse_within(pose, limits)?,
            pose: *pose,
        })
    }

    /// Checks that the inverse of the pose yields these joints, so that a path in space may begin
    /// or end here.
    ///
    /// Limits wider than the arm's, lost steps, or homing interrupted before J1 is referenced can
    /// leave the arm with the base more than half a turn round, the elbow past straight, or the
    /// wrist behind the base axis.
    ///
    /// # Errors
    ///
    /// [`MotionError::Limit`] for J1 or J2 - J3, or [`MotionError::Unreachable`], if it does not.
    pub(crate) fn check_invertible(&self, geometry: &Geometry) -> Result<(), MotionError> {
        let JointAngles { j1, j2, j3, .. } = self.joints;
        for (value, farthest, [below, above]) in [
            (j1, HALF_TURN, [Bound::J1Min, Bound::J1Max]),
            (j2 - j3, STRAIGHT_ELBOW, [Bound::J23Min, Bound::J23Max]),
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
        if pairs.all(|(solved, joint)| libm::fabs(solved - joint) < JOINT_TOLERANCE) {
            return Ok(());
        }
        Err(Unreachable::TooNear {
            distance: libm::hypot(pose.x, pose.y),
            limit: libm::fabs(geometry.tool.y),
        }
        .into())
    }
}
