//! Forward and inverse kinematics (model sections 2 and 3).
//!
//! Two parallelograms hold the wrist level and keep the forearm's angle independent of J2, so the
//! arm is a planar two-link mechanism turned by J1. The inverse is unique: the elbow is always up,
//! and J4 is r less J1. Limits are checked separately, because alarms distinguish "no solution"
//! from "beyond a limit".

use crate::angle::{DEGREES_PER_RADIAN, atan2, sin_cos};
use crate::{Geometry, Limits, MotionError, Unreachable};

/// The four joint angles in degrees, counted as the controller does (model section 1).
///
/// `j2` is measured from the vertical, positive leaning forward; `j3` is the angle of the forearm
/// below the horizontal, whatever `j2` does; `j4` is the servo on the wrist plate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(from = "[f64; 4]", into = "[f64; 4]")
)]
pub struct JointAngles {
    /// Base, counter-clockwise seen from above.
    pub j1: f64,
    /// Rear arm, from the vertical.
    pub j2: f64,
    /// Forearm, below the horizontal.
    pub j3: f64,
    /// End servo, relative to the wrist plate.
    pub j4: f64,
}

impl JointAngles {
    /// The home point, (0, 45, 45, 0): default pose after homing, and the pose reported at power-up
    /// (model sections 11 and 15a).
    pub const HOME: Self = Self::new(0.0, 45.0, 45.0, 0.0);

    /// Creates joint angles from four values in degrees.
    #[must_use]
    pub const fn new(j1: f64, j2: f64, j3: f64, j4: f64) -> Self {
        Self { j1, j2, j3, j4 }
    }

    /// The angles as an array, J1 first.
    #[must_use]
    pub const fn to_array(self) -> [f64; 4] {
        [self.j1, self.j2, self.j3, self.j4]
    }

    /// True if every angle is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|angle| angle.is_finite())
    }

    /// Returns these angles plus an increment for each joint.
    #[must_use]
    pub fn offset_by(&self, by: &Self) -> Self {
        Self::new(
            self.j1 + by.j1,
            self.j2 + by.j2,
            self.j3 + by.j3,
            self.j4 + by.j4,
        )
    }
}

impl From<JointAngles> for [f64; 4] {
    fn from(joints: JointAngles) -> Self {
        joints.to_array()
    }
}

impl From<[f64; 4]> for JointAngles {
    fn from([j1, j2, j3, j4]: [f64; 4]) -> Self {
        Self::new(j1, j2, j3, j4)
    }
}

/// Position of the tool in the base frame, mm, and its rotation `r` about the vertical, degrees.
///
/// The origin is where the base axis meets the shoulder axis; X forward, Y to the arm's left, Z up.
/// The table is not z = 0 (model section 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward, mm.
    pub x: f64,
    /// To the arm's left, mm.
    pub y: f64,
    /// Up, mm.
    pub z: f64,
    /// Rotation of the tool seen from above, counter-clockwise, degrees: J1 + J4.
    pub r: f64,
}

impl Pose {
    /// Creates a pose; mm and degrees.
    #[must_use]
    pub const fn new(x: f64, y: f64, z: f64, r: f64) -> Self {
        Self { x, y, z, r }
    }

    /// The pose as an array: x, y, z, r.
    #[must_use]
    pub const fn to_array(self) -> [f64; 4] {
        [self.x, self.y, self.z, self.r]
    }

    /// True if every component is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|value| value.is_finite())
    }

    /// Distance between two positions, mm.
    #[must_use]
    pub fn distance_to(&self, other: &Self) -> f64 {
        let (x, y, z) = (other.x - self.x, other.y - self.y, other.z - self.z);
        libm::sqrt(x * x + y * y + z * z)
    }

    /// Returns this pose plus an increment for each component.
    #[must_use]
    pub fn offset_by(&self, by: &Self) -> Self {
        Self::new(self.x + by.x, self.y + by.y, self.z + by.z, self.r + by.r)
    }
}

impl From<[f64; 4]> for Pose {
    fn from([x, y, z, r]: [f64; 4]) -> Self {
        Self::new(x, y, z, r)
    }
}

impl Geometry {
    /// Returns the pose of the tool at these joint angles. NaN or infinite angles yield a NaN or
    /// infinite pose.
    #[must_use]
    pub fn forward(&self, joints: &JointAngles) -> Pose {
        let (sin1, cos1) = sin_cos(joints.j1);
        let (sin2, cos2) = sin_cos(joints.j2);
        let (sin3, cos3) = sin_cos(joints.j3);
        let radius = self.rear_arm * sin2 + self.forearm * cos3 + self.tool.x;
        Pose {
            x: radius * cos1 - self.tool.y * sin1,
            y: radius * sin1 + self.tool.y * cos1,
            z: self.rear_arm * cos2 - self.forearm * sin3 - self.tool.z,
            r: joints.j1 + joints.j4,
        }
    }

    /// Returns the joint angles for this pose, elbow up. Joint limits are not considered.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] if the pose is too far, too near, NaN or infinite.
    pub fn inverse(&self, pose: &Pose) -> Result<JointAngles, MotionError> {
        if !pose.is_finite() {
            return Err(Unreachable::NotFinite.into());
        }
        self.solve(pose, NegativeRadicand::Refuse)
    }

    /// True if the tool can be at a position (x, y, z; mm) within these limits, at any rotation.
    #[must_use]
    pub fn reaches(&self, [x, y, z]: [f64; 3], limits: &Limits) -> bool {
        // Any r will do, so take the r with J4 near the middle of its range.
        let r = libm::atan2(y, x).to_degrees();
        self.inverse_within(&Pose::new(x, y, z, r), limits).is_ok()
    }

    /// Returns the joint angles for this pose if they are within `limits`.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] as in [`inverse`](Self::inverse); [`MotionError::Limit`] if the
    /// pose can be solved but lies beyond a limit.
    pub fn inverse_within(&self, pose: &Pose, limits: &Limits) -> Result<JointAngles, MotionError> {
        let joints = self.inverse(pose)?;
        limits.check(&joints)?;
        Ok(joints)
    }

    /// Like [`inverse`](Self::inverse), but moves a wrist that is out of reach by a rounding error
    /// to the edge of reach. For points of a path that is known to be in reach.
    pub(crate) fn inverse_at_edge(&self, pose: &Pose) -> Option<JointAngles> {
        self.solve(pose, NegativeRadicand::Clamp)
            .ok()
            .filter(JointAngles::is_finite)
    }

    fn solve(&self, pose: &Pose, outside: NegativeRadicand) -> Result<JointAngles, MotionError> {
        let across = self.tool.y;
        let radius_squared = pose.x * pose.x + pose.y * pose.y - across * across;
        let radius = outside.root(radius_squared).ok_or(Unreachable::TooNear {
            distance: libm::sqrt(pose.x * pose.x + pose.y * pose.y),
            limit: libm::fabs(across),
        })?;
        let heading = atan2(pose.y, pose.x);
        let j1 = if across == 0.0 {
            heading
        } else {
            heading - atan2(across, radius)
        };
        let (j2, j3) = self.solve_section(radius - self.tool.x, pose.z + self.tool.z, outside)?;
        Ok(JointAngles::new(j1, j2, j3, pose.r - j1))
    }

    /// Solves J2 and J3 for the wrist at `p` outwards and `q` up in the arm's vertical plane.
    ///
    /// Sine and cosine of the rear arm's elevation follow from the triangle directly. That saves
    /// three trigonometric calls and loses no precision.
    fn solve_section(
        &self,
        p: f64,
        q: f64,
        outside: NegativeRadicand,
    ) -> Result<(f64, f64), MotionError> {
        let (rear, fore) = (self.rear_arm, self.forearm);
        let distance_squared = p * p + q * q;
        let distance = libm::sqrt(distance_squared);
        let cos_inner = (rear * rear + distance_squared - fore * fore) / (2.0 * rear * distance);
        let sin_inner = outside
            .root(1.0 - cos_inner * cos_inner)
            .ok_or_else(|| self.out_of_reach(distance))?;
        // Rounding may exceed 1 by an ulp.
        let cos_inner = cos_inner.clamp(-1.0, 1.0);
        let sin_elevation = (q * cos_inner + p * sin_inner) / distance;
        let cos_elevation = (p * cos_inner - q * sin_inner) / distance;
        let mut elevation = atan2(sin_elevation, cos_elevation);
        if elevation < 0.0 && q >= 0.0 {
            // With the wrist above the shoulder the elevation may exceed 180 degrees, and `atan2`
            // wraps it.
            elevation += 360.0;
        }
        let j3 = atan2(rear * sin_elevation - q, p - rear * cos_elevation);
        Ok((90.0 - elevation, j3))
    }

    // If the wrist is closer to the shoulder than the length of the forearm, the only possible
    // cause is that the arm does not fold further.
    fn out_of_reach(&self, distance: f64) -> Unreachable {
        if distance < self.forearm {
            Unreachable::TooNear {
                distance,
                limit: libm::fabs(self.forearm - self.rear_arm),
            }
        } else {
            Unreachable::TooFar {
                distance,
                limit: self.forearm + self.rear_arm,
            }
        }
    }
}

/// Treatment of a negative radicand.
#[derive(Clone, Copy)]
enum NegativeRadicand {
    Refuse,
    Clamp,
}

impl NegativeRadicand {
    /// Square root of `square`. `None` for NaN, and for a negative number if this is `Refuse`; with
    /// `Clamp` a negative number gives 0.
    fn root(self, square: f64) -> Option<f64> {
        match self {
            _ if square >= 0.0 => Some(libm::sqrt(square)),
            Self::Clamp if square < 0.0 => Some(0.0),
            _ => None,
        }
    }
}

impl Geometry {
    /// Joint velocities (deg/s) for a given velocity of the tool (mm/s, r in deg/s) at these
    /// joints.
    ///
    /// The arm has no singularity within its limits (model section 5). At a singularity the result
    /// is not finite.
    pub(crate) fn joint_velocities(
        &self,
        joints: &JointAngles,
        pose: &Pose,
        rate: &Pose,
    ) -> [f64; 4] {
        let across = self.tool.y;
        let square = pose.x * pose.x + pose.y * pose.y;
        let radius = libm::sqrt(square - across * across);
        let outwards = (pose.x * rate.x + pose.y * rate.y) / radius;
        let turning = (pose.x * rate.y - pose.y * rate.x + across * outwards) / square;
        let (sin2, cos2) = sin_cos(joints.j2);
        let (sin3, cos3) = sin_cos(joints.j3);
        let cos_between = cos2 * cos3 + sin2 * sin3;
        let leaning = (cos3 * outwards - sin3 * rate.z) / (self.rear_arm * cos_between);
        let dropping = -(sin2 * outwards + cos2 * rate.z) / (self.forearm * cos_between);
        let j1 = turning * DEGREES_PER_RADIAN;
        [
            j1,
            leaning * DEGREES_PER_RADIAN,
            dropping * DEGREES_PER_RADIAN,
            rate.r - j1,
        ]
    }

    /// Velocity of the tool (mm/s, r in deg/s) for given joint velocities (deg/s) at these joints.
    pub(crate) fn tool_rate(&self, joints: &JointAngles, velocities: [f64; 4]) -> Pose {
        let [turning, leaning, dropping, _] = velocities.map(|v| v / DEGREES_PER_RADIAN);
        let (sin2, cos2) = sin_cos(joints.j2);
        let (sin3, cos3) = sin_cos(joints.j3);
        let (sin1, cos1) = sin_cos(joints.j1);
        let Pose { x, y, .. } = self.forward(joints);
        let outwards = self.rear_arm * cos2 * leaning - self.forearm * sin3 * dropping;
        let [j1, _, _, j4] = velocities;
        Pose {
            x: outwards * cos1 - y * turning,
            y: outwards * sin1 + x * turning,
            z: -self.rear_arm * sin2 * leaning - self.forearm * cos3 * dropping,
            r: j1 + j4,
        }
    }
}
