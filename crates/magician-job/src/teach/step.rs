//! A step of a program that is taught, and the steps of a plan that it stands for.

use magician_program::{Action, Grip};

/// A step of a program that is taught: where the arm goes, what its tool does there, how long it stays. In a plan that is up to four
/// steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TeachStep {
    /// What it is called; empty if it has no name.
    pub name: String,
    /// A move as a rule; also anything else that a file may have, which is kept as it is. `None`: where the step before ends.
    pub motion: Option<Action>,
    /// What the gripper does there; nothing new without.
    pub gripper: Option<Grip>,
    /// Whether the suction cup goes on or off there; nothing new without.
    pub suction: Option<bool>,
    /// How long it stays there, ms.
    pub pause: u32,
}

impl TeachStep {
    /// What is done for it, in order.
    pub(super) fn actions(&self) -> impl Iterator<Item = Action> + '_ {
        let pause = (self.pause > 0).then_some(Action::Wait(self.pause));
        let motion = self.motion.clone();
        motion
            .into_iter()
            .chain(self.gripper.map(Action::Gripper))
            .chain(self.suction.map(Action::Suction))
            .chain(pause)
    }

    /// Number of steps of a plan that it becomes.
    pub(super) fn plan_steps(&self) -> usize {
        self.actions().count()
    }

    /// Takes a step of a plan as a part of this one, if it can be one.
    pub(super) fn takes(&mut self, action: &Action) -> bool {
        let fresh = self.pause == 0;
        match *action {
            Action::Gripper(grip) if fresh && self.gripper.is_none() && self.suction.is_none() => {
                self.gripper = Some(grip);
            }
            Action::Suction(on) if fresh && self.suction.is_none() => self.suction = Some(on),
            Action::Wait(pause) if fresh && pause > 0 => self.pause = pause,
            _ => return false,
        }
        true
    }

    /// A step that begins with this one of a plan.
    pub(super) fn of(action: &Action, name: &str) -> Self {
        let mut step = Self {
            name: name.to_owned(),
            ..Self::default()
        };
        if !step.takes(action) {
            step.motion = Some(action.clone());
        }
        step
    }
}
