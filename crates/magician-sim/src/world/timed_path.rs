//! Where the arm really goes for a while.

use magician_motion::JointAngles;

use crate::ArmInstant;

/// Where the arm really is: after lost steps, not where the controller believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointState {
    /// The joints, deg.
    pub joints: JointAngles,
    /// The carriage on the rail, mm along Y of the arm's base.
    pub rail: f64,
}

/// A stretch of the arm's motion, as a function of the arm's time.
pub struct TimedPath<'a> {
    /// When it begins.
    pub from: ArmInstant,
    /// When it ends.
    pub to: ArmInstant,
    at: &'a dyn Fn(ArmInstant) -> JointState,
}

impl<'a> TimedPath<'a> {
    /// The path that `at` describes from one instant to another.
    pub fn new(from: ArmInstant, to: ArmInstant, at: &'a dyn Fn(ArmInstant) -> JointState) -> Self {
        Self { from, to, at }
    }

    /// The joint state at an instant of the path.
    #[must_use]
    pub fn at(&self, now: ArmInstant) -> JointState {
        (self.at)(now.clamp(self.from, self.to))
    }
}
