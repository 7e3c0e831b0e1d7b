//! What has been taught: rows, each a way to a place and what is done there, with everything that can be undone.

use std::sync::Arc;

use magician::commands::Pose;
use magician_program::{Action, Grip, Origin, Plan, Step, Surface, Tool, Travel};

use super::TeachError;

/// As many changes can be undone.
const UNDO: usize = 500;

/// A row of the list: where the arm goes, what its tool does there, how long it stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// What it is called; empty if it has no name.
    pub name: String,
    /// A move as a rule; also anything else that a file may have, which is kept as it is. `None`: where the row before ends.
    pub motion: Option<Action>,
    /// What the gripper does there; nothing new without.
    pub gripper: Option<Grip>,
    /// Whether the suction cup goes on or off there; nothing new without.
    pub suction: Option<bool>,
    /// How long it stays there, ms.
    pub pause: u32,
}

impl Row {
    /// What is done for it, in order.
    fn actions(&self) -> impl Iterator<Item = Action> + '_ {
        let pause = (self.pause > 0).then_some(Action::Wait(self.pause));
        let motion = self.motion.clone();
        motion
            .into_iter()
            .chain(self.gripper.map(Action::Gripper))
            .chain(self.suction.map(Action::Suction))
            .chain(pause)
    }

    /// Takes a step of a plan as a part of this row, if it can be one.
    fn takes(&mut self, action: &Action) -> bool {
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

    /// A row that begins with this step.
    fn of(action: &Action, name: &str) -> Self {
        let mut row = Self {
            name: name.to_owned(),
            ..Self::default()
        };
        if !row.takes(action) {
            row.motion = Some(action.clone());
        }
        row
    }
}

/// What a change can be taken back to.
#[derive(Clone, Debug, PartialEq)]
struct Snapshot {
    rows: Arc<Vec<Row>>,
    selected: usize,
}

/// A program that is being taught.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// What it is called.
    pub title: String,
    /// The tool whose tip is at the points.
    pub tool: Option<Tool>,
    surface: Option<Surface>,
    /// Shared with what it can be taken back to and with what is shown: many rows cost no more than few.
    rows: Arc<Vec<Row>>,
    /// The row that is chosen; 0 if there is none.
    selected: usize,
    /// How new points are reached.
    by: Travel,
    /// The point that the arc to the next one goes through.
    via: Option<[f32; 4]>,
    undo: Vec<Snapshot>,
    redo: Vec<Snapshot>,
    saved: Arc<Vec<Row>>,
}

impl Lesson {
    /// Nothing is taught yet.
    #[must_use]
    pub fn new(title: impl Into<String>, tool: Option<Tool>) -> Self {
        Self {
            title: title.into(),
            tool,
            surface: None,
            rows: Arc::default(),
            selected: 0,
            by: Travel::Joints,
            via: None,
            undo: Vec::new(),
            redo: Vec::new(),
            saved: Arc::default(),
        }
    }

    /// What a plan teaches. Every step of it is in a row.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let mut rows: Vec<Row> = Vec::new();
        for step in &plan.steps {
            let name = plan.name_of(&step.origin).unwrap_or_default();
            let last = rows.last_mut().filter(|row| row.name == name);
            if !last.is_some_and(|row| row.takes(&step.action)) {
                rows.push(Row::of(&step.action, name));
            }
        }
        let rows = Arc::new(rows);
        Self {
            surface: plan.surface,
            saved: Arc::clone(&rows),
            rows,
            ..Self::new(plan.title.clone(), plan.tool)
        }
    }

    /// What has been taught, row by row. It is shared: as long as nothing changes a clone is the same allocation, so that many rows
    /// cost no more than few to show and to compare.
    #[must_use]
    pub const fn rows(&self) -> &Arc<Vec<Row>> {
        &self.rows
    }

    /// The row that is chosen, from 0; 0 if there is none.
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

    /// The plan from a row on.
    #[must_use]
    pub fn plan(&self, from: usize) -> Plan {
        let mut plan = Plan::new(self.title.clone());
        plan.tool = self.tool;
        plan.surface = self.surface;
        for row in self.rows.iter().skip(from) {
            let origin = match row.name.is_empty() {
                true => Origin::NONE,
                false => Origin::NONE.named(plan.name(row.name.clone())),
            };
            let steps = row.actions().map(|action| Step::new(action, origin));
            plan.steps.extend(steps);
        }
        plan
    }

    /// The row that so many steps of the plan from a row on belong to, from 0.
    #[must_use]
    pub fn row_of(&self, from: usize, step: usize) -> Option<usize> {
        let mut left = step;
        for (nth, row) in self.rows.iter().enumerate().skip(from) {
            let steps = row.actions().count();
            if left < steps {
                return Some(nth);
            }
            left -= steps;
        }
        None
    }

    /// Steps of the plan that come before a row.
    #[must_use]
    pub fn steps_before(&self, row: usize) -> usize {
        let rows = self.rows.iter().take(row);
        rows.map(|row| row.actions().count()).sum()
    }

    /// Whether a row leads to the same place wherever the arm is, and by a way that does not depend on what was before. The
    /// first one has nothing before it.
    #[must_use]
    pub fn leads_from_anywhere(&self, row: usize) -> bool {
        let motion = self.rows.get(row).and_then(|row| row.motion.as_ref());
        let absolute = matches!(
            motion,
            Some(Action::Move { .. } | Action::Joints { .. } | Action::Home)
        );
        row == 0 || absolute
    }

    /// Whether the rows are as they were saved.
    #[must_use]
    pub fn is_saved(&self) -> bool {
        Arc::ptr_eq(&self.rows, &self.saved) || self.rows == self.saved
    }

    /// The rows as they are have been saved.
    pub fn mark_saved(&mut self) {
        self.saved = Arc::clone(&self.rows);
    }

    /// The rows as they are have not been saved, wherever they came from.
    pub fn mark_unsaved(&mut self) {
        self.saved = Arc::default();
    }

    /// Adds where the arm is, after the row that is chosen, and chooses it; the name that it got.
    pub fn store(&mut self, pose: &Pose) -> String {
        let to = place(pose);
        let motion = match self.via.take() {
            Some(via) => Action::Arc { via, to },
            None => Action::Move { to, by: self.by },
        };
        let name = self.fresh_name();
        self.change(|lesson| {
            let row = Row {
                name: name.clone(),
                motion: Some(motion),
                ..Row::default()
            };
            let at = (lesson.selected + 1).min(lesson.rows.len());
            lesson.rows_mut().insert(at, row);
            lesson.selected = at;
        });
        name
    }

    /// Whether the row that is chosen leads to this very place.
    #[must_use]
    pub fn is_at(&self, pose: &Pose) -> bool {
        let motion = self
            .rows
            .get(self.selected)
            .and_then(|row| row.motion.as_ref());
        match motion {
            Some(Action::Move { to, .. } | Action::Arc { to, .. }) => *to == place(pose),
            _ => false,
        }
    }

    /// Lets the row that is chosen lead to where the arm is.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows, [`TeachError::NoPlace`] for one that does not lead to a place.
    pub fn teach_again(&mut self, pose: &Pose) -> Result<(), TeachError> {
        self.edit(|row| {
            let here = place(pose);
            match &mut row.motion {
                Some(Action::Move { to, .. } | Action::Arc { to, .. }) => *to = here,
                Some(Action::Joints { to, .. }) => *to = pose.joint_angle,
                Some(Action::Path { to } | Action::Burn { to, .. }) => {
                    *to = [pose.x, pose.y, pose.z];
                }
                _ => return Err(TeachError::NoPlace),
            }
            Ok(())
        })
    }

    /// Lets the row that is chosen go another way: with the joints, straight, as a jump. Without rows: the next one.
    ///
    /// # Errors
    /// [`TeachError::Arc`] and [`TeachError::NoMove`] for rows that have one way only.
    pub fn next_way(&mut self) -> Result<(), TeachError> {
        let turned = |by| match by {
            Travel::Joints => Travel::Line,
            Travel::Line => Travel::Jump,
            Travel::Jump => Travel::Joints,
        };
        if self.rows.is_empty() {
            self.by = turned(self.by);
            return Ok(());
        }
        let mut now = self.by;
        self.edit(|row| match &mut row.motion {
            Some(Action::Move { by, .. } | Action::Joints { by, .. }) => {
                *by = turned(*by);
                now = *by;
                Ok(())
            }
            Some(Action::Arc { .. }) => Err(TeachError::Arc),
            _ => Err(TeachError::NoMove),
        })?;
        self.by = now;
        Ok(())
    }

    /// Names the row that is chosen; space around the name is not of it.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows.
    pub fn rename(&mut self, name: &str) -> Result<(), TeachError> {
        let name = name.trim().to_owned();
        self.edit(|row| {
            row.name = name;
            Ok(())
        })
    }

    /// Sets how long the arm stays at the row that is chosen, ms; 0 for no pause.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows.
    pub fn set_pause(&mut self, pause: u32) -> Result<(), TeachError> {
        self.edit(|row| {
            row.pause = pause;
            Ok(())
        })
    }

    /// Turns on what the gripper does at the row that is chosen: nothing new, close, open, off.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows.
    pub fn next_grip(&mut self) -> Result<(), TeachError> {
        self.edit(|row| {
            row.gripper = match row.gripper {
                None => Some(Grip::Close),
                Some(Grip::Close) => Some(Grip::Open),
                Some(Grip::Open) => Some(Grip::Off),
                Some(Grip::Off) => None,
            };
            Ok(())
        })
    }

    /// Turns on what the suction cup does at the row that is chosen: nothing new, on, off.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows.
    pub fn next_suction(&mut self) -> Result<(), TeachError> {
        self.edit(|row| {
            row.suction = match row.suction {
                None => Some(true),
                Some(true) => Some(false),
                Some(false) => None,
            };
            Ok(())
        })
    }

    /// Deletes the row that is chosen, and chooses the next one, or the last.
    ///
    /// # Errors
    /// [`TeachError::Empty`] without rows.
    pub fn delete(&mut self) -> Result<(), TeachError> {
        if self.rows.is_empty() {
            return Err(TeachError::Empty);
        }
        self.change(|lesson| {
            let selected = lesson.selected;
            lesson.rows_mut().remove(selected);
            lesson.selected = lesson.selected.min(lesson.rows.len().saturating_sub(1));
        });
        Ok(())
    }

    /// Moves the row that is chosen towards the end, or the beginning.
    pub fn shift(&mut self, down: bool) {
        let other = match down {
            true => self.selected + 1,
            false => self.selected.wrapping_sub(1),
        };
        if other < self.rows.len() {
            self.change(|lesson| {
                let selected = lesson.selected;
                lesson.rows_mut().swap(selected, other);
                lesson.selected = other;
            });
        }
    }

    /// Chooses the next row, or the one before.
    pub fn select(&mut self, down: bool) {
        let other = match down {
            true => self.selected + 1,
            false => self.selected.saturating_sub(1),
        };
        self.selected = other.min(self.rows.len().saturating_sub(1));
    }

    /// Takes the last change back; whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(before) = self.undo.pop() else {
            return false;
        };
        let now = self.snapshot();
        self.redo.push(now);
        self.restore(before);
        true
    }

    /// Makes the last change anew that was taken back; whether there was one.
    pub fn redo(&mut self) -> bool {
        let Some(after) = self.redo.pop() else {
            return false;
        };
        let now = self.snapshot();
        self.undo.push(now);
        self.restore(after);
        true
    }

    fn edit(
        &mut self,
        edit: impl FnOnce(&mut Row) -> Result<(), TeachError>,
    ) -> Result<(), TeachError> {
        let mut row = self
            .rows
            .get(self.selected)
            .cloned()
            .ok_or(TeachError::Empty)?;
        edit(&mut row)?;
        self.change(|lesson| {
            let selected = lesson.selected;
            if let Some(known) = lesson.rows_mut().get_mut(selected) {
                *known = row;
            }
        });
        Ok(())
    }

    fn change(&mut self, change: impl FnOnce(&mut Self)) {
        let before = self.snapshot();
        change(self);
        if before.rows == self.rows {
            return;
        }
        if self.undo.len() == UNDO {
            self.undo.remove(0);
        }
        self.undo.push(before);
        self.redo.clear();
    }

    fn rows_mut(&mut self) -> &mut Vec<Row> {
        Arc::make_mut(&mut self.rows)
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            rows: Arc::clone(&self.rows),
            selected: self.selected,
        }
    }

    fn restore(&mut self, Snapshot { rows, selected }: Snapshot) {
        self.rows = rows;
        self.selected = selected;
    }

    /// A name that no row has.
    fn fresh_name(&self) -> String {
        let taken = |name: &str| self.rows.iter().any(|row| row.name == name);
        let mut names = (self.rows.len() + 1..).map(|number| format!("P{number}"));
        names.find(|name| !taken(name)).unwrap_or_default()
    }
}

const fn place(pose: &Pose) -> [f32; 4] {
    [pose.x, pose.y, pose.z, pose.r]
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_program::formats::playback::Playback;

    fn pose(x: f32) -> Pose {
        Pose {
            x,
            y: 1.0,
            z: 2.0,
            r: 3.0,
            joint_angle: [x, 0.0, 0.0, 0.0],
        }
    }

    fn taught(xs: &[f32]) -> Lesson {
        let mut lesson = Lesson::new("lesson", Some(Tool::Suction));
        xs.iter().for_each(|x| drop(lesson.store(&pose(*x))));
        lesson
    }

    fn names(lesson: &Lesson) -> Vec<&str> {
        lesson.rows.iter().map(|row| row.name.as_str()).collect()
    }

    #[test]
    fn points_come_after_the_one_that_is_chosen() {
        let mut lesson = taught(&[200.0, 210.0]);
        lesson.select(false);
        lesson.store(&pose(205.0));
        assert_eq!(names(&lesson), ["P1", "P3", "P2"]);
        assert_eq!(lesson.selected, 1);
        assert!(lesson.is_at(&pose(205.0)) && !lesson.is_at(&pose(205.5)));
        lesson.shift(true);
        assert_eq!(
            (names(&lesson), lesson.selected),
            (vec!["P1", "P2", "P3"], 2)
        );
        lesson.shift(true);
        assert_eq!(lesson.selected, 2);
        lesson.delete().unwrap();
        lesson.delete().unwrap();
        lesson.delete().unwrap();
        assert!(lesson.delete().is_err() && lesson.rows.is_empty());
    }

    #[test]
    fn every_change_can_be_undone_and_made_anew() {
        let mut lesson = taught(&[200.0, 210.0]);
        let mut states = vec![lesson.rows.clone()];
        let changes: [fn(&mut Lesson); 8] = [
            |lesson| lesson.rename(" pick ").unwrap(),
            |lesson| lesson.set_pause(500).unwrap(),
            |lesson| lesson.next_suction().unwrap(),
            |lesson| lesson.next_grip().unwrap(),
            |lesson| lesson.next_way().unwrap(),
            |lesson| lesson.teach_again(&pose(250.0)).unwrap(),
            |lesson| lesson.shift(false),
            |lesson| lesson.delete().unwrap(),
        ];
        for change in changes {
            change(&mut lesson);
            states.push(lesson.rows.clone());
        }
        for state in states.iter().rev().skip(1) {
            assert!(lesson.undo());
            assert_eq!(lesson.rows, *state);
        }
        for state in &states[1..] {
            assert!(lesson.redo());
            assert_eq!(lesson.rows, *state);
        }
        assert!(!lesson.redo());
        lesson.undo();
        lesson.store(&pose(1.0));
        assert!(!lesson.redo(), "another change ends that");
    }

    #[test]
    fn an_arc_takes_two_points_and_stays_one() {
        let mut lesson = taught(&[200.0]);
        lesson.arc_through(&pose(220.0));
        lesson.store(&pose(240.0));
        let motion = lesson.rows[1].motion.clone();
        let (via, to) = (place(&pose(220.0)), place(&pose(240.0)));
        assert_eq!(motion, Some(Action::Arc { via, to }));
        assert!(lesson.next_way().is_err() && lesson.via.is_none());
    }

    #[test]
    fn what_only_leads_on_needs_what_comes_before() {
        let mut lesson = taught(&[200.0, 210.0]);
        lesson.next_suction().unwrap();
        lesson.arc_through(&pose(220.0));
        lesson.store(&pose(240.0));
        let from_anywhere = [0, 1, 2].map(|row| lesson.leads_from_anywhere(row));
        assert_eq!(from_anywhere, [true, true, false]);
        assert_eq!([0, 1, 2].map(|row| lesson.steps_before(row)), [0, 1, 3]);
    }

    #[test]
    fn a_plan_of_rows_gives_the_same_rows() {
        let mut lesson = taught(&[200.0, 210.0, 220.0]);
        lesson.next_suction().unwrap();
        lesson.set_pause(1250).unwrap();
        lesson.select(false);
        lesson.rename("").unwrap();
        lesson.next_way().unwrap();
        let plan = lesson.plan(0);
        assert_eq!(plan.steps.len(), 5);
        let again = Lesson::of(&plan);
        assert_eq!((&again.rows, again.tool), (&lesson.rows, lesson.tool));
        assert!(again.is_saved() && !lesson.is_saved());
        let rows = [0, 1, 2, 3, 4, 5].map(|step| lesson.row_of(0, step));
        assert_eq!(rows, [Some(0), Some(1), Some(2), Some(2), Some(2), None]);
        assert_eq!(
            (lesson.row_of(1, 0), lesson.plan(1).steps.len()),
            (Some(1), 4)
        );
    }

    #[test]
    fn what_a_file_says_otherwise_is_kept() {
        let mut plan = Plan::new("drawn");
        let steps = [
            Action::Wait(0),
            Action::Suction(true),
            Action::Gripper(Grip::Open),
            Action::Home,
            Action::Wait(5),
            Action::Wait(6),
            Action::Path {
                to: [200.0, 0.0, 0.0],
            },
        ];
        for step in steps {
            plan.push(step, Origin::NONE);
        }
        assert_eq!(Lesson::of(&plan).plan(0), plan);
    }

    #[test]
    fn a_playback_file_that_is_written_is_taught_as_it_was() {
        let mut lesson = taught(&[200.0, 210.0]);
        lesson.next_suction().unwrap();
        lesson.rename("pick").unwrap();
        let playback = Playback::from_plan(&lesson.plan(0)).unwrap();
        let read = Playback::read(playback.to_xml().as_bytes()).unwrap();
        let again = Lesson::of(&read.to_plan().content);
        assert_eq!(names(&again), ["P1", "pick"]);
        let suction: Vec<_> = again.rows.iter().map(|row| row.suction).collect();
        assert_eq!(suction, [Some(false), Some(true)]);
        assert_eq!(again.rows[1].motion, lesson.rows[1].motion);
    }
}
