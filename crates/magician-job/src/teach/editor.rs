//! A person teaches: places are stored where the arm stands, and what has been taught is played.

use magician::commands::Pose;
use magician_program::Plan;

use super::{ProgramModel, TeachError};
use crate::jog::{Activity, PendantOrder, ToolOrder};

/// A program that is being taught, beside an arm that shows it points and plays it. It does nothing itself: what is to be done is an
/// order for a [`PendantSession`](crate::jog::PendantSession).
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
    /// What has been taught.
    pub program: ProgramModel,
    /// Whether points are stored that a hand teaches ([`guided_points`](super::guided_points)); `None` if the arm does not report them.
    pub hand_guiding: Option<bool>,
    playing: Option<Playing>,
}

/// What is played: from [`TeachEditor::play`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Playing {
    /// The step that the program begins with.
    first: usize,
    /// The step that the arm is at.
    step: usize,
}

impl TeachEditor {
    /// For an arm that reports no points that a hand teaches.
    #[must_use]
    pub const fn new(program: ProgramModel) -> Self {
        Self {
            program,
            hand_guiding: None,
            playing: None,
        }
    }

    /// Stores where the arm stands after the step that is selected, and selects it; the name that it got.
    ///
    /// # Errors
    /// [`TeachError::Moving`] unless it is `still`, [`TeachError::NoAnswer`] without a pose.
    pub fn store(&mut self, pose: Option<&Pose>, still: bool) -> Result<String, TeachError> {
        Ok(self.program.store(standing(pose, still)?))
    }

    /// Lets the step that is selected lead to where the arm stands.
    ///
    /// # Errors
    /// As [`store`](Self::store), and as [`ProgramModel::reteach`].
    pub fn reteach(&mut self, pose: Option<&Pose>, still: bool) -> Result<(), TeachError> {
        self.program.reteach(standing(pose, still)?)
    }

    /// Lets the next point that is stored be the end of an arc through where the arm stands.
    ///
    /// # Errors
    /// As [`store`](Self::store).
    pub fn arc_through(&mut self, pose: Option<&Pose>, still: bool) -> Result<(), TeachError> {
        self.program.arc_through(standing(pose, still)?);
        Ok(())
    }

    /// Stores where a hand has left the arm; nothing if such points are not wanted, and where the step that is selected leads
    /// already.
    pub fn store_guided(&mut self, pose: &Pose) -> Option<String> {
        let wanted = self.hand_guiding == Some(true) && !self.program.is_at(pose);
        wanted.then(|| self.program.store(pose))
    }

    /// Stores points that a hand teaches from now on, or no more; whether it does. `None` if the arm does not report them.
    pub fn toggle_hand_guiding(&mut self) -> Option<bool> {
        let hand_guiding = self.hand_guiding.as_mut()?;
        *hand_guiding = !*hand_guiding;
        Some(*hand_guiding)
    }

    /// The order that plays from a step on; when it was taken, [`playing_began`](Self::playing_began) is to know. A step that only
    /// leads on begins where the one before ends, and nowhere else: then the program is all of it, from that step's first step.
    #[must_use]
    pub fn play(&self, from: usize) -> (PendantOrder, Playing) {
        let (first, step) = if self.program.leads_from_anywhere(from) {
            (from, 0)
        } else {
            (0, self.program.plan_steps_before(from))
        };
        let plan = Box::new(self.program.plan(first));
        let order = PendantOrder::Run { plan, from: step };
        (order, Playing { first, step: from })
    }

    /// The order to play was taken.
    pub const fn playing_began(&mut self, playing: Playing) {
        self.playing = Some(playing);
    }

    /// The step that is played, from 0, as far as [`follow`](Self::follow) knows.
    #[must_use]
    pub fn playing(&self) -> Option<usize> {
        self.playing.map(|playing| playing.step)
    }

    /// Takes note of what the arm does, and of the step of the program that it is at.
    pub fn follow(&mut self, doing: Option<Activity>, step: Option<usize>) {
        let Some(playing) = self.playing.filter(|_| doing == Some(Activity::Run)) else {
            self.playing = None;
            return;
        };
        let step = step.and_then(|step| self.program.step_at(playing.first, step));
        let step = step.unwrap_or(playing.step);
        self.playing = Some(Playing { step, ..playing });
    }

    /// Goes on with a program that was left unsaved, in place of this one. Its points are for its tool, and those that follow have
    /// to be, too: the order, if that is another one, has the arm count from its tip.
    pub fn recover(&mut self, left: &Plan) -> Option<ToolOrder> {
        let before = self.program.tool;
        let title = std::mem::take(&mut self.program.title);
        self.program = ProgramModel::of(left);
        self.program.title = title;
        self.program.tool = left.tool.or(before);
        self.program.mark_unsaved();
        let tool = self.program.tool.filter(|tool| Some(*tool) != before);
        tool.map(|tool| ToolOrder::Tip(tool.bias()))
    }
}

/// Where the arm stands.
fn standing(pose: Option<&Pose>, still: bool) -> Result<&Pose, TeachError> {
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
    fn a_point_is_where_the_arm_is_known_to_stand() {
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
    fn a_hand_stores_a_place_once_and_only_while_that_is_wanted() {
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
    fn what_is_played_is_followed_row_by_row() {
        let mut editor = taught();
        // From a move on the program is what comes from there; an arc needs what comes before.
        for (from, steps, begins) in [(0, 4, 0), (1, 3, 0), (2, 4, 3)] {
            let (order, playing) = editor.play(from);
            let PendantOrder::Run { plan, from: step } = order else {
                panic!("{order:?}");
            };
            assert_eq!((plan.steps.len(), step), (steps, begins));
            editor.playing_began(playing);
            editor.follow(Some(Activity::Run), None);
            assert_eq!(editor.playing(), Some(from));
        }
        let (_, playing) = editor.play(1);
        editor.playing_began(playing);
        let steps = [0, 1, 2, 3].map(|step| {
            editor.follow(Some(Activity::Run), Some(step));
            editor.playing()
        });
        assert_eq!(steps, [Some(1), Some(1), Some(2), Some(2)]);
        editor.follow(Some(Activity::Stop), Some(2));
        assert_eq!(editor.playing(), None);
    }

    #[test]
    fn what_was_left_is_unsaved_and_brings_its_tool() {
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
