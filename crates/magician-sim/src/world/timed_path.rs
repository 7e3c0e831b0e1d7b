//! True motion of the arm over a span of time.

use magician_motion::JointAngles;

use crate::ArmInstant;

/// True state of the arm: after lost steps it differs from the commanded one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointState {
    /// Joints, deg.
    pub joints: JointAngles,
    /// Carriage of the rail, mm along Y of the arm's base.
    pub rail: f64,
}

/// A piece of the arm's motion as a function of the arm's time.
pub struct TimedPath<'a> {
    /// Start.
    pub from: ArmInstant,
    /// End.
    pub to: ArmInstant,
    at: &'a dyn Fn(ArmInstant) -> JointState,
}

impl<'a> TimedPath<'a> {
    /// Creates the path that `at` describes between two instants.
    pub fn new(from: ArmInstant, to: ArmInstant, at: &'a dyn Fn(ArmInstant) -> JointState) -> Self {
        Self { from, to, at }
    }

    /// State at an instant, clamped to the path.
    #[must_use]
    pub fn at(&self, now: ArmInstant) -> JointState {
        (self.at)(now.clamp(self.from, self.to))
    }
}
