//! Speed of a motion from settings, ratio and ceilings (model section 6).

use crate::velocity_profile::KinematicLimits;
use crate::{ArmModel, Ceilings, MotionError, SpeedQuantity};

/// Point-to-point speed settings in the units of the protocol, neither clamped nor checked.
///
/// A plan uses each value up to the arm's ceiling, times its ratio up to 100 % (model section 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// Velocity of J1 to J4, deg/s.
    pub joint_velocity: [f64; 4],
    /// Acceleration of J1 to J4, deg/s2.
    pub joint_acceleration: [f64; 4],
    /// Velocity along a straight line, mm/s.
    pub linear_velocity: f64,
    /// Acceleration along a straight line, mm/s2.
    pub linear_acceleration: f64,
    /// Velocity of r along a straight line, deg/s.
    pub rotation_velocity: f64,
    /// Acceleration of r along a straight line, deg/s2.
    pub rotation_acceleration: f64,
    /// Ratio of every velocity, percent; above 100 counts as 100.
    pub velocity_ratio: f64,
    /// Ratio of every acceleration, percent; above 100 counts as 100.
    pub acceleration_ratio: f64,
}

impl Speeds {
    /// Velocity and acceleration of a joint by index, from 0.
    pub(crate) fn joint(
        &self,
        index: usize,
        ceilings: &Ceilings,
    ) -> Result<KinematicLimits, MotionError> {
        let of = |values: [f64; 4]| values.get(index).copied().unwrap_or(f64::NAN);
        let set = KinematicLimits {
            velocity: of(self.joint_velocity),
            acceleration: of(self.joint_acceleration),
        };
        self.scaled(|| ceilings.joint(index, set))
    }

    /// Velocity and acceleration along a straight line.
    pub(crate) fn linear(&self, ceilings: &Ceilings) -> Result<KinematicLimits, MotionError> {
        let set = KinematicLimits {
            velocity: self.linear_velocity,
            acceleration: self.linear_acceleration,
        };
        self.scaled(|| ceilings.linear(set))
    }

    /// Velocity and acceleration of r along a straight line.
    pub(crate) fn rotation(&self, ceilings: &Ceilings) -> Result<KinematicLimits, MotionError> {
        let set = KinematicLimits {
            velocity: self.rotation_velocity,
            acceleration: self.rotation_acceleration,
        };
        self.scaled(|| ceilings.rotation(set))
    }

    fn scaled(
        &self,
        capped: impl FnOnce() -> Result<KinematicLimits, MotionError>,
    ) -> Result<KinematicLimits, MotionError> {
        let velocity_ratio = ratio(SpeedQuantity::VelocityRatio, self.velocity_ratio)?;
        let acceleration_ratio = ratio(SpeedQuantity::AccelerationRatio, self.acceleration_ratio)?;
        let capped = capped()?;
        Ok(KinematicLimits {
            velocity: capped.velocity * velocity_ratio,
            acceleration: capped.acceleration * acceleration_ratio,
        })
    }
}

impl Default for Speeds {
    /// Settings at power-up of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.power_up.speeds()
    }
}

impl Ceilings {
    /// Limits the rates of a joint (by index, from 0) to its ceilings.
    pub(crate) fn joint(
        &self,
        index: usize,
        rates: KinematicLimits,
    ) -> Result<KinematicLimits, MotionError> {
        let name = u8::try_from(index + 1).unwrap_or(u8::MAX);
        let of = |values: [f64; 4]| values.get(index).copied().unwrap_or(f64::NAN);
        Ok(KinematicLimits {
            velocity: positive(SpeedQuantity::JointVelocity(name), rates.velocity)?
                .min(of(self.joint_velocity)),
            acceleration: positive(SpeedQuantity::JointAcceleration(name), rates.acceleration)?
                .min(self.joint_acceleration),
        })
    }

    /// Limits rates along a path to the ceilings.
    pub(crate) fn linear(&self, rates: KinematicLimits) -> Result<KinematicLimits, MotionError> {
        Ok(KinematicLimits {
            velocity: positive(SpeedQuantity::LinearVelocity, rates.velocity)?
                .min(self.linear_velocity),
            acceleration: positive(SpeedQuantity::LinearAcceleration, rates.acceleration)?
                .min(self.linear_acceleration),
        })
    }

    /// Limits rates of r along a path to the ceilings.
    pub(crate) fn rotation(&self, rates: KinematicLimits) -> Result<KinematicLimits, MotionError> {
        Ok(KinematicLimits {
            velocity: positive(SpeedQuantity::RotationVelocity, rates.velocity)?
                .min(self.rotation_velocity),
            acceleration: positive(SpeedQuantity::RotationAcceleration, rates.acceleration)?
                .min(self.rotation_acceleration),
        })
    }
}

/// Smallest valid speed. Below it durations overflow, so it counts as zero.
const MIN_SPEED: f64 = 1e-50;

fn ratio(quantity: SpeedQuantity, percent: f64) -> Result<f64, MotionError> {
    positive(quantity, percent).map(|percent| percent.min(100.0) / 100.0)
}

pub(crate) fn positive(quantity: SpeedQuantity, value: f64) -> Result<f64, MotionError> {
    if value >= MIN_SPEED {
        Ok(value)
    } else {
        Err(MotionError::Speed { quantity, value })
    }
}

/// Checks a speed at the start or the end of a motion. Zero is valid.
pub(crate) fn finite_speed(quantity: SpeedQuantity, value: f64) -> Result<f64, MotionError> {
    if (0.0..f64::INFINITY).contains(&value) {
        Ok(value)
    } else {
        Err(MotionError::Speed { quantity, value })
    }
}
