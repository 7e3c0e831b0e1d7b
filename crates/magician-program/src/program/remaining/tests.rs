//! Tests of the rest of a program: commands, times and resume points.

use magician_host::{JointAngles, ToolBias, build};

use super::*;
use crate::{Action, Origin, Tool, Travel};

pub(in crate::program) fn start() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::NONE)
}

/// Out and back on a line, then a wait of a second.
pub(in crate::program) fn plan() -> Plan {
    let mut plan = Plan::new("out and back");
    for x in [240.0, 220.0] {
        let to = [x, 0.0, 60.0, 0.0];
        let by = Travel::Line;
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    plan.push(Action::Wait(1000), Origin::NONE);
    plan
}

pub(in crate::program) fn rest(iterations: Option<u64>, from: u64) -> RemainingProgram {
    let program = Program::new(plan(), iterations);
    program.remaining(from, start()).expect("within reach")
}

#[test]
fn all_iterations_are_sent_and_the_tool_is_set_once() {
    let mut plan = plan();
    plan.tool = Some(Tool::Pen);
    let ratio = build::speed(80.0, 80.0);
    let program = Program::new(plan, Some(3)).with_settings(vec![ratio]);
    let rest = program.remaining(0, start()).expect("within reach");
    assert_eq!((rest.lead(), rest.offset()), (2, 0));
    let sent: Vec<Set> = rest.commands().collect();
    assert_eq!(sent.len(), 2 + 3 * 3);
    assert_eq!(sent[0], ratio);
    assert_eq!(sent[1], build::tool(ToolBias::PEN));
    assert_eq!(sent[2..5], sent[8..11]);
    assert_eq!(rest.first_commands().count(), 2 + 3);
}

#[test]
fn remaining_setting_changes_are_listed() {
    let (slow, fast) = (build::speed(10.0, 10.0), build::speed(90.0, 90.0));
    let mut plan = plan();
    plan.push(slow, Origin::NONE);
    plan.push(Action::Wait(1), Origin::NONE);
    let changes = |iterations, from, settings| -> Vec<Set> {
        let program = Program::new(plan.clone(), iterations).with_settings(settings);
        let rest = program.remaining(from, start()).expect("within reach");
        rest.changes().copied().collect()
    };
    assert_eq!(changes(Some(1), 0, vec![fast]), [fast, slow]);
    // A later start sends the earlier settings first.
    assert_eq!(changes(Some(1), 4, vec![]), [slow]);
    assert_eq!(changes(None, 0, vec![]), [slow, slow]);
}

#[test]
fn arm_back_at_its_start_counts_as_moved() {
    let began = start().arm().expect("it stands").pose;
    let mut plan = Plan::new("out, and back");
    let [x, y, z, r] = [began.x, began.y, began.z, began.r].map(|value| value as f32);
    for to in [[x + 20.0, y, z, r], [x, y, z, r]] {
        let by = Travel::Line;
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    let setting = vec![build::speed(10.0, 10.0)];
    let program = Program::new(plan, Some(1)).with_settings(setting);
    let rest = program.remaining(0, start()).expect("within reach");
    let joint_angle = JointAngles::HOME.to_array().map(|angle| angle as f32);
    let pose = Pose {
        x,
        y,
        z,
        r,
        joint_angle,
    };
    let mut counter = StepCounter::new(rest.lead(), false);
    assert!(!rest.has_moved(&counter, 40, &pose));
    // The setting has index 40.
    counter.note(3, 42);
    let moved = [39, 40, 41, 42].map(|index| rest.has_moved(&counter, index, &pose));
    assert_eq!(moved, [false, false, true, true]);
    let mut away = pose;
    away.joint_angle[1] += 0.1;
    assert!(rest.has_moved(&counter, 39, &away));
}

#[test]
fn remainder_is_the_lead_in_and_the_following_steps() {
    let rest = rest(Some(2), 1);
    let lead = rest.lead();
    assert!(lead > 0);
    assert_eq!(rest.offset(), 1 - lead as i64);
    assert_eq!(rest.commands().count() as u64, lead + 2 + 3);
    let rest = super::tests::rest(Some(2), 4);
    assert_eq!(rest.commands().count() as u64, rest.lead() + 2);
    let error = Program::new(plan(), Some(2)).remaining(6, start());
    assert!(error.is_err());
    let forever = super::tests::rest(None, 300);
    assert_eq!(forever.commands().take(1000).count(), 1000);
}

#[test]
fn pen_that_stays_down_ends_with_its_last_line() {
    let mut plan = plan();
    plan.tool = Some(Tool::Pen);
    let up = |z| Action::Move {
        to: [220.0, 0.0, z, 0.0],
        by: Travel::Line,
    };
    plan.push(up(40.0), Origin::NONE);
    plan.push(up(60.0), Origin::NONE);
    for (iterations, from) in [(1, 0), (1, 2), (3, 0), (3, 11)] {
        let program = Program::new(plan.clone(), Some(iterations));
        let down = program.clone().pen_stays_down(true);
        assert_eq!(down.key(), program.key());
        assert_eq!(down.steps(), program.steps().map(|steps| steps - 1));
        let [all, less] = [program, down].map(|program| {
            let rest = program.remaining(from, start()).expect("within reach");
            rest.commands().collect::<Vec<Set>>()
        });
        assert_eq!(all.split_last().map(|(_, rest)| rest), Some(&less[..]));
    }
    let endless = Program::new(plan, None).pen_stays_down(true);
    let rest = endless.remaining(0, start()).expect("within reach");
    assert_eq!(rest.commands().take(1000).count(), 1000);
    // A program that does not end with a lift is unchanged.
    let program = Program::new(super::tests::plan(), Some(1)).pen_stays_down(true);
    assert_eq!(program.steps(), Some(3));
}

#[test]
fn remaining_time_decreases_to_zero() {
    for (iterations, from) in [(1, 0), (3, 0), (3, 1), (3, 5), (2, 3)] {
        let rest = rest(Some(iterations), from);
        let report = rest.check();
        let table = rest.timetable(&report);
        let steps = 3 * iterations - from;
        let left: Vec<f64> = (0..=steps)
            .map(|done| table.left(done).expect("known").as_secs_f64())
            .collect();
        let all = report.time.unwrap().as_secs_f64();
        assert!(left[0] <= all && left[0] > 0.0, "{iterations} {from}");
        assert!(left.windows(2).all(|pair| pair[0] > pair[1]), "{left:?}");
        assert!(left[steps as usize] < 1e-6, "{left:?}");
        // The wait is the last step of every iteration.
        let last = left[steps as usize - 1] - left[steps as usize];
        assert!((last - 1.0).abs() < 1e-3, "{left:?}");
        assert_eq!(table.left(steps + 10), Some(Duration::ZERO));
    }
    let forever = rest(None, 0);
    assert_eq!(forever.timetable(&forever.check()).left(1), None);
}

#[test]
fn remaining_time_follows_slower_commands() {
    for (iterations, from) in [(1, 0), (3, 4)] {
        let rest = rest(Some(iterations), from);
        let table = rest.timetable(&rest.check());
        let same = run_to_end(rest.timetable_with(&table, &[], |command| command, &NeverYield));
        let slow = build::speed(5.0, 50.0);
        let slower =
            run_to_end(rest.timetable_with(&table, &[slow], |command| command, &NeverYield));
        for done in 0..=3 * iterations - from {
            let left = |table: &Timetable| table.left(done).expect("known").as_secs_f64();
            assert!((left(&same) - left(&table)).abs() < 1e-6, "{done}");
            let moves = done + 1 < 3 * iterations - from;
            assert_eq!(left(&slower) > left(&same) + 0.5, moves, "{done}");
        }
    }
    let forever = rest(None, 0);
    let table = forever.timetable(&forever.check());
    let table = run_to_end(forever.timetable_with(&table, &[], |command| command, &NeverYield));
    assert_eq!(table.left(1), None);
}

#[test]
fn resting_pose_identifies_the_finished_step() {
    let rest = rest(Some(2), 0);
    let at = |x: f32| Pose {
        x,
        y: 0.0,
        z: 60.0,
        r: 0.0,
        joint_angle: [0.0; 4],
    };
    assert_eq!(rest.stands_after(0, &at(240.0), true), None);
    assert_eq!(rest.stands_after(1, &at(240.0), true), Some(true));
    assert_eq!(rest.stands_after(1, &at(230.0), true), Some(false));
    assert_eq!(rest.stands_after(2, &at(220.15), true), Some(true));
    assert_eq!(rest.stands_after(2, &at(220.25), true), Some(false));
    assert_eq!(rest.stands_after(4, &at(240.0), true), Some(true));
    // A wait leaves the arm at its target when it is stopped.
    assert_eq!(rest.stands_after(3, &at(220.0), true), Some(false));
    assert_eq!(rest.stands_after(3, &at(220.0), false), Some(true));
}
