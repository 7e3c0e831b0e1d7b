//! Reasons why a motion cannot be planned. They concern the request, never the state of the
//! machine.

use core::fmt;

use crate::Bound;

/// Reason why no joint angles lead to a pose. Distances in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Unreachable {
    /// The wrist would be further from the shoulder than both links together reach.
    TooFar {
        /// Distance of the requested pose.
        distance: f64,
        /// Longest possible distance.
        limit: f64,
    },
    /// The pose is closer to the shoulder or to the base axis than the arm can fold.
    TooNear {
        /// Distance of the requested pose.
        distance: f64,
        /// Shortest possible distance.
        limit: f64,
    },
    /// A component of the target, or a jump height, is NaN or infinite.
    NotFinite,
}

/// Quantity of an invalid speed setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedQuantity {
    /// Velocity of a joint (1 to 4), deg/s.
    JointVelocity(u8),
    /// Acceleration of a joint (1 to 4), deg/s2.
    JointAcceleration(u8),
    /// Velocity along the path, mm/s.
    LinearVelocity,
    /// Acceleration along the path, mm/s2.
    LinearAcceleration,
    /// Velocity of r, deg/s.
    RotationVelocity,
    /// Acceleration of r, deg/s2.
    RotationAcceleration,
    /// Velocity ratio, percent.
    VelocityRatio,
    /// Acceleration ratio, percent.
    AccelerationRatio,
    /// Period of a continuous path, seconds.
    Period,
}

impl fmt::Display for SpeedQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::JointVelocity(joint) => write!(f, "velocity of joint {joint}"),
            Self::JointAcceleration(joint) => write!(f, "acceleration of joint {joint}"),
            Self::LinearVelocity => f.write_str("linear velocity"),
            Self::LinearAcceleration => f.write_str("linear acceleration"),
            Self::RotationVelocity => f.write_str("velocity of r"),
            Self::RotationAcceleration => f.write_str("acceleration of r"),
            Self::VelocityRatio => f.write_str("velocity ratio"),
            Self::AccelerationRatio => f.write_str("acceleration ratio"),
            Self::Period => f.write_str("period"),
        }
    }
}

impl SpeedQuantity {
    fn unit(self) -> &'static str {
        match self {
            Self::JointVelocity(_) | Self::RotationVelocity => "deg/s",
            Self::JointAcceleration(_) | Self::RotationAcceleration => "deg/s2",
            Self::LinearVelocity => "mm/s",
            Self::LinearAcceleration => "mm/s2",
            Self::VelocityRatio | Self::AccelerationRatio => "%",
            Self::Period => "s",
        }
    }
}

/// Error of a motion that cannot be planned as requested.
///
/// The kinds match the controller's alarms: no solution (0x11 while planning, 0x21 while moving),
/// solved but beyond a limit (0x12, 0x22, or 0x40 to 0x49 for a motion of joints), an invalid speed
/// (0x1A), and three points that make no circle (0x13, 0x14).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MotionError {
    /// No joint angles lead to the pose.
    Unreachable(Unreachable),
    /// Joint angles lead to the pose, but beyond a limit.
    Limit {
        /// The bound violated.
        bound: Bound,
        /// Angle that the motion would need, degrees.
        value: f64,
        /// Angle of the bound, degrees.
        limit: f64,
    },
    /// A velocity, acceleration, ratio or period is NaN, zero, negative, or too small for the
    /// motion to end.
    Speed {
        /// The invalid quantity.
        quantity: SpeedQuantity,
        /// Value of the quantity: mm/s, mm/s2, deg/s, deg/s2, percent or seconds.
        value: f64,
    },
    /// Two of an arc's three points are less than 0.0001 mm apart (alarm 0x13).
    Coincident,
    /// An arc's three points are on a straight line, to 0.0001 mm (alarm 0x14).
    Collinear,
}

impl From<Unreachable> for MotionError {
    fn from(reason: Unreachable) -> Self {
        Self::Unreachable(reason)
    }
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFar { distance, limit } => write!(
                f,
                "out of reach: {distance:.1} mm from the shoulder, limit {limit:.1} mm"
            ),
            Self::TooNear { distance, limit } => write!(
                f,
                "too close to the arm: {distance:.1} mm, limit {limit:.1} mm"
            ),
            Self::NotFinite => f.write_str("out of reach: the target is not a finite number"),
        }
    }
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreachable(reason) => reason.fmt(f),
            Self::Limit {
                bound,
                value,
                limit,
            } => {
                let subject = bound.subject();
                write!(
                    f,
                    "{subject} would be at {value:.1} deg, limit {limit:.1} deg"
                )
            }
            Self::Speed { quantity, value } => {
                let unit = quantity.unit();
                write!(f, "{quantity} is {value} {unit}, it must be above 0 {unit}")
            }
            Self::Coincident => f.write_str("two of the three points of the arc are the same"),
            Self::Collinear => f.write_str("the three points of the arc are on a straight line"),
        }
    }
}

impl core::error::Error for Unreachable {}

impl core::error::Error for MotionError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Unreachable(reason) => Some(reason),
            Self::Limit { .. } | Self::Speed { .. } | Self::Coincident | Self::Collinear => None,
        }
    }
}
