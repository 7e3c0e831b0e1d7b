//! Refusals of each guard by name, and the same programs with the guard off.

use std::time::Duration;

use magician::build::{self, Output};
use magician::commands::{HomeParams, JogCmd};
use magician::preflight::{Guards, Preflight, Readings};
use magician::protocol::{Flag, JogCommand, RailVersion, Stepper};
use magician::{ErrorKind, JointAngles, Set, ToolBias};

fn at_home() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::NONE)
}

fn somewhere() -> Preflight {
    Preflight::new(&Readings::default())
}

/// Checks that the program is refused by this guard and by no other.
fn refused(start: &Preflight, program: &[Set], guard: &str, off: Guards) {
    let error = start.clone().program(program).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
    assert_eq!(error.guard(), Some(guard), "{error}");
    let passes = start.clone().guards(off).program(program);
    passes.unwrap_or_else(|error| panic!("{guard} is off: {error}"));
}

#[test]
fn a_laser_does_not_burn_where_the_arm_stands_or_travels() {
    let start = at_home();
    let off = Guards::default().laser(false);
    let on = build::laser(true);
    let second = Duration::from_secs(1);
    let burn = build::engrave_to(210.0, 0.0, 50.0, 80.0);
    let cases: [&[Set]; 9] = [
        &[on],
        &[on, build::wait(second), build::laser(false)],
        &[on, build::wait_for_level(19, true), build::laser(false)],
        &[on, build::home(), build::laser(false)],
        &[
            on,
            build::move_to(200.0, 20.0, 50.0, 0.0),
            build::laser(false),
        ],
        &[
            on,
            build::jump_to(200.0, 20.0, 50.0, 0.0),
            build::laser(false),
        ],
        &[
            on,
            build::conveyor_by(Stepper::Stepper1, 50.0, 20.0),
            build::laser(false),
        ],
        &[burn],
        &[burn, build::wait(second), build::laser(false)],
    ];
    for program in cases {
        refused(&start, program, "laser", off);
    }
    let mut lit = Readings::default();
    (lit.laser.is_ctrl_enabled, lit.laser.is_on) = (Flag::ON, Flag::ON);
    let lit = Preflight::new(&lit);
    refused(
        &lit,
        &[build::move_joints(0.0, 45.0, 45.0, 0.0)],
        "laser",
        off.unknown_start(false),
    );
}

#[test]
fn a_laser_burns_along_lines_and_paths_and_ends_dark() {
    let program = [
        build::move_to(200.0, 0.0, 50.0, 0.0),
        build::laser(true),
        build::line_to(220.0, 0.0, 50.0, 0.0),
        build::arc_to([230.0, 10.0, 50.0, 0.0], [220.0, 20.0, 50.0, 0.0]),
        build::laser(false),
        build::wait(Duration::from_millis(5)),
        build::engrave_to(200.0, 20.0, 50.0, 60.0),
        build::engrave_to(200.0, 0.0, 50.0, 0.0),
        build::move_to(200.0, -20.0, 50.0, 0.0),
    ];
    let mut check = at_home();
    let lasers = program.map(|command| check.check(&command).unwrap().laser);
    let expected = [false, true, true, true, false, false, true, false, false];
    assert_eq!(lasers, expected);
    check.finish().unwrap();
}

#[test]
fn an_unknown_start_is_left_by_all_joints_together() {
    let off = Guards::default().unknown_start(false);
    let refusals = [
        build::line_to(200.0, 0.0, 50.0, 0.0),
        build::jump_to(200.0, 0.0, 50.0, 0.0),
        build::move_by(1.0, 0.0, 0.0, 0.0),
        build::move_joints_by(1.0, 0.0, 0.0, 0.0),
        build::path_to(200.0, 0.0, 50.0),
        build::path_by(1.0, 0.0, 0.0),
        build::arc_to([200.0, 10.0, 50.0, 0.0], [200.0, 0.0, 60.0, 0.0]),
        build::circle([200.0, 10.0, 50.0, 0.0], [200.0, 0.0, 60.0, 0.0], 1),
    ];
    for command in refusals {
        refused(&somewhere(), &[command], "unknown_start", off);
    }
    let mut check = somewhere();
    let first = check.check(&build::move_to(200.0, 0.0, 50.0, 0.0)).unwrap();
    assert_eq!(first.time, Duration::MAX);
    assert!(first.end.is_some());
    let then = check.check(&build::line_by(10.0, 0.0, 0.0, 0.0)).unwrap();
    assert!(then.time < Duration::from_secs(1));
    let far = somewhere()
        .check(&build::move_joints(0.0, 95.0, 45.0, 0.0))
        .unwrap_err();
    assert_eq!((far.value(), far.limit()), (Some(95.0), Some(90.0)));
}

#[test]
fn homing_leads_to_where_it_was_told() {
    let mut readings = Readings::default();
    let (x, y, z, r) = (259.104, 0.0, -8.485, 0.0);
    readings.home = Some(HomeParams { x, y, z, r });
    let mut check = Preflight::new(&readings);
    let homed = check.check(&build::home()).unwrap();
    assert_eq!(homed.time, Duration::MAX);
    assert!((homed.end.unwrap().joints.j2 - 45.0).abs() < 1e-3);
    check.check(&build::line_by(10.0, 0.0, 0.0, 0.0)).unwrap();
    // With another tool it is unknown if a home point was ever set.
    check.check(&build::tool(ToolBias::PEN)).unwrap();
    assert_eq!(check.check(&build::home()).unwrap().end, None);
    assert!(check.check(&build::line_by(10.0, 0.0, 0.0, 0.0)).is_err());
    check.check(&build::home_at(250.0, 0.0, 20.0, 0.0)).unwrap();
    check.check(&build::home()).unwrap();
    check.check(&build::line_by(10.0, 0.0, 0.0, 0.0)).unwrap();
    assert!(check.check(&build::home_at(400.0, 0.0, 20.0, 0.0)).is_err());
}

#[test]
fn a_jog_is_no_part_of_a_program() {
    let off = Guards::default().jog(false);
    refused(&at_home(), &[build::Axis::J1.plus().into()], "jog", off);
    let stop = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Stop,
    };
    at_home().check(&stop.into()).unwrap();
}

#[test]
fn reach_can_be_left_to_the_arm() {
    let out = build::line_to(500.0, 0.0, 0.0, 0.0);
    let mut check = at_home().guards(Guards::default().reach(false));
    let before = *check.arm().unwrap();
    let step = check.check(&out).unwrap();
    assert_eq!((step.time, step.end), (Duration::ZERO, Some(before)));
    let through = build::line_to(-190.0, 0.0, 50.0, 0.0);
    assert!(at_home().check(&through).is_err());
    check.check(&through).unwrap();
    let nan = build::line_to(f32::NAN, 0.0, 0.0, 0.0);
    assert!(check.guards(Guards::NONE).check(&nan).is_err());
}

#[test]
fn a_command_that_is_refused_changes_nothing() {
    let mut check = at_home();
    let line = build::line_by(0.0, 10.0, 0.0, 0.0);
    let alone = check.clone().check(&line).unwrap();
    check
        .check(&build::line_by(500.0, 0.0, 0.0, 0.0))
        .unwrap_err();
    check.check(&build::speed(-1.0, 50.0)).unwrap_err();
    check
        .check(&build::tool(ToolBias::new(f64::NAN, 0.0, 0.0)))
        .unwrap_err();
    assert_eq!(check.check(&line).unwrap(), alone);
    let refused = [line, build::line_by(500.0, 0.0, 0.0, 0.0)];
    let error = at_home().program(&refused).unwrap_err();
    assert_eq!(error.step(), Some(1));
}

#[test]
fn values_that_the_protocol_does_not_have_are_refused() {
    let output = |percent, address| Output {
        percent,
        address,
        high: true,
    };
    let switching = |output| build::with_outputs(build::move_by(1.0, 0.0, 0.0, 0.0), &[output]);
    let bad = [
        (build::output(21, true), 20.0),
        (build::output(0, true), 1.0),
        (build::pwm(4, 5.0, 50.0), 10.0),
        (build::pwm(4, 50.0, 101.0), 100.0),
        (build::wait_for_level(0, true), 1.0),
        (build::engrave_to(200.0, 0.0, 0.0, 120.0), 100.0),
        (switching(output(101, 4)).unwrap(), 100.0),
        (switching(output(50, 21)).unwrap(), 20.0),
    ];
    for (command, limit) in bad {
        let error = at_home().guards(Guards::NONE).check(&command).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
        assert_eq!(error.limit(), Some(limit), "{error}");
    }
    switching(output(100, 20)).unwrap();
}

#[test]
fn the_rail_ends_where_it_ends() {
    let mut readings = Readings::default();
    readings.rail = Some(400.0);
    let mut check = Preflight::new(&readings).guards(Guards::default().unknown_start(false));
    // Without a rail its position is ignored.
    check
        .check(&build::move_with_rail(200.0, 0.0, 20.0, 0.0, 2000.0))
        .unwrap();
    check.check(&build::rail(true, RailVersion::V2)).unwrap();
    let error = check.check(&build::rail_by(700.0)).unwrap_err();
    assert_eq!((error.value(), error.limit()), (Some(1100.0), Some(1000.0)));
    // 200 mm at 50 mm/s and 50 mm/s2.
    let step = check.check(&build::rail_by(200.0)).unwrap();
    assert_eq!(step.time, Duration::from_secs(5));
    let negative = build::with_rail(build::line_to(200.0, 0.0, 20.0, 0.0), -1.0).unwrap();
    let error = check.check(&negative).unwrap_err();
    assert_eq!((error.value(), error.limit()), (Some(-1.0), Some(0.0)));
}
