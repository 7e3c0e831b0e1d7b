//! Model of a taught program: its steps and all edits, with undo and redo.

use std::sync::Arc;

use magician::commands::Pose;
use magician_program::{Action, Grip, Origin, Plan, Step, Surface, Tool, Travel};

use super::history::History;
use super::{TeachError, TeachStep};

/// State for undo.
#[derive(Clone, Debug, PartialEq)]
struct Snapshot {
    steps: Arc<Vec<TeachStep>>,
    selected: usize,
}

/// Taught program whose steps can be added, edited, moved and deleted, with undo and redo. Edits
/// apply to the selected step.
///
/// ```
/// use magician::commands::Pose;
/// use magician_job::teach::ProgramModel;
/// use magician_program::Travel;
///
/// let mut program = ProgramModel::new("pick", None);
/// for x in [220.0, 240.0] {
///     program.store(&Pose { x, y: 0.0, z: 40.0, r: 0.0, joint_angle: [0.0, 30.0, 20.0, 0.0] });
/// }
/// program.next_suction()?;
/// program.rename("take")?;
/// assert!(program.undo());
/// assert_eq!((program.steps()[1].name.as_str(), program.steps()[1].suction), ("P2", Some(true)));
/// assert_eq!(program.plan(0).steps.len(), 3);
/// # Ok::<(), magician_job::teach::TeachError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ProgramModel {
    /// Title of the program.
    pub title: String,
    /// Tool whose tip is at the points.
    pub tool: Option<Tool>,
    surface: Option<Surface>,
    /// Shared with the history and the display, so that a copy of many steps is cheap.
    steps: Arc<Vec<TeachStep>>,
    /// Selected step, from 0; 0 if there are no steps.
    selected: usize,
    /// Motion type of new points.
    by: Travel,
    /// Via point of the arc to the next point.
    via: Option<[f32; 4]>,
    history: History<Snapshot>,
    saved: Arc<Vec<TeachStep>>,
}

impl ProgramModel {
    /// A program without steps.
    #[must_use]
    pub fn new(title: impl Into<String>, tool: Option<Tool>) -> Self {
        Self {
            title: title.into(),
            tool,
            surface: None,
            steps: Arc::default(),
            selected: 0,
            by: Travel::Joints,
            via: None,
            history: History::new(),
            saved: Arc::default(),
        }
    }

    /// Creates the program of a plan. Every step of the plan becomes part of a step here, and
    /// [`plan`](Self::plan) restores them.
    #[must_use]
    pub fn from_plan(plan: &Plan) -> Self {
        let mut steps: Vec<TeachStep> = Vec::new();
        for planned in &plan.steps {
            let name = plan.name_of(&planned.origin).unwrap_or_default();
            let last = steps.last_mut().filter(|step| step.name == name);
            if !last.is_some_and(|step| step.absorb(&planned.action)) {
                steps.push(TeachStep::of(&planned.action, name));
            }
        }
        let steps = Arc::new(steps);
        Self {
            surface: plan.surface,
            saved: Arc::clone(&steps),
            steps,
            ..Self::new(plan.title.clone(), plan.tool)
        }
    }

    /// Creates the program of steps that were taught elsewhere; unsaved.
    #[must_use]
    pub fn from_steps(
        title: impl Into<String>,
        tool: Option<Tool>,
        surface: Option<Surface>,
        steps: Vec<TeachStep>,
    ) -> Self {
        Self {
            surface,
            steps: Arc::new(steps),
            ..Self::new(title, tool)
        }
    }

    /// Steps of the program. The list is shared: until an edit, a clone is the same allocation, so
    /// it is cheap to show and to compare.
    #[must_use]
    pub const fn steps(&self) -> &Arc<Vec<TeachStep>> {
        &self.steps
    }

    /// Selected step, from 0; 0 if there are no steps.
    #[must_use]
    pub const fn selected(&self) -> usize {
        self.selected
    }

    /// Via point of the arc to the next point, if one was marked.
    #[must_use]
    pub const fn via(&self) -> Option<[f32; 4]> {
        self.via
    }

    /// Makes the next point the end of an arc through this pose.
    pub const fn arc_through(&mut self, pose: &Pose) {
        self.via = Some(place(pose));
    }

    /// Cancels the arc: the next point is reached by the usual motion.
    pub const fn cancel_arc(&mut self) {
        self.via = None;
    }

    /// Plan of the steps from `from` on, counted from 0.
    #[must_use]
    pub fn plan(&self, from: usize) -> Plan {
        let mut plan = Plan::new(self.title.clone());
        plan.tool = self.tool;
        plan.surface = self.surface;
        for step in self.steps.iter().skip(from) {
            let origin = if step.name.is_empty() {
                Origin::NONE
            } else {
                Origin::NONE.named(plan.name(step.name.clone()))
            };
            let planned = step.actions().map(|action| Step::new(action, origin));
            plan.steps.extend(planned);
        }
        plan
    }

    /// Step that a step of [`plan(from)`](Self::plan) belongs to, both counted from 0; `None`
    /// beyond the end.
    #[must_use]
    pub fn step_at(&self, from: usize, plan_step: usize) -> Option<usize> {
        let mut left = plan_step;
        for (nth, step) in self.steps.iter().enumerate().skip(from) {
            let planned = step.plan_steps();
            if left < planned {
                return Some(nth);
            }
            left -= planned;
        }
        None
    }

    /// Number of steps of the whole plan before this one.
    #[must_use]
    pub fn plan_steps_before(&self, step: usize) -> usize {
        let steps = self.steps.iter().take(step);
        steps.map(TeachStep::plan_steps).sum()
    }

    /// Number of steps of the plan that each step becomes, in one pass over the program.
    pub fn plan_steps(&self) -> impl Iterator<Item = usize> + '_ {
        self.steps.iter().map(TeachStep::plan_steps)
    }

    /// True if the step reaches the same place by the same path from anywhere. Always true for the
    /// first step, which has no predecessor.
    #[must_use]
    pub fn is_independent_of_start(&self, step: usize) -> bool {
        let motion = self.steps.get(step).and_then(|step| step.motion.as_ref());
        let absolute = matches!(
            motion,
            Some(Action::Move { .. } | Action::Joints { .. } | Action::Home)
        );
        step == 0 || absolute
    }

    /// True if the steps are as they were saved.
    #[must_use]
    pub fn is_saved(&self) -> bool {
        Arc::ptr_eq(&self.steps, &self.saved) || self.steps == self.saved
    }

    /// Marks the current steps as saved.
    pub fn mark_saved(&mut self) {
        self.saved = Arc::clone(&self.steps);
    }

    /// Marks the current steps as unsaved, wherever they came from.
    pub fn mark_unsaved(&mut self) {
        self.saved = Arc::default();
    }

    /// Adds the pose after the selected step and selects it; returns its name.
    pub fn store(&mut self, pose: &Pose) -> String {
        let to = place(pose);
        let motion = match self.via.take() {
            Some(via) => Action::Arc { via, to },
            None => Action::Move { to, by: self.by },
        };
        let name = self.fresh_name();
        self.change(|program| {
            let step = TeachStep {
                name: name.clone(),
                motion: Some(motion),
                ..TeachStep::default()
            };
            // Without steps the selection is 0, which is no step.
            let at = (program.selected + 1).min(program.steps.len());
            program.steps_mut().insert(at, step);
            program.selected = at;
        });
        name
    }

    /// True if the selected step leads to exactly this pose.
    #[must_use]
    pub fn is_at(&self, pose: &Pose) -> bool {
        let motion = self
            .steps
            .get(self.selected)
            .and_then(|step| step.motion.as_ref());
        match motion {
            Some(Action::Move { to, .. } | Action::Arc { to, .. }) => *to == place(pose),
            _ => false,
        }
    }

    /// Replaces the target of the selected step by the pose.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps, [`TeachError::NoTarget`] for a step without a target.
    pub fn reteach(&mut self, pose: &Pose) -> Result<(), TeachError> {
        self.edit(|step| {
            let here = place(pose);
            match &mut step.motion {
                Some(Action::Move { to, .. } | Action::Arc { to, .. }) => *to = here,
                Some(Action::Joints { to, .. }) => *to = pose.joint_angle,
                Some(Action::Path { to } | Action::Burn { to, .. }) => {
                    *to = [pose.x, pose.y, pose.z];
                }
                _ => return Err(TeachError::NoTarget),
            }
            Ok(())
        })
    }

    /// Changes the motion type of the selected step to the next one: joints, straight, jump and so
    /// on. Later steps get it too. Without steps only the type of later ones changes.
    ///
    /// # Errors
    /// [`TeachError::IsArc`] and [`TeachError::NotAMove`] for steps with a single motion type.
    pub fn next_travel(&mut self) -> Result<(), TeachError> {
        if self.steps.is_empty() {
            self.by = self.by.next();
            return Ok(());
        }
        let mut now = self.by;
        self.edit(|step| match &mut step.motion {
            Some(Action::Move { by, .. } | Action::Joints { by, .. }) => {
                *by = by.next();
                now = *by;
                Ok(())
            }
            Some(Action::Arc { .. }) => Err(TeachError::IsArc),
            _ => Err(TeachError::NotAMove),
        })?;
        self.by = now;
        Ok(())
    }

    /// Sets the motion type of points added from now on.
    pub const fn reach_by(&mut self, by: Travel) {
        self.by = by;
    }

    /// Names the selected step; surrounding space is removed.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn rename(&mut self, name: &str) -> Result<(), TeachError> {
        let name = name.trim().to_owned();
        self.edit(|step| {
            step.name = name;
            Ok(())
        })
    }

    /// Sets the pause at the selected step, ms; 0 for no pause.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn set_pause(&mut self, pause: u32) -> Result<(), TeachError> {
        self.edit(|step| {
            step.pause = pause;
            Ok(())
        })
    }

    /// Sets the action of gripper and suction cup at the selected step; `None` leaves a tool as it
    /// is.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn set_tools(
        &mut self,
        gripper: Option<Grip>,
        suction: Option<bool>,
    ) -> Result<(), TeachError> {
        self.edit(|step| {
            (step.gripper, step.suction) = (gripper, suction);
            Ok(())
        })
    }

    /// Cycles the action of the gripper at the selected step: unchanged, close, open, off.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn next_gripper(&mut self) -> Result<(), TeachError> {
        self.edit(|step| {
            step.gripper = match step.gripper {
                None => Some(Grip::Close),
                Some(Grip::Close) => Some(Grip::Open),
                Some(Grip::Open) => Some(Grip::Off),
                Some(Grip::Off) => None,
            };
            Ok(())
        })
    }

    /// Cycles the action of the suction cup at the selected step: unchanged, on, off.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn next_suction(&mut self) -> Result<(), TeachError> {
        self.edit(|step| {
            step.suction = match step.suction {
                None => Some(true),
                Some(true) => Some(false),
                Some(false) => None,
            };
            Ok(())
        })
    }

    /// Deletes the selected step and selects the next one, or the last.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn delete(&mut self) -> Result<(), TeachError> {
        if self.steps.is_empty() {
            return Err(TeachError::Empty);
        }
        self.change(|program| {
            let selected = program.selected;
            program.steps_mut().remove(selected);
            program.selected = program.selected.min(program.steps.len().saturating_sub(1));
        });
        Ok(())
    }

    /// Moves the selected step one place towards the end or the beginning.
    pub fn shift(&mut self, down: bool) {
        let other = if down {
            self.selected + 1
        } else {
            self.selected.wrapping_sub(1)
        };
        if other < self.steps.len() {
            self.change(|program| {
                let selected = program.selected;
                program.steps_mut().swap(selected, other);
                program.selected = other;
            });
        }
    }

    /// Selects a step, from 0; the last one if `step` is beyond the end.
    pub fn select_at(&mut self, step: usize) {
        self.selected = step.min(self.steps.len().saturating_sub(1));
    }

    /// Selects the next or the previous step.
    pub fn select(&mut self, down: bool) {
        let other = if down {
            self.selected + 1
        } else {
            self.selected.saturating_sub(1)
        };
        self.selected = other.min(self.steps.len().saturating_sub(1));
    }

    /// Undoes the last edit; true if there was one. Up to 500 can be undone.
    pub fn undo(&mut self) -> bool {
        let before = self.history.undo(self.snapshot());
        self.restore(before)
    }

    /// Redoes the edit undone last; true if there was one.
    pub fn redo(&mut self) -> bool {
        let after = self.history.redo(self.snapshot());
        self.restore(after)
    }

    fn edit(
        &mut self,
        edit: impl FnOnce(&mut TeachStep) -> Result<(), TeachError>,
    ) -> Result<(), TeachError> {
        let mut step = self
            .steps
            .get(self.selected)
            .cloned()
            .ok_or(TeachError::Empty)?;
        edit(&mut step)?;
        self.change(|program| {
            let selected = program.selected;
            if let Some(known) = program.steps_mut().get_mut(selected) {
                *known = step;
            }
        });
        Ok(())
    }

    fn change(&mut self, change: impl FnOnce(&mut Self)) {
        let before = self.snapshot();
        change(self);
        // An edit without effect needs no undo.
        if before.steps != self.steps {
            self.history.edited(before);
        }
    }

    fn steps_mut(&mut self) -> &mut Vec<TeachStep> {
        Arc::make_mut(&mut self.steps)
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            steps: Arc::clone(&self.steps),
            selected: self.selected,
        }
    }

    fn restore(&mut self, snapshot: Option<Snapshot>) -> bool {
        let Some(Snapshot { steps, selected }) = snapshot else {
            return false;
        };
        self.steps = steps;
        self.selected = selected;
        true
    }

    /// Returns a name that no step has.
    fn fresh_name(&self) -> String {
        let taken = |name: &str| self.steps.iter().any(|step| step.name == name);
        let mut names = (self.steps.len() + 1..).map(|number| format!("P{number}"));
        names.find(|name| !taken(name)).unwrap_or_default()
    }
}

const fn place(pose: &Pose) -> [f32; 4] {
    [pose.x, pose.y, pose.z, pose.r]
}

#[cfg(test)]
mod tests;
