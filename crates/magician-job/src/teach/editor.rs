//! Teaching by demonstration: points are stored where the arm stands, and the program is played
//! back.

use magician::commands::Pose;
use magician_program::Plan;

use super::{ProgramModel, TeachError};
use crate::jog::{Activity, PendantOrder, ToolOrder};

/// Program being taught, next to an arm that demonstrates points and plays it. It has no side
/// effects: actions are returned as orders for a [`PendantSession`](crate::jog::PendantSession).
///
/// ```
/// use magician::commands::Pose;
/// use magician_job::teach::{ProgramModel, TeachEditor, TeachError};
///
/// let mut editor = TeachEditor::new(ProgramModel::new("pick", None));
/// let pose = Pose { x: 220.0, y: 0.0, z: 40.0, r: 0.0, joint_angle: [0.0, 30.0, 20.0, 0.0] };
/// assert_eq!(editor.store(Some(&pose), false), Err(TeachError::Moving));
/// assert_eq!(editor.store(Some(&pose), true).as_deref(), Ok("P1"));
/// editor.program.set_pause(500)?;
/// assert_eq!(editor.program.plan(0).steps.len(), 2);
/// # Ok::<(), TeachError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TeachEditor {
    /// Program taught so far.
    pub program: ProgramModel,
    /// True if hand-guided points are stored ([`guided_points`](super::guided_points)); `None` if
    /// the arm does not report them.
    pub hand_guiding: Option<bool>,
    playing: Option<Playing>,
}

/// Position in the program being played, from [`TeachEditor::play`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Playing {
    /// First taught step of the plan being played.
    first: usize,
    /// Current taught step.
    step: usize,
}

impl TeachEditor {
    /// An editor for an arm that does not report hand-guided points.
    #[must_use]
    pub const fn new(program: ProgramModel) -> Self {
        Self {
            program,
            hand_guiding: None,
            playing: None,
        }
    }

    /// Stores the pose after the selected step, selects it, and returns its name.
    ///
    /// # Errors
    /// [`TeachError::Moving`] unless `still`, [`TeachError::NoAnswer`] without a pose.
    pub fn store(&mut self, pose: Option<&Pose>, still: bool) -> Result<String, TeachError> {
        Ok(self.program.store(pose_at_rest(pose, still)?))
    }

    /// Replaces the target of the selected step by the pose.
    ///
    /// # Errors
    /// Same as [`store`](Self::store), and as [`ProgramModel::reteach`].
    pub fn reteach(&mut self, pose: Option<&Pose>, still: bool) -> Result<(), TeachError> {
        self.program.reteach(pose_at_rest(pose, still)?)
    }

    /// Makes the next stored point the end of an arc through this pose.
    ///
    /// # Errors
    /// Same as [`store`](Self::store).
    pub fn arc_through(&mut self, pose: Option<&Pose>, still: bool) -> Result<(), TeachError> {
        self.program.arc_through(pose_at_rest(pose, still)?);
        Ok(())
    }

    /// Stores a hand-guided point. `None` if that is off, or the selected step already leads to
    /// this pose.
    pub fn store_guided(&mut self, pose: &Pose) -> Option<String> {
        let wanted = self.hand_guiding == Some(true) && !self.program.is_at(pose);
        wanted.then(|| self.program.store(pose))
    }

    /// Switches the storing of hand-guided points; returns the new state. `None` if the arm does
    /// not report them.
    pub fn toggle_hand_guiding(&mut self) -> Option<bool> {
        let hand_guiding = self.hand_guiding.as_mut()?;
        *hand_guiding = !*hand_guiding;
        Some(*hand_guiding)
    }

    /// Order that plays from a step on. If it is accepted, call
    /// [`start_playing`](Self::start_playing).
    ///
    /// A step without an absolute target can begin only where the previous one ends. In that case
    /// the plan contains the whole program, and the order starts it at the step's first action.
    #[must_use]
    pub fn play(&self, from: usize) -> (PendantOrder, Playing) {
        let (first, step) = if self.program.is_independent_of_start(from) {
            (from, 0)
        } else {
            (0, self.program.plan_steps_before(from))
        };
        let plan = Box::new(self.program.plan(first));
        let order = PendantOrder::Run { plan, from: step };
        (order, Playing { first, step: from })
    }

    /// Notes that the order to play was accepted.
    pub const fn start_playing(&mut self, playing: Playing) {
        self.playing = Some(playing);
    }

    /// Step being played, from 0, as far as [`follow`](Self::follow) knows.
    #[must_use]
    pub fn playing(&self) -> Option<usize> {
        self.playing.map(|playing| playing.step)
    }

    /// Updates the played step from the arm's activity and the current step of its plan.
    pub fn follow(&mut self, doing: Option<Activity>, step: Option<usize>) {
        let Some(playing) = self.playing.filter(|_| doing == Some(Activity::Run)) else {
            self.playing = None;
            return;
        };
        let step = step.and_then(|step| self.program.step_at(playing.first, step));
        let step = step.unwrap_or(playing.step);
        self.playing = Some(Playing { step, ..playing });
    }

    /// Replaces the program by an unsaved one of an earlier session. Its points refer to its tool,
    /// and so must later ones: if the tool differs, the returned order sets it on the arm.
    pub fn recover(&mut self, left: &Plan) -> Option<ToolOrder> {
        let before = self.program.tool;
        let title = std::mem::take(&mut self.program.title);
        self.program = ProgramModel::from_plan(left);
        self.program.title = title;
        self.program.tool = left.tool.or(before);
        self.program.mark_unsaved();
        let tool = self.program.tool.filter(|tool| Some(*tool) != before);
        tool.map(|tool| ToolOrder::Tip(tool.bias()))
    }
}

/// Pose of an arm that stands still.
fn pose_at_rest(pose: Option<&Pose>, still: bool) -> Result<&Pose, TeachError> {
    match pose {
        Some(pose) if still => Ok(pose),
        Some(_) => Err(TeachError::Moving),
        None => Err(TeachError::NoAnswer),
    }
}

#[cfg(test)]
mod tests {
    use magician_program::{Action, Tool};

    use super::*;

    fn pose(x: f32) -> Pose {
        Pose {
            x,
            y: 0.0,
            z: 40.0,
            r: 0.0,
            joint_angle: [0.0; 4],
        }
    }

    fn taught() -> TeachEditor {
        let mut editor = TeachEditor::new(ProgramModel::new("lesson", Some(Tool::Suction)));
        for x in [200.0, 210.0] {
            editor.store(Some(&pose(x)), true).unwrap();
        }
        editor.program.next_suction().unwrap();
        editor.arc_through(Some(&pose(220.0)), true).unwrap();
        editor.store(Some(&pose(240.0)), true).unwrap();
        editor
    }

    #[test]
    fn point_is_stored_only_at_rest() {
        let mut editor = taught();
        let before = editor.program.plan(0);
        for (pose, still, why) in [
            (Some(pose(1.0)), false, TeachError::Moving),
            (None, true, TeachError::NoAnswer),
            (None, false, TeachError::NoAnswer),
        ] {
            assert_eq!(editor.store(pose.as_ref(), still), Err(why));
            assert_eq!(editor.reteach(pose.as_ref(), still), Err(why));
            assert_eq!(editor.arc_through(pose.as_ref(), still), Err(why));
        }
        assert_eq!(
            (editor.program.plan(0), editor.program.via()),
            (before, None)
        );
    }

    #[test]
    fn hand_guided_point_is_stored_once_and_only_while_enabled() {
        let mut editor = taught();
        assert_eq!(editor.toggle_hand_guiding(), None);
        assert_eq!(editor.store_guided(&pose(1.0)), None);
        editor.hand_guiding = Some(true);
        assert_eq!(editor.store_guided(&pose(1.0)).as_deref(), Some("P4"));
        assert_eq!(editor.store_guided(&pose(1.0)), None);
        assert_eq!(editor.toggle_hand_guiding(), Some(false));
        assert_eq!(editor.store_guided(&pose(2.0)), None);
    }

    #[test]
    fn playback_position_follows_the_plan_step_by_step() {
        let mut editor = taught();
        // A move can be played from itself on; an arc needs the steps before it.
        for (from, steps, begins) in [(0, 4, 0), (1, 3, 0), (2, 4, 3)] {
            let (order, playing) = editor.play(from);
            let PendantOrder::Run { plan, from: step } = order else {
                panic!("{order:?}");
            };
            assert_eq!((plan.steps.len(), step), (steps, begins));
            editor.start_playing(playing);
            editor.follow(Some(Activity::Run), None);
            assert_eq!(editor.playing(), Some(from));
        }
        let (_, playing) = editor.play(1);
        editor.start_playing(playing);
        let steps = [0, 1, 2, 3].map(|step| {
            editor.follow(Some(Activity::Run), Some(step));
            editor.playing()
        });
        assert_eq!(steps, [Some(1), Some(1), Some(2), Some(2)]);
        editor.follow(Some(Activity::Stop), Some(2));
        assert_eq!(editor.playing(), None);
    }

    #[test]
    fn recovered_program_is_unsaved_and_sets_its_tool() {
        let mut left = taught().program.plan(0);
        let mut editor = TeachEditor::new(ProgramModel::new("now", Some(Tool::Suction)));
        assert_eq!(editor.recover(&left), None);
        assert!(!editor.program.is_saved());
        assert_eq!(editor.program.title, "now");
        assert_eq!(editor.program.plan(0).steps.len(), left.steps.len());
        left.tool = Some(Tool::Pen);
        let tip = Some(ToolOrder::Tip(Tool::Pen.bias()));
        assert_eq!(editor.recover(&left), tip);
        left.tool = None;
        assert_eq!(editor.recover(&left), None, "of the tool that there is");
        assert_eq!(editor.program.tool, Some(Tool::Pen));
        assert!(matches!(left.steps[0].action, Action::Move { .. }));
    }
}
