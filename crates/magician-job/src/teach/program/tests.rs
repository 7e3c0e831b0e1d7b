//! Edits of a program, and its plan.

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

fn taught(xs: &[f32]) -> ProgramModel {
    let mut program = ProgramModel::new("lesson", Some(Tool::Suction));
    xs.iter().for_each(|x| drop(program.store(&pose(*x))));
    program
}

fn names(program: &ProgramModel) -> Vec<&str> {
    program
        .steps
        .iter()
        .map(|step| step.name.as_str())
        .collect()
}

#[test]
fn new_point_is_inserted_after_the_selected_step() {
    let mut program = taught(&[200.0, 210.0]);
    program.select(false);
    program.store(&pose(205.0));
    assert_eq!(names(&program), ["P1", "P3", "P2"]);
    assert_eq!(program.selected, 1);
    assert!(program.is_at(&pose(205.0)) && !program.is_at(&pose(205.5)));
    program.shift(true);
    assert_eq!(
        (names(&program), program.selected),
        (vec!["P1", "P2", "P3"], 2)
    );
    program.shift(true);
    assert_eq!(program.selected, 2);
    program.delete().unwrap();
    program.delete().unwrap();
    program.delete().unwrap();
    assert!(program.delete().is_err() && program.steps.is_empty());
}

#[test]
fn each_edit_can_be_undone_and_redone() {
    let mut program = taught(&[200.0, 210.0]);
    let mut states = vec![program.steps.clone()];
    let changes: [fn(&mut ProgramModel); 10] = [
        |program| drop(program.store(&pose(230.0))),
        |program| {
            program.arc_through(&pose(240.0));
            program.store(&pose(245.0));
            program.select(false);
        },
        |program| program.rename(" pick ").unwrap(),
        |program| program.set_pause(500).unwrap(),
        |program| program.next_suction().unwrap(),
        |program| program.next_gripper().unwrap(),
        |program| program.next_travel().unwrap(),
        |program| program.reteach(&pose(250.0)).unwrap(),
        |program| program.shift(false),
        |program| program.delete().unwrap(),
    ];
    for change in changes {
        change(&mut program);
        states.push(program.steps.clone());
    }
    for state in states.iter().rev().skip(1) {
        assert!(program.undo());
        assert_eq!(program.steps, *state);
    }
    for state in &states[1..] {
        assert!(program.redo());
        assert_eq!(program.steps, *state);
    }
    assert!(!program.redo());
    program.undo();
    program.store(&pose(1.0));
    assert!(!program.redo(), "another change ends that");
}

#[test]
fn arc_takes_two_points_and_remains_an_arc() {
    let mut program = taught(&[200.0]);
    program.arc_through(&pose(220.0));
    program.store(&pose(240.0));
    let motion = program.steps[1].motion.clone();
    let (via, to) = (place(&pose(220.0)), place(&pose(240.0)));
    assert_eq!(motion, Some(Action::Arc { via, to }));
    assert!(program.next_travel().is_err() && program.via.is_none());
}

#[test]
fn arc_depends_on_the_preceding_step() {
    let mut program = taught(&[200.0, 210.0]);
    program.next_suction().unwrap();
    program.arc_through(&pose(220.0));
    program.store(&pose(240.0));
    let independent = [0, 1, 2].map(|step| program.is_independent_of_start(step));
    assert_eq!(independent, [true, true, false]);
    assert_eq!(
        [0, 1, 2].map(|step| program.plan_steps_before(step)),
        [0, 1, 3]
    );
}

#[test]
fn plan_of_steps_converts_back_to_the_same_steps() {
    let mut program = taught(&[200.0, 210.0, 220.0]);
    program.next_suction().unwrap();
    program.set_pause(1250).unwrap();
    program.select(false);
    program.rename("").unwrap();
    program.next_travel().unwrap();
    let plan = program.plan(0);
    assert_eq!(plan.steps.len(), 5);
    let converted = ProgramModel::from_plan(&plan);
    assert_eq!(
        (&converted.steps, converted.tool),
        (&program.steps, program.tool)
    );
    assert!(converted.is_saved() && !program.is_saved());
    let steps = [0, 1, 2, 3, 4, 5].map(|step| program.step_at(0, step));
    assert_eq!(steps, [Some(0), Some(1), Some(2), Some(2), Some(2), None]);
    assert_eq!(
        (program.step_at(1, 0), program.plan(1).steps.len()),
        (Some(1), 4)
    );
}

#[test]
fn other_content_of_a_file_is_preserved() {
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
    assert_eq!(ProgramModel::from_plan(&plan).plan(0), plan);
}

#[test]
fn playback_file_round_trips_through_the_model() {
    let mut program = taught(&[200.0, 210.0]);
    program.next_suction().unwrap();
    program.rename("pick").unwrap();
    let playback = Playback::from_plan(&program.plan(0)).unwrap();
    let read = Playback::read(playback.to_xml().as_bytes()).unwrap();
    let converted = ProgramModel::from_plan(&read.to_plan().content);
    assert_eq!(names(&converted), ["P1", "pick"]);
    let suction: Vec<_> = converted.steps.iter().map(|step| step.suction).collect();
    assert_eq!(suction, [Some(false), Some(true)]);
    assert_eq!(converted.steps[1].motion, program.steps[1].motion);
}
