//! The motion of one axis: a joint, or the carriage of the rail.

use crate::MotionLaw;
use crate::velocity_profile::VelocityProfile;

/// How one axis goes from where it stands: forwards or backwards by a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMotion {
    /// 1 or -1.
    sign: f64,
    profile: VelocityProfile,
}

impl AxisMotion {
    /// No motion.
    #[must_use]
    pub fn at_rest() -> Self {
        Self::new(1.0, VelocityProfile::default())
    }

    /// In the direction of a number's sign.
    #[must_use]
    pub fn new(direction: f64, profile: VelocityProfile) -> Self {
        let sign = libm::copysign(1.0, direction);
        Self { sign, profile }
    }

    /// From a velocity of either sign to rest in `duration` seconds.
    #[must_use]
    pub fn stopping_in(law: MotionLaw, velocity: f64, duration: f64) -> Self {
        Self::new(velocity, law.stop_in(libm::fabs(velocity), duration))
    }

    /// From a velocity of either sign to rest at a steady deceleration.
    pub(crate) fn stopping(law: MotionLaw, velocity: f64, deceleration: f64) -> Self {
        Self::new(velocity, law.stop(libm::fabs(velocity), deceleration))
    }

    /// The speed without the direction.
    #[must_use]
    pub fn profile(&self) -> &VelocityProfile {
        &self.profile
    }

    /// 1 forwards, -1 backwards.
    #[must_use]
    pub fn sign(&self) -> f64 {
        self.sign
    }

    /// How far it has gone after `t` seconds, with its sign.
    #[must_use]
    pub fn offset(&self, t: f64) -> f64 {
        self.sign * self.profile.position(t)
    }

    /// The velocity after `t` seconds, with its sign.
    #[must_use]
    pub fn velocity(&self, t: f64) -> f64 {
        self.sign * self.profile.velocity(t)
    }

    /// Offset, velocity and acceleration at `t` of the curve that holds around `around`, with their sign.
    pub(crate) fn curve(&self, around: f64, t: f64) -> [f64; 3] {
        let piece = self.profile.piece(around);
        [piece.position(t), piece.velocity(t), piece.acceleration()].map(|value| self.sign * value)
    }

    /// The time it takes, seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.profile.duration()
    }

    /// The same way in `duration` seconds: [`VelocityProfile::stretched`].
    pub(crate) fn stretched(&self, duration: f64) -> Self {
        Self::new(self.sign, self.profile.stretched(duration))
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = f64> {
        self.profile.corners().into_iter().chain([self.duration()])
    }
}
