//! Homing, stage by stage (model section 11).

use super::arm::{
    Micros, SECOND, TestArm, arm, arm_with, at as instant, home, homing_lasts, joints_to,
    running_arm, search_lasts, trapezoid, wait,
};
use magician_protocol::Flag;
use magician_protocol::commands::*;
use magician_sim::scenario::Scenario;
use magician_sim::{Controller, Event, ExternalEvent, LimitChoice, Profile, World};

/// An arm that has these true joints at power-up.
fn standing_at(joints: [f64; 4]) -> TestArm {
    let mut bench = TestArm {
        arm: Controller::new(Profile::continuous()).standing_at(joints.into()),
    };
    bench.set(&ClearAlarmsState {});
    bench.start();
    bench
}

fn about(lasted: Micros, seconds: f64) {
    let lasted = lasted as f64 / 1e6;
    // Each stage is rounded up to whole microseconds.
    assert!(
        (lasted - seconds).abs() < 1e-5,
        "{lasted} s, not {seconds} s"
    );
}

fn true_base(bench: &TestArm) -> f64 {
    bench.state().true_joints.j1
}

#[track_caller]
fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 2e-4, "{value}, not {expected}");
}

#[test]
fn it_takes_about_14_seconds_from_the_middle() {
    near(homing_lasts(0.0), 13.974_866);
    let mut bench = running_arm();
    assert!(!bench.state().homed);
    bench.enqueue(&home());
    about(bench.rest(), homing_lasts(0.0));
    assert!(bench.state().homed);
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);

    bench.enqueue(&joints_to([60.0, 45.0, 45.0, 0.0]));
    bench.rest();
    bench.enqueue(&home());
    assert!(!bench.state().homed, "until the base is set again");
    about(bench.rest(), homing_lasts(60.0));
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
}

#[test]
fn its_stages_show_in_the_pose() {
    let mut bench = running_arm();
    bench.enqueue(&home());
    let mut at = 0.0;
    let mut go_on = |bench: &mut TestArm, seconds: f64| {
        at += seconds;
        bench.arm.advance(instant((at * 1e6).round() as Micros));
    };
    // Up to speed after 2/3 s, then 20 deg/s.
    go_on(&mut bench, 2.0 / 3.0);
    near(true_base(&bench), -20.0 / 3.0);
    go_on(&mut bench, 3.0);
    near(true_base(&bench), -20.0 / 3.0 - 60.0);
    go_on(&mut bench, trapezoid(135.0, 20.0, 30.0) - 2.0 / 3.0 - 3.0);
    near(true_base(&bench), -135.0);
    go_on(&mut bench, trapezoid(0.5, 20.0, 30.0));
    near(true_base(&bench), -134.5);
    go_on(&mut bench, trapezoid(0.25, 1.0, 30.0));
    near(true_base(&bench), -134.75);
    assert!(!bench.state().homed);
    go_on(&mut bench, trapezoid(0.25, 0.5, 30.0));
    near(true_base(&bench), -135.0);
    bench.pass(10);
    assert!(bench.state().homed && bench.state().moving);
    go_on(&mut bench, 2.0);
    assert_eq!(bench.state().pose.r, bench.state().joints.j1);
    near(true_base(&bench), -135.0 + 15.0 + 30.0);
    assert!(bench.alarms().is_empty());
}

#[test]
fn it_finds_the_base_wherever_it_stands() {
    for base in [-135.0, -134.7, -90.0, -10.0, 0.0, 77.0, 135.0] {
        let mut bench = standing_at([base, 20.0, 30.0, 15.0]);
        assert_eq!(bench.joints(), [0.0, 20.0, 30.0, 15.0]);
        assert_eq!(true_base(&bench), base);
        bench.enqueue(&home());
        bench.pass((search_lasts(base) * 1e6) as Micros - 10);
        let state = bench.state();
        near(state.joints.j1, -135.0 - base);
        near(state.true_joints.j1, -135.0);
        assert!(bench.alarms().is_empty(), "{base}: no limit counts");
        bench.rest();
        let state = bench.state();
        assert!(state.homed && !state.moving);
        assert_eq!(state.joints, state.true_joints, "{base}");
        assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
        assert!(bench.alarms().is_empty(), "{base}");
    }
}

#[test]
fn a_scenario_says_where_the_base_stands() {
    let arm = |text: &str| {
        let scenario = Scenario::from_toml(text).unwrap();
        Controller::in_world(Profile::continuous(), World::from_scenario(&scenario)).state()
    };
    let lost = arm("[arm]\nbase_angle = 160");
    assert_eq!((lost.joints.j1, lost.true_joints.j1), (0.0, 160.0));
    assert!(!lost.homed);
    assert!(arm("[arm]\nhomed = true").homed);
    let known = arm("");
    assert_eq!(known.joints, known.true_joints);
}

#[test]
fn a_base_past_its_switch_backs_off_to_it() {
    let scenario = Scenario::from_toml("[arm]\nbase_angle = -160").unwrap();
    let mut bench = TestArm {
        arm: Controller::in_world(Profile::continuous(), World::from_scenario(&scenario)),
    };
    bench.set(&home());
    bench.pass(SECOND);
    assert!(true_base(&bench) > -160.0 && true_base(&bench) < -134.0);
    bench.rest();
    assert!(bench.state().homed);
    assert_eq!(bench.state().joints, bench.state().true_joints);
}

#[test]
fn lost_steps_are_gone_after_it() {
    let mut bench = running_arm();
    for (joint, degrees) in [(1, 8.0), (2, -6.0), (3, 7.5)] {
        bench.arm.inject(ExternalEvent::Slip { joint, degrees });
    }
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
    assert_eq!(bench.state().true_joints.to_array(), [8.0, 39.0, 52.5, 0.0]);
    bench.enqueue(&home());
    about(bench.rest(), homing_lasts(8.0));
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
    assert_eq!(bench.state().joints, bench.state().true_joints);
}

#[test]
fn a_base_that_slips_on_the_way_is_found_all_the_same() {
    for degrees in [-30.0, -3.0, 3.0, 30.0] {
        for after in [1, 5, 7_500_000, 7_800_000, 8_200_000] {
            let mut bench = running_arm();
            bench.enqueue(&home());
            bench.pass(after);
            bench.arm.inject(ExternalEvent::Slip { joint: 1, degrees });
            bench.rest();
            let state = bench.state();
            assert!(state.homed, "{degrees} after {after}");
            assert_eq!(state.joints, state.true_joints, "{degrees} after {after}");
            assert_eq!(bench.current_index(), 1);
        }
    }
}

#[test]
fn it_goes_to_the_point_that_was_set() {
    let mut bench = running_arm();
    bench.suction_bias();
    let point = HomeParams {
        x: 200.0,
        y: 50.0,
        z: 40.0,
        r: 10.0,
    };
    bench.set(&point);
    bench.set(&home());
    bench.rest();
    assert_eq!(bench.pose(), [200.0, 50.0, 40.0, 10.0]);
}

#[test]
fn a_home_point_out_of_reach_is_stored_and_passed_over_when_homing_gets_there() {
    let points = [
        // The vendor's own demonstration.
        [200.0, 200.0, 200.0, 200.0],
        [2000.0, f32::NAN, 0.0, 0.0],
        // J4 alone is beyond its limit.
        [259.0, 0.0, 0.0, 160.0],
    ];
    for [x, y, z, r] in points {
        let mut bench = running_arm();
        bench.set(&HomeParams { x, y, z, r });
        assert_eq!(
            bench.get::<HomeParams>().y.to_bits(),
            y.to_bits(),
            "stored as it came"
        );
        bench.enqueue(&home());
        bench.enqueue(&wait(0));
        about(bench.rest(), homing_lasts(0.0));
        assert!(bench.alarms().is_empty(), "{x} {y} {z} {r}");
        assert_eq!(bench.current_index(), 2, "and the queue goes on");
        assert!(bench.state().homed);
        assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
        let told = |event: &Event| matches!(event, Event::HomeOutOfReach);
        assert_eq!(bench.events().iter().filter(|event| told(event)).count(), 1);
    }
}

/// Instants within each stage (two in the search, then backing off, both creeps, the move home),
/// and whether the arm is homed by then.
const WITHIN: [(Micros, bool); 6] = [
    (300_000, false),
    (4 * SECOND, false),
    (7_500_000, false),
    (7_800_000, false),
    (8_200_000, false),
    (10 * SECOND, true),
];

#[test]
fn a_force_stop_brakes_at_every_stage() {
    for (after, homed) in WITHIN {
        let mut bench = running_arm();
        bench.enqueue(&home());
        bench.pass(after);
        let before = true_base(&bench);
        bench.set(&QueuedCmdForceStopExec {});
        let lasted = bench.rest();
        // From 30 deg/s at 200 deg/s2: twice the PTP acceleration, 200 deg/s2 at 50 %.
        assert!(lasted <= 150_000, "{lasted}");
        let state = bench.state();
        assert!((true_base(&bench) - before).abs() <= 30.0 * 30.0 / 400.0 + 1e-9);
        assert_eq!(state.homed, homed, "after {after}");
        assert_eq!(bench.current_index(), 1);
        assert!(bench.alarms().is_empty());
    }
}

#[test]
fn another_motion_at_once_ends_it_at_every_stage() {
    for (after, homed) in WITHIN {
        let mut bench = running_arm();
        bench.enqueue(&home());
        bench.pass(after);
        bench.set(&joints_to([-20.0, 40.0, 50.0, 0.0]));
        assert_eq!(bench.current_index(), 1);
        bench.rest();
        assert_eq!(bench.joints(), [-20.0, 40.0, 50.0, 0.0]);
        assert_eq!(bench.state().homed, homed);
    }
}

#[test]
fn a_reset_ends_it_at_every_stage() {
    for (after, _) in WITHIN {
        let mut bench = running_arm();
        bench.enqueue(&home());
        bench.pass(after);
        let there = true_base(&bench);
        bench.arm.inject(ExternalEvent::Reset);
        let state = bench.state();
        assert!(!state.homed && !state.moving);
        assert_eq!((state.joints.j1, state.true_joints.j1), (0.0, there));
        assert_eq!(bench.rest(), 0);
        assert_eq!(bench.current_index(), 0);
    }
}

#[test]
fn alarms_clear_and_stop_let_it_go_on() {
    for (after, _) in WITHIN {
        let mut bench = running_arm();
        bench.enqueue(&home());
        bench.enqueue(&joints_to([30.0, 45.0, 45.0, 0.0]));
        bench.pass(after);
        bench.arm.inject(ExternalEvent::Alarm(0x23));
        bench.set(&QueuedCmdStopExec {});
        about(after + bench.rest(), homing_lasts(0.0));
        assert!(bench.state().homed);
        assert_eq!(bench.current_index(), 1);
        assert_eq!(bench.alarms(), [0x23], "homing clears nothing");
    }
}

#[test]
fn a_profile_may_clear_it_with_the_queue() {
    let mut bench = arm_with(|profile| profile.queue.clear_ends_motion = true);
    bench.start();
    bench.enqueue(&home());
    bench.pass(SECOND);
    bench.set(&QueuedCmdClear {});
    assert_eq!(bench.rest(), 0);
    assert!(!bench.state().homed);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn strict_limits_let_the_base_to_its_switch_and_back() {
    let mut bench = arm_with(|profile| profile.limits.in_force = LimitChoice::Guaranteed);
    bench.start();
    bench.enqueue(&home());
    bench.rest();
    assert!(bench.alarms().is_empty());
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0]);
}

#[test]
fn an_arm_is_switched_on_within_its_limits() {
    let stands = |joints: [f64; 4]| {
        let state = Controller::default().standing_at(joints.into()).state();
        assert_eq!(state.joints.j1, 0.0);
        state.true_joints.to_array()
    };
    assert_eq!(
        stands([200.0, 95.0, 60.0, -200.0]),
        [135.0, 90.0, 60.0, -150.0]
    );
    assert_eq!(stands([0.0, 90.0, 0.0, 0.0]), [0.0, 90.0, 35.0, 0.0]);
    assert_eq!(stands([0.0, -5.0, 90.0, 0.0]), [0.0, -5.0, 65.0, 0.0]);
    let odd = [f64::NAN, f64::INFINITY, -0.1, f64::NEG_INFINITY];
    assert_eq!(stands(odd), [0.0, 45.0, -0.1, 0.0]);
}

#[test]
fn reset_pose_reads_the_sensors_or_is_told() {
    let mut bench = arm();
    let reset = |manual, j2, j3| ResetPose {
        manual: Flag(manual),
        rear_arm_angle: j2,
        front_arm_angle: j3,
    };
    bench.set(&reset(1, 30.0, 20.0));
    let state = bench.state();
    assert_eq!(state.joints.to_array(), [0.0, 30.0, 20.0, 0.0]);
    assert_eq!(state.true_joints.to_array(), [0.0, 45.0, 45.0, 0.0]);
    bench.set(&reset(0, 1.0, 2.0));
    assert_eq!(bench.state().joints, state.true_joints);
    assert_eq!(bench.state().true_joints, state.true_joints);
}
