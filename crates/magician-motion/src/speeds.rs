//! How fast a motion may be: what has been set, the ratio, and the arm's ceilings.

use crate::profile::Rates;
use crate::{MotionError, SpeedQuantity};

/// The point-to-point speed settings as they stand, in the values of the protocol: nothing clamped or checked.
///
/// A plan takes from them what its motion needs: each value up to the arm's ceiling, times its ratio up to 100 %
/// (model section 6).
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
    /// Percentage of every velocity; above 100 counts as 100.
    pub velocity_ratio: f64,
    /// Percentage of every acceleration; above 100 counts as 100.
    pub acceleration_ratio: f64,
}

impl Speeds {
    /// The settings at power-up (model section 6).
    pub const POWER_UP: Self = Self {
        joint_velocity: [200.0; 4],
        joint_acceleration: [200.0; 4],
        linear_velocity: 200.0,
        linear_acceleration: 200.0,
        rotation_velocity: 100.0,
        rotation_acceleration: 100.0,
        velocity_ratio: 50.0,
        acceleration_ratio: 50.0,
    };

    /// The fastest the arm goes whatever has been set (model section 6); r turns as fast as the servo of J4.
    pub const CEILINGS: Self = Self {
        joint_velocity: [320.0, 320.0, 320.0, 480.0],
        joint_acceleration: [300.0; 4],
        linear_velocity: 300.0,
        linear_acceleration: 400.0,
        rotation_velocity: 480.0,
        rotation_acceleration: 300.0,
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    };

    /// The speeds of the last part of homing, which no setting scales (model section 11).
    pub const HOMING: Self = Self {
        joint_velocity: [30.0, 50.0, 50.0, 50.0],
        joint_acceleration: [30.0, 50.0, 50.0, 50.0],
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
        ..Self::POWER_UP
    };

    /// The same rates on every axis, at no ratio.
    pub(crate) fn unscaled(rates: Rates) -> Self {
        Self {
            joint_velocity: [rates.velocity; 4],
            joint_acceleration: [rates.acceleration; 4],
            linear_velocity: rates.velocity,
            linear_acceleration: rates.acceleration,
            rotation_velocity: rates.velocity,
            rotation_acceleration: rates.acceleration,
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
        }
    }

    /// Velocity and acceleration of a joint, its index from 0.
    pub(crate) fn joint(&self, index: usize) -> Result<Rates, MotionError> {
        let name = u8::try_from(index + 1).unwrap_or(u8::MAX);
        let of = |values: [f64; 4]| values.get(index).copied().unwrap_or(f64::NAN);
        self.rates(
            Setting {
                quantity: SpeedQuantity::JointVelocity(name),
                value: of(self.joint_velocity),
                ceiling: of(Self::CEILINGS.joint_velocity),
            },
            Setting {
                quantity: SpeedQuantity::JointAcceleration(name),
                value: of(self.joint_acceleration),
                ceiling: of(Self::CEILINGS.joint_acceleration),
            },
        )
    }

    /// Velocity and acceleration along a straight line.
    pub(crate) fn linear(&self) -> Result<Rates, MotionError> {
        self.rates(
            Setting {
                quantity: SpeedQuantity::LinearVelocity,
                value: self.linear_velocity,
                ceiling: Self::CEILINGS.linear_velocity,
            },
            Setting {
                quantity: SpeedQuantity::LinearAcceleration,
                value: self.linear_acceleration,
                ceiling: Self::CEILINGS.linear_acceleration,
            },
        )
    }

    /// Velocity and acceleration of r along a straight line.
    pub(crate) fn rotation(&self) -> Result<Rates, MotionError> {
        self.rates(
            Setting {
                quantity: SpeedQuantity::RotationVelocity,
                value: self.rotation_velocity,
                ceiling: Self::CEILINGS.rotation_velocity,
            },
            Setting {
                quantity: SpeedQuantity::RotationAcceleration,
                value: self.rotation_acceleration,
                ceiling: Self::CEILINGS.rotation_acceleration,
            },
        )
    }

    fn rates(&self, velocity: Setting, acceleration: Setting) -> Result<Rates, MotionError> {
        let velocity_ratio = ratio(SpeedQuantity::VelocityRatio, self.velocity_ratio)?;
        let acceleration_ratio = ratio(SpeedQuantity::AccelerationRatio, self.acceleration_ratio)?;
        Ok(Rates {
            velocity: velocity.capped()? * velocity_ratio,
            acceleration: acceleration.capped()? * acceleration_ratio,
        })
    }
}

impl Default for Speeds {
    /// The settings at power-up.
    fn default() -> Self {
        Self::POWER_UP
    }
}

struct Setting {
    quantity: SpeedQuantity,
    value: f64,
    ceiling: f64,
}

impl Setting {
    fn capped(&self) -> Result<f64, MotionError> {
        positive(self.quantity, self.value).map(|value| value.min(self.ceiling))
    }
}

/// A speed below this is none: times could no longer be told.
const LEAST: f64 = 1e-50;

fn ratio(quantity: SpeedQuantity, percent: f64) -> Result<f64, MotionError> {
    positive(quantity, percent).map(|percent| percent.min(100.0) / 100.0)
}

pub(crate) fn positive(quantity: SpeedQuantity, value: f64) -> Result<f64, MotionError> {
    if value >= LEAST {
        Ok(value)
    } else {
        Err(MotionError::Speed { quantity, value })
    }
}

/// A speed that a motion has already, or is to end with: zero is one.
pub(crate) fn finite_speed(quantity: SpeedQuantity, value: f64) -> Result<f64, MotionError> {
    if (0.0..f64::INFINITY).contains(&value) {
        Ok(value)
    } else {
        Err(MotionError::Speed { quantity, value })
    }
}
