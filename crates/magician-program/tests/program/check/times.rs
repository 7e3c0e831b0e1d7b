//! Durations of plans: as reported, and on the virtual arm.

use magician::Set;
use magician::build;
use magician::preflight::Preflight;
use magician_program::{Action, Origin, Plan, Tool, Travel, check};

use super::bench::LoneArm;

/// Error of the 32-bit poses that the arm reports, us.
const TIME_TOLERANCE_US: f64 = 10.0;

fn to(x: f64, y: f64, z: f64) -> [f32; 3] {
    [x, y, z].map(|value| value as f32)
}

fn travel(x: f64, y: f64, z: f64, by: Travel) -> Action {
    let [x, y, z] = to(x, y, z);
    Action::Move {
        to: [x, y, z, 0.0],
        by,
    }
}

fn plan(tool: Tool, actions: impl IntoIterator<Item = Action>) -> Plan {
    let mut plan = Plan::new("timed");
    plan.tool = Some(tool);
    for action in actions {
        plan.push(action, Origin::NONE);
    }
    plan
}

/// Strokes of a rose, each at another speed, lifted in between.
fn rose() -> Plan {
    let mut actions = vec![Action::from(build::line_speed(150.0, 150.0))];
    for petal in 0..6 {
        let speed = 20.0 + 40.0 * petal as f32;
        actions.push(Action::from(build::path_speed(speed, 100.0 + speed)));
        let angle = |step: i32| f64::from(petal) * 60.0 + f64::from(step) * 0.4;
        let at = |step: i32| {
            let radius = 40.0 * (f64::from(step) * 1.2).to_radians().sin();
            let (sin, cos) = angle(step).to_radians().sin_cos();
            (240.0 + radius * cos, radius * sin)
        };
        let (x, y) = at(0);
        actions.push(travel(x, y, -20.0, Travel::Line));
        actions.push(travel(x, y, -40.0, Travel::Line));
        for step in 1..=150 {
            let (x, y) = at(step);
            actions.push(Action::Path {
                to: to(x, y, -40.0),
            });
        }
        let (x, y) = at(150);
        actions.push(travel(x, y, -20.0, Travel::Line));
    }
    plan(Tool::Pen, actions)
}

/// Pick and place with jumps, waits and the suction cup.
fn pick_and_place() -> Plan {
    let mut actions = vec![
        Action::from(build::speed(80.0, 60.0)),
        Action::from(build::jump_height(30.0, 90.0)),
    ];
    for row in 0..5 {
        let y = f64::from(row) * 25.0 - 50.0;
        actions.extend([
            travel(200.0, y, -20.0, Travel::Jump),
            Action::Suction(true),
            Action::Wait(350),
            travel(260.0, -y, 10.0, Travel::Jump),
            Action::Suction(false),
            Action::Wait(120),
            Action::Shift {
                by: [0.0, 0.0, 15.0, 5.0],
                line: true,
            },
            travel(220.0, 0.0, 40.0, Travel::Joints),
        ]);
    }
    plan(Tool::Suction, actions)
}

/// Arcs and circles at two speeds.
fn rounds() -> Plan {
    let arc = |via: [f64; 3], end: [f64; 3]| {
        let pose = |[x, y, z]: [f64; 3]| [x as f32, y as f32, z as f32, 0.0];
        Action::Arc {
            via: pose(via),
            to: pose(end),
        }
    };
    let circle: Set = build::circle([240.0, 10.0, 0.0, 0.0], [250.0, 0.0, 0.0, 0.0], 2);
    plan(
        Tool::Gripper,
        [
            travel(230.0, 0.0, 0.0, Travel::Joints),
            arc([240.0, 10.0, 0.0], [250.0, 0.0, 0.0]),
            arc([240.0, -10.0, 5.0], [230.0, 0.0, 0.0]),
            Action::from(build::arc_speed(40.0, 300.0)),
            Action::from(circle),
            arc([200.0, 100.0, 20.0], [150.0, 150.0, 30.0]),
        ],
    )
}

/// Rows of a picture: the power changes within a path, which continues.
fn engraving() -> Plan {
    let mut actions = vec![
        Action::from(build::path_speed(60.0, 200.0)),
        travel(220.0, -10.0, -30.0, Travel::Line),
    ];
    for row in 0..12 {
        let y = f64::from(row) * 0.5 - 10.0;
        for column in 0..=40 {
            let x = if row % 2 == 0 { column } else { 40 - column };
            let power = ((x * 7 + row * 3) % 5) as f32 * 20.0;
            actions.push(Action::Burn {
                to: to(220.0 + f64::from(x) * 0.5, y, -30.0),
                power,
            });
        }
    }
    actions.push(Action::Laser(false));
    plan(Tool::Laser, actions)
}

#[test]
fn checked_time_matches_the_virtual_arm_within_a_thousandth() {
    let mut worst: f64 = 0.0;
    for (name, plan) in [
        ("rose", rose()),
        ("pick and place", pick_and_place()),
        ("rounds", rounds()),
        ("engraving", engraving()),
        ("all of it", all_of_it()),
    ] {
        let mut bench = LoneArm::new();
        let start = Preflight::new(&bench.readings());
        let report = check(&plan, &start);
        assert!(report.is_good(), "{name}: {:?}", report.refused_steps);
        let told = report.time.expect("it has an end");
        let commands: Vec<Set> = plan.commands().collect();
        assert_eq!(
            start.estimate(&commands).unwrap(),
            told,
            "{name}: the same as the check before a run"
        );
        let done = bench.run_plan(&plan);
        assert!(done.finished && done.alarm.is_none(), "{name}: {done:?}");
        let off = told.as_micros() as f64 - done.took as f64;
        println!("{name}: {:.3} s, {off} us off", done.took as f64 / 1e6);
        assert!(done.took > 5_000_000, "{name}: {done:?}");
        assert!(
            1000.0 * off.abs() <= done.took as f64,
            "{name}: {off} us of {done:?}"
        );
        worst = worst.max(off.abs());
    }
    assert!(worst <= TIME_TOLERANCE_US, "{worst} us off");
}

fn all_of_it() -> Plan {
    let mut all = plan(Tool::Pen, []);
    for part in [rose(), pick_and_place(), rounds(), engraving()] {
        all.steps.extend(part.steps);
    }
    all
}
