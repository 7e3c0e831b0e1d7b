//! A program that is being taught: its steps, and every edit of them, with undo and redo.

use std::sync::Arc;

use magician::commands::Pose;
use magician_program::{Action, Grip, Origin, Plan, Step, Surface, Tool, Travel};

use super::history::History;
use super::{TeachError, TeachStep};

/// What undo goes back to.
#[derive(Clone, Debug, PartialEq)]
struct Snapshot {
    steps: Arc<Vec<TeachStep>>,
    selected: usize,
}

/// A program that is being taught: steps that can be added, edited, moved and deleted, with undo and redo. Edits are of the selected
/// step.
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
    /// What it is called.
    pub title: String,
    /// The tool whose tip is at the points.
    pub tool: Option<Tool>,
    surface: Option<Surface>,
    /// Shared with the history and with what is shown: many steps cost no more than few.
    steps: Arc<Vec<TeachStep>>,
    /// The selected step; 0 if there is none.
    selected: usize,
    /// How new points are reached.
    by: Travel,
    /// The point that the arc to the next one goes through.
    via: Option<[f32; 4]>,
    history: History<Snapshot>,
    saved: Arc<Vec<TeachStep>>,
}

impl ProgramModel {
    /// Nothing is taught yet.
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

    /// The program of a plan: every step of the plan is in one of its steps, and [`plan`](Self::plan) gives them back.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let mut steps: Vec<TeachStep> = Vec::new();
        for planned in &plan.steps {
            let name = plan.name_of(&planned.origin).unwrap_or_default();
            let last = steps.last_mut().filter(|step| step.name == name);
            if !last.is_some_and(|step| step.takes(&planned.action)) {
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

    /// The program of steps that were taught elsewhere; unsaved.
    #[must_use]
    pub fn of_steps(
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

    /// Its steps. The list is shared: as long as nothing changes a clone is the same allocation, so that many steps
    /// cost no more than few to show and to compare.
    #[must_use]
    pub const fn steps(&self) -> &Arc<Vec<TeachStep>> {
        &self.steps
    }

    /// The selected step, from 0; 0 if there is none.
    #[must_use]
    pub const fn selected(&self) -> usize {
        self.selected
    }

    /// The point that the arc to the next one goes through, if one was marked.
    #[must_use]
    pub const fn via(&self) -> Option<[f32; 4]> {
        self.via
    }

    /// Lets the next point be the end of an arc through where the arm is.
    pub const fn arc_through(&mut self, pose: &Pose) {
        self.via = Some(place(pose));
    }

    /// Lets the next point be reached as ever.
    pub const fn cancel_arc(&mut self) {
        self.via = None;
    }

    /// The plan of the steps from this one on, counted from 0.
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

    /// The step that a step of [`plan(from)`](Self::plan) belongs to; both are counted from 0.
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

    /// How many steps of the whole plan come before this one.
    #[must_use]
    pub fn plan_steps_before(&self, step: usize) -> usize {
        let steps = self.steps.iter().take(step);
        steps.map(TeachStep::plan_steps).sum()
    }

    /// Number of steps of the plan that each step becomes, in one pass over the program.
    pub fn plan_steps(&self) -> impl Iterator<Item = usize> + '_ {
        self.steps.iter().map(TeachStep::plan_steps)
    }

    /// Whether a step leads to the same place wherever the arm is, and by a way that does not depend on what was before. The
    /// first one has nothing before it.
    #[must_use]
    pub fn leads_from_anywhere(&self, step: usize) -> bool {
        let motion = self.steps.get(step).and_then(|step| step.motion.as_ref());
        let absolute = matches!(
            motion,
            Some(Action::Move { .. } | Action::Joints { .. } | Action::Home)
        );
        step == 0 || absolute
    }

    /// Whether the steps are as they were saved.
    #[must_use]
    pub fn is_saved(&self) -> bool {
        Arc::ptr_eq(&self.steps, &self.saved) || self.steps == self.saved
    }

    /// The steps as they are have been saved.
    pub fn mark_saved(&mut self) {
        self.saved = Arc::clone(&self.steps);
    }

    /// The steps as they are have not been saved, wherever they came from.
    pub fn mark_unsaved(&mut self) {
        self.saved = Arc::default();
    }

    /// Adds where the arm is, after the selected step, and selects it; the name that it got.
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
            let at = (program.selected + 1).min(program.steps.len());
            program.steps_mut().insert(at, step);
            program.selected = at;
        });
        name
    }

    /// Whether the selected step leads to this very place.
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

    /// Lets the selected step lead to where the arm is.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps, [`TeachError::NoTarget`] for one that does not lead to a place.
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

    /// Changes how the selected step is reached: joint by joint, straight, as a jump, and so on. Steps that are added later are reached
    /// so, too; without steps that is all.
    ///
    /// # Errors
    /// [`TeachError::IsArc`] and [`TeachError::NotAMove`] for steps that have one way only.
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

    /// Lets points that are added from now on be reached so.
    pub const fn reach_by(&mut self, by: Travel) {
        self.by = by;
    }

    /// Names the selected step; space around the name is not of it.
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

    /// Sets how long the arm stays at the selected step, ms; 0 for no pause.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without steps.
    pub fn set_pause(&mut self, pause: u32) -> Result<(), TeachError> {
        self.edit(|step| {
            step.pause = pause;
            Ok(())
        })
    }

    /// Sets what gripper and suction cup do at the selected step; nothing new where it is `None`.
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

    /// Turns on what the gripper does at the selected step: nothing new, close, open, off.
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

    /// Turns on what the suction cup does at the selected step: nothing new, on, off.
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

    /// Deletes the selected step, and selects the next one, or the last.
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

    /// Moves the selected step towards the end, or the beginning.
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

    /// Selects a step, from 0; the last one if there are fewer.
    pub fn select_at(&mut self, step: usize) {
        self.selected = step.min(self.steps.len().saturating_sub(1));
    }

    /// Selects the next step, or the one before.
    pub fn select(&mut self, down: bool) {
        let other = if down {
            self.selected + 1
        } else {
            self.selected.saturating_sub(1)
        };
        self.selected = other.min(self.steps.len().saturating_sub(1));
    }

    /// Undoes the last edit; whether there was one. 500 can be undone.
    pub fn undo(&mut self) -> bool {
        let before = self.history.undo(self.snapshot());
        self.restore(before)
    }

    /// Redoes the edit that was undone last; whether there was one.
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

    /// A name that no step has.
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
