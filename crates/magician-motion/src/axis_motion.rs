//! Motion of one axis: a joint, or the carriage of the rail.

use crate::MotionLaw;
use crate::velocity_profile::VelocityProfile;

/// Motion of one axis: a velocity profile with a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMotion {
    /// Direction, 1 or -1.
    sign: f64,
    profile: VelocityProfile,
}

impl AxisMotion {
    /// No motion.
    #[must_use]
    pub fn at_rest() -> Self {
        Self::new(1.0, VelocityProfile::default())
    }

    /// Creates a motion in the direction of the sign of `direction`.
    #[must_use]
    pub fn new(direction: f64, profile: VelocityProfile) -> Self {
        let sign = libm::copysign(1.0, direction);
        Self { sign, profile }
    }

    /// Creates a stop from a velocity of either sign in `duration` seconds.
    #[must_use]
    pub fn stopping_in(law: MotionLaw, velocity: f64, duration: f64) -> Self {
        Self::new(velocity, law.stop_in(libm::fabs(velocity), duration))
    }

    /// Creates a stop from a velocity of either sign at a constant deceleration.
    pub(crate) fn stopping(law: MotionLaw, velocity: f64, deceleration: f64) -> Self {
        Self::new(velocity, law.stop(libm::fabs(velocity), deceleration))
    }

    /// Profile of the speed, without direction.
    #[must_use]
    pub fn profile(&self) -> &VelocityProfile {
        &self.profile
    }

    /// Direction: 1 forwards, -1 backwards.
    #[must_use]
    pub fn sign(&self) -> f64 {
        self.sign
    }

    /// Distance from the start after `t` seconds, signed.
    #[must_use]
    pub fn offset(&self, t: f64) -> f64 {
        self.sign * self.profile.position(t)
    }

    /// Velocity after `t` seconds, signed.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        self.sign * self.profile.velocity(t)
    }

    /// Offset, velocity and acceleration at `t`, signed, of the curve piece valid at `around`.
    pub(crate) fn curve(&self, around: f64, t: f64) -> [f64; 3] {
        let piece = self.profile.piece(around);
        [piece.position(t), piece.velocity(t), piece.acceleration()].map(|value| self.sign * value)
    }

    /// Duration, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.profile.duration()
    }

    /// Stretches the motion to `duration` seconds: [`VelocityProfile::stretched`].
    pub(crate) fn stretched(&self, duration: f64) -> Self {
        Self::new(self.sign, self.profile.stretched(duration))
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = f64> {
        self.profile.corners().into_iter().chain([self.duration()])
    }
}
