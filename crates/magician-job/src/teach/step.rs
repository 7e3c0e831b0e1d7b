//! Step of a taught program, and the steps of a plan that it stands for.

use magician_program::{Action, Grip};

/// Step of a taught program: target, action of the tool there, and pause. In a plan it becomes up
/// to four steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TeachStep {
    /// Name; empty if the step has none.
    pub name: String,
    /// Usually a move; also any other action found in a file, which is kept unchanged. `None` stays
    /// where the previous step ends.
    pub motion: Option<Action>,
    /// Action of the gripper there; `None` leaves it as it is.
    pub gripper: Option<Grip>,
    /// True switches the suction cup on, false off; `None` leaves it as it is.
    pub suction: Option<bool>,
    /// Pause there, ms.
    pub pause: u32,
}

impl TeachStep {
    /// Actions of the step, in order.
    pub(super) fn actions(&self) -> impl Iterator<Item = Action> + '_ {
        let pause = (self.pause > 0).then_some(Action::Wait(self.pause));
        let motion = self.motion.clone();
        motion
            .into_iter()
            .chain(self.gripper.map(Action::Gripper))
            .chain(self.suction.map(Action::Suction))
            .chain(pause)
    }

    /// Returns the number of plan steps of this step.
    pub(super) fn plan_steps(&self) -> usize {
        self.actions().count()
    }

    /// Adds an action of a plan to this step; false if it does not fit.
    pub(super) fn absorb(&mut self, action: &Action) -> bool {
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

    /// Creates a step that begins with this action.
    pub(super) fn of(action: &Action, name: &str) -> Self {
        let mut step = Self {
            name: name.to_owned(),
            ..Self::default()
        };
        if !step.absorb(action) {
            step.motion = Some(action.clone());
        }
        step
    }
}
