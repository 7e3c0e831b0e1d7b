//! Random edits of a program against a simple reference, and undo back to the beginning.

use std::sync::Arc;

use magician::commands::Pose;
use magician_job::teach::{ProgramModel, TeachError, TeachStep};
use magician_program::{Action, Grip, Travel};
use proptest::collection::vec;
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Edit {
    Store(u8),
    ArcThrough(u8),
    CancelArc,
    Reteach(u8),
    NextTravel,
    Rename(&'static str),
    SetPause(u32),
    NextGripper,
    NextSuction,
    Delete,
    Shift(bool),
    Select(bool),
    SelectAt(usize),
    Undo,
    Redo,
    MarkSaved,
}

fn edit() -> impl Strategy<Value = Edit> {
    prop_oneof![
        4 => any::<u8>().prop_map(Edit::Store),
        1 => any::<u8>().prop_map(Edit::ArcThrough),
        1 => Just(Edit::CancelArc),
        1 => any::<u8>().prop_map(Edit::Reteach),
        1 => Just(Edit::NextTravel),
        1 => prop_oneof![Just("pick"), Just(" place "), Just("P2"), Just("")].prop_map(Edit::Rename),
        1 => prop_oneof![Just(0), Just(500), Just(u32::MAX)].prop_map(Edit::SetPause),
        1 => Just(Edit::NextGripper),
        1 => Just(Edit::NextSuction),
        1 => Just(Edit::Delete),
        1 => any::<bool>().prop_map(Edit::Shift),
        2 => any::<bool>().prop_map(Edit::Select),
        1 => (0_usize..8).prop_map(Edit::SelectAt),
        3 => Just(Edit::Undo),
        2 => Just(Edit::Redo),
        1 => Just(Edit::MarkSaved),
    ]
}

fn pose(x: u8) -> Pose {
    let x = f32::from(x);
    Pose {
        x,
        y: 1.0,
        z: 2.0,
        r: 3.0,
        joint_angle: [x, 4.0, 5.0, 6.0],
    }
}

fn target(x: u8) -> [f32; 4] {
    [f32::from(x), 1.0, 2.0, 3.0]
}

/// Reference model with complete copies as its history.
#[derive(Debug, Default)]
struct Reference {
    steps: Vec<TeachStep>,
    selected: usize,
    travel: Option<Travel>,
    via: Option<[f32; 4]>,
    past: Vec<(Vec<TeachStep>, usize)>,
    future: Vec<(Vec<TeachStep>, usize)>,
    saved: Vec<TeachStep>,
}

impl Reference {
    fn travel(&self) -> Travel {
        self.travel.unwrap_or(Travel::Joints)
    }

    fn step(&mut self) -> Option<&mut TeachStep> {
        self.steps.get_mut(self.selected)
    }

    fn store(&mut self, x: u8) {
        let (to, by) = (target(x), self.travel());
        let motion = match self.via.take() {
            Some(via) => Action::Arc { via, to },
            None => Action::Move { to, by },
        };
        let mut number = self.steps.len() + 1;
        while self
            .steps
            .iter()
            .any(|step| step.name == format!("P{number}"))
        {
            number += 1;
        }
        let step = TeachStep {
            name: format!("P{number}"),
            motion: Some(motion),
            ..TeachStep::default()
        };
        let at = self.steps.len().min(self.selected + 1);
        self.steps.insert(at, step);
        self.selected = at;
    }

    fn next_travel(&mut self) {
        let next = |by| match by {
            Travel::Joints => Travel::Line,
            Travel::Line => Travel::Jump,
            Travel::Jump => Travel::Joints,
        };
        let default = self.travel();
        let changed = match self.step() {
            None => Some(next(default)),
            Some(step) => match &mut step.motion {
                Some(Action::Move { by, .. }) => {
                    *by = next(*by);
                    Some(*by)
                }
                _ => None,
            },
        };
        self.travel = changed.or(self.travel);
    }

    fn shift(&mut self, down: bool) {
        let other = if down {
            Some(self.selected + 1)
        } else {
            self.selected.checked_sub(1)
        };
        if let Some(other) = other.filter(|other| *other < self.steps.len()) {
            self.steps.swap(self.selected, other);
            self.selected = other;
        }
    }

    fn undo_or_redo(&mut self, back: bool) -> bool {
        let (from, to) = if back {
            (&mut self.past, &mut self.future)
        } else {
            (&mut self.future, &mut self.past)
        };
        let Some((steps, selected)) = from.pop() else {
            return false;
        };
        to.push((std::mem::replace(&mut self.steps, steps), self.selected));
        self.selected = selected;
        true
    }

    fn apply(&mut self, edit: &Edit) {
        let before = (self.steps.clone(), self.selected);
        match *edit {
            Edit::Undo | Edit::Redo => {
                self.undo_or_redo(matches!(edit, Edit::Undo));
                return;
            }
            Edit::Store(x) => self.store(x),
            Edit::ArcThrough(x) => self.via = Some(target(x)),
            Edit::CancelArc => self.via = None,
            Edit::Reteach(x) => {
                let motion = self.step().and_then(|step| step.motion.as_mut());
                if let Some(Action::Move { to, .. } | Action::Arc { to, .. }) = motion {
                    *to = target(x);
                }
            }
            Edit::NextTravel => self.next_travel(),
            Edit::Rename(name) => {
                if let Some(step) = self.step() {
                    step.name = name.trim().to_owned();
                }
            }
            Edit::SetPause(pause) => {
                if let Some(step) = self.step() {
                    step.pause = pause;
                }
            }
            Edit::NextGripper => {
                if let Some(step) = self.step() {
                    let order = [None, Some(Grip::Close), Some(Grip::Open), Some(Grip::Off)];
                    let index = order.iter().position(|grip| *grip == step.gripper);
                    step.gripper = order[(index.expect("one of them") + 1) % 4];
                }
            }
            Edit::NextSuction => {
                if let Some(step) = self.step() {
                    let order = [None, Some(true), Some(false)];
                    let index = order.iter().position(|on| *on == step.suction);
                    step.suction = order[(index.expect("one of them") + 1) % 3];
                }
            }
            Edit::Delete => {
                if self.selected < self.steps.len() {
                    self.steps.remove(self.selected);
                    self.selected = self.selected.min(self.steps.len().saturating_sub(1));
                }
            }
            Edit::Shift(down) => self.shift(down),
            Edit::Select(down) => {
                let other = if down {
                    self.selected + 1
                } else {
                    self.selected.saturating_sub(1)
                };
                self.selected = other.min(self.steps.len().saturating_sub(1));
            }
            Edit::SelectAt(at) => self.selected = at.min(self.steps.len().saturating_sub(1)),
            Edit::MarkSaved => self.saved = self.steps.clone(),
        }
        if self.steps != before.0 {
            self.past.push(before);
            self.future.clear();
        }
    }
}

/// Applies an edit. A refused edit leaves the steps unchanged.
fn apply(program: &mut ProgramModel, edit: &Edit) -> Result<(), TeachError> {
    match *edit {
        Edit::Reteach(x) => return program.reteach(&pose(x)),
        Edit::NextTravel => return program.next_travel(),
        Edit::Rename(name) => return program.rename(name),
        Edit::SetPause(pause) => return program.set_pause(pause),
        Edit::NextGripper => return program.next_gripper(),
        Edit::NextSuction => return program.next_suction(),
        Edit::Delete => return program.delete(),
        Edit::Store(x) => drop(program.store(&pose(x))),
        Edit::ArcThrough(x) => program.arc_through(&pose(x)),
        Edit::CancelArc => program.cancel_arc(),
        Edit::Shift(down) => program.shift(down),
        Edit::Select(down) => program.select(down),
        Edit::SelectAt(at) => program.select_at(at),
        Edit::Undo => {
            program.undo();
        }
        Edit::Redo => {
            program.redo();
        }
        Edit::MarkSaved => program.mark_saved(),
    }
    Ok(())
}

fn assert_same_state(program: &ProgramModel, reference: &Reference) -> Result<(), TestCaseError> {
    prop_assert_eq!(&**program.steps(), &reference.steps);
    prop_assert_eq!(program.selected(), reference.selected);
    prop_assert_eq!(program.via(), reference.via);
    prop_assert_eq!(program.is_saved(), reference.steps == reference.saved);
    Ok(())
}

proptest! {
    #[test]
    fn edits_match_a_reference_with_full_copies(edits in vec(edit(), 0..200)) {
        let mut program = ProgramModel::new("a program", None);
        let mut reference = Reference::default();
        for edit in &edits {
            let before = program.steps().clone();
            if apply(&mut program, edit).is_err() {
                prop_assert!(Arc::ptr_eq(&before, program.steps()));
            }
            reference.apply(edit);
            assert_same_state(&program, &reference)?;
            // Each step of the plan belongs to one taught step, in the same order.
            let plan = program.plan(0);
            let taught_steps = (0..=plan.steps.len()).map(|nth| program.step_at(0, nth));
            let taught_steps: Vec<_> = taught_steps.flatten().collect();
            prop_assert_eq!(taught_steps.len(), plan.steps.len());
            prop_assert!(taught_steps.is_sorted());
        }
        // Undo to the beginning, then redo to the last state.
        for back in [true, false] {
            loop {
                let moved = if back { program.undo() } else { program.redo() };
                prop_assert_eq!(moved, reference.undo_or_redo(back));
                assert_same_state(&program, &reference)?;
                if !moved {
                    break;
                }
            }
            prop_assert!(!back || program.steps().is_empty());
        }
    }
}

#[test]
fn five_hundred_edits_can_be_undone() {
    let mut program = ProgramModel::new("a program", None);
    (0..=255).for_each(|x| drop(program.store(&pose(x))));
    (0..=255).for_each(|x| drop(program.store(&pose(x))));
    let mut undone = 0;
    while program.undo() {
        undone += 1;
    }
    assert_eq!((undone, program.steps().len()), (500, 12));
}
