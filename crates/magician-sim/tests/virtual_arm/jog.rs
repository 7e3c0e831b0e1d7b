//! Jogs over the protocol: ramps, limits, and the queue (document 1.9, model section 10).

use super::arm::{SECOND, TestArm, arm_with, jog, joints_to, ptp, running_arm, wait};
use magician_motion::JointAngles;
use magician_protocol::commands::*;

/// Code of a jog command. Axes 1 to 4 are J1 to J4, or X, Y, Z and R.
fn command(axis: u8, positive: bool) -> u8 {
    2 * axis - u8::from(positive)
}

const STOP: u8 = 0;

fn joints(bench: &TestArm) -> [f64; 4] {
    bench.state().joints.to_array()
}

#[track_caller]
fn near(value: f64, expected: f64) {
    assert!(
        (value - expected).abs() < 1e-6,
        "{value}, expected {expected}"
    );
}

/// Distance that an axis covers from rest in `seconds`, which include the whole ramp.
fn way(seconds: f64, velocity: f64, acceleration: f64) -> f64 {
    let ramp = velocity / acceleration;
    0.5 * velocity * ramp + velocity * (seconds - ramp)
}

#[test]
fn a_joint_ramps_runs_and_ramps_down() {
    // 15 deg/s (J4: 30) at a ratio of 50; 50 deg/s2 at any ratio.
    for axis in 1..=4u8 {
        let velocity = if axis == 4 { 15.0 } else { 7.5 };
        for positive in [true, false] {
            let mut bench = running_arm();
            let before = joints(&bench);
            bench.set(&jog(true, command(axis, positive)));
            assert!(bench.arm.jogging());
            bench.pass(SECOND);
            let sign = if positive { 1.0 } else { -1.0 };
            let moved = |bench: &TestArm| {
                let now = joints(bench);
                for other in (0..4).filter(|other| *other + 1 != usize::from(axis)) {
                    assert_eq!(now[other], before[other]);
                }
                let at = usize::from(axis) - 1;
                sign * (now[at] - before[at])
            };
            let ran = way(1.0, velocity, 50.0);
            near(moved(&bench), ran);
            bench.set(&jog(true, STOP));
            let lasted = bench.rest();
            near(lasted as f64 / 1e6, velocity / 50.0);
            near(moved(&bench), ran + velocity * velocity / 100.0);
            assert!(!bench.arm.jogging() && bench.alarms().is_empty());
        }
    }
}

#[test]
fn a_coordinate_moves_alone_and_r_is_kept() {
    // 60 mm/s at 50 %, 60 mm/s2.
    for axis in 1..=3u8 {
        for positive in [true, false] {
            let mut bench = running_arm();
            bench.enqueue(&ptp(1, [200.0, 30.0, 10.0, 20.0]));
            bench.rest();
            let before = bench.state().pose.to_array();
            bench.set(&jog(false, command(axis, positive)));
            bench.pass(SECOND);
            let at = usize::from(axis) - 1;
            let sign = if positive { 1.0 } else { -1.0 };
            for (other, (now, before)) in
                bench.state().pose.to_array().iter().zip(before).enumerate()
            {
                if other == at {
                    near(sign * (now - before), way(1.0, 30.0, 60.0));
                } else {
                    near(*now, before);
                }
            }
            let [j1, _, _, j4] = joints(&bench);
            near(j1 + j4, 20.0);
            bench.set(&jog(false, STOP));
            near(bench.rest() as f64 / 1e6, 0.5);
            near(
                sign * (bench.state().pose.to_array()[at] - before[at]),
                way(1.0, 30.0, 60.0) + 7.5,
            );
        }
    }
}

#[test]
fn r_turns_the_end_servo_alone() {
    let mut bench = running_arm();
    let [j1, j2, j3, j4] = joints(&bench);
    bench.set(&jog(false, command(4, true)));
    bench.pass(SECOND);
    let turned = way(1.0, 30.0, 60.0);
    assert_eq!(joints(&bench)[..3], [j1, j2, j3]);
    near(joints(&bench)[3], j4 + turned);
    near(bench.state().pose.r, turned);
}

#[test]
fn the_other_direction_passes_through_rest_without_a_pause() {
    let mut bench = running_arm();
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    let turned = way(1.0, 7.5, 50.0);
    bench.set(&jog(true, command(1, false)));
    bench.pass(150_000);
    near(joints(&bench)[0], turned + 0.5625);
    bench.pass(SECOND);
    near(joints(&bench)[0], turned + 0.5625 - way(1.0, 7.5, 50.0));
}

#[test]
fn the_same_again_changes_nothing_but_new_speeds() {
    let mut bench = running_arm();
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    near(joints(&bench)[0], way(2.0, 7.5, 50.0));
    bench.set(&JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 1.0,
    });
    bench.pass(SECOND);
    near(joints(&bench)[0], way(3.0, 7.5, 50.0));
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    let faster = 0.5 * (7.5 + 15.0) * 0.15 + 15.0 * 0.85;
    near(joints(&bench)[0], way(3.0, 7.5, 50.0) + faster);
}

#[test]
fn another_axis_waits_until_the_first_stands() {
    let mut bench = running_arm();
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    bench.set(&jog(true, command(2, true)));
    bench.pass(150_000);
    let stands = way(1.0, 7.5, 50.0) + 0.5625;
    near(joints(&bench)[0], stands);
    near(joints(&bench)[1], 45.0);
    bench.pass(SECOND);
    near(joints(&bench)[0], stands);
    near(joints(&bench)[1], 45.0 + way(1.0, 7.5, 50.0));
    // The continuation may be changed, and cancelled, while the first jog slows down.
    bench.set(&jog(true, command(3, true)));
    bench.set(&jog(true, command(4, true)));
    bench.set(&jog(true, STOP));
    let [.., j3, j4] = joints(&bench);
    bench.rest();
    assert_eq!(joints(&bench)[2..], [j3, j4]);
}

#[test]
fn a_limit_ends_a_jog_with_its_alarm_and_the_way_back_is_open() {
    for (axis, positive, limit, code) in [
        (1, true, 135.0, 0x40),
        (1, false, -135.0, 0x41),
        (2, false, -13.5, 0x43),
        (4, true, 150.0, 0x46),
        (4, false, -150.0, 0x47),
    ] {
        let mut bench = running_arm();
        if axis == 2 {
            bench.enqueue(&joints_to([0.0, 10.0, 30.0, 0.0]));
            bench.rest();
        }
        let at = usize::from(axis) - 1;
        bench.set(&jog(true, command(axis, positive)));
        bench.rest();
        assert_eq!(bench.alarms(), [code]);
        assert_eq!(joints(&bench)[at], limit);
        // The arm goes no further out.
        bench.set(&jog(true, command(axis, positive)));
        assert_eq!((bench.rest(), bench.alarms()), (0, vec![code]));
        assert_eq!(joints(&bench)[at], limit);
        // Clearing the alarms has no effect at the limit.
        bench.set(&ClearAllAlarmsState {});
        assert_eq!(bench.alarms(), [code]);
        let held = bench.enqueue(&wait(0));
        // A jog back works while the alarm stands, and the alarm drops. The queue stays held until
        // a clear.
        bench.set(&jog(true, command(axis, !positive)));
        bench.pass(SECOND);
        assert!(joints(&bench)[at].abs() < limit.abs());
        assert!(bench.alarms().is_empty());
        bench.set(&jog(true, STOP));
        bench.rest();
        assert!(bench.current_index() < held);
        bench.set(&ClearAllAlarmsState {});
        assert_eq!(bench.current_index(), held);
    }
}

#[test]
fn a_straight_jog_ends_where_the_arm_does() {
    for (axis, positive) in [(1, true), (1, false), (2, true), (3, true), (3, false)] {
        let mut bench = running_arm();
        bench.set(&jog(false, command(axis, positive)));
        bench.rest();
        let alarms = bench.alarms();
        assert!(
            alarms == [0x21] || alarms == [0x22],
            "{axis} {positive}: {alarms:x?}"
        );
        let there = bench.state().pose;
        bench.set(&ClearAllAlarmsState {});
        bench.set(&jog(false, command(axis, positive)));
        bench.rest();
        assert!(there.distance_to(&bench.state().pose) < 1e-6);
        bench.set(&ClearAllAlarmsState {});
        bench.set(&jog(false, command(axis, !positive)));
        bench.pass(SECOND);
        near(there.distance_to(&bench.state().pose), way(1.0, 30.0, 60.0));
    }
}

#[test]
fn a_queued_jog_has_finished_at_once_and_the_queue_goes_on_to_what_does_not_move() {
    let mut bench = running_arm();
    let first = bench.enqueue(&jog(true, command(1, true)));
    assert_eq!(bench.current_index(), first);
    assert!(bench.arm.jogging());
    let params = PtpJointParams {
        velocity: [99.0; 4],
        acceleration: [99.0; 4],
    };
    let second = bench.enqueue(&params);
    assert_eq!(bench.current_index(), second);
    assert_eq!(bench.get::<PtpJointParams>(), params);
    let waits = bench.enqueue(&wait(500));
    let moves = bench.enqueue(&ptp(7, [0.0, 0.0, 10.0, 0.0]));
    bench.pass(500_000);
    assert_eq!(bench.current_index(), waits);
    bench.pass(SECOND);
    assert_eq!(
        bench.current_index(),
        waits,
        "a move waits until the jog is over"
    );
    near(joints(&bench)[0], way(1.5, 7.5, 50.0));
    bench.set(&jog(true, STOP));
    bench.pass(149_999);
    assert_eq!(bench.state().queue.running, None);
    bench.pass(1);
    assert_eq!(bench.state().queue.running, Some(moves));
    bench.rest();
    assert_eq!(bench.current_index(), moves);
}

#[test]
fn a_queued_stop_ends_a_queued_jog() {
    let mut bench = running_arm();
    bench.enqueue(&jog(true, command(1, true)));
    bench.enqueue(&wait(1000));
    let stop = bench.enqueue(&jog(true, STOP));
    bench.rest();
    assert_eq!(bench.current_index(), stop);
    near(joints(&bench)[0], way(1.0, 7.5, 50.0) + 0.5625);
}

#[test]
fn a_jog_replaces_a_move_and_a_stop_alone_does_not() {
    let mut bench = running_arm();
    let index = bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(500_000);
    bench.set(&jog(true, STOP));
    assert!(!bench.arm.jogging() && bench.current_index() < index);
    bench.set(&jog(true, command(2, false)));
    assert!(bench.arm.jogging());
    assert_eq!(bench.current_index(), index);
    let j1 = joints(&bench)[0];
    bench.pass(SECOND);
    near(joints(&bench)[0], j1);
    near(joints(&bench)[1], 45.0 - way(1.0, 7.5, 50.0));
}

#[test]
fn what_is_no_axis_stops_a_jog_and_begins_none() {
    for value in [11, 12, 127, 200, 255] {
        let mut bench = running_arm();
        bench.set(&jog(true, value));
        assert!(!bench.state().moving);
        bench.set(&jog(true, command(1, true)));
        bench.pass(SECOND);
        bench.set(&jog(true, value));
        near(bench.rest() as f64 / 1e6, 0.15);
        near(joints(&bench)[0], way(1.0, 7.5, 50.0) + 0.5625);
    }
}

#[test]
fn speeds_that_are_none_are_refused() {
    for bad in [0.0, -1.0, f32::NAN] {
        let mut bench = running_arm();
        bench.set(&JogCommonParams {
            velocity_ratio: bad,
            acceleration_ratio: 50.0,
        });
        bench.set(&jog(true, command(1, true)));
        assert!(!bench.state().moving);
        assert_eq!(bench.alarms(), [0x1A]);
    }
}

#[test]
fn a_force_stop_ends_a_jog_and_a_stop_of_the_queue_does_not() {
    let mut bench = running_arm();
    bench.set(&jog(true, command(1, true)));
    bench.pass(SECOND);
    bench.set(&QueuedCmdStopExec {});
    bench.set(&QueuedCmdClear {});
    bench.pass(SECOND);
    near(joints(&bench)[0], way(2.0, 7.5, 50.0));
    bench.set(&QueuedCmdForceStopExec {});
    // Twice the PTP acceleration in force: 200 deg/s2 at 50 %.
    near(bench.rest() as f64 / 1e6, 7.5 / 200.0);
    assert!(bench.alarms().is_empty());
}

#[test]
fn without_limits_of_its_own_an_axis_runs_for_long() {
    let mut bench = arm_with(|profile| {
        profile.limits.controller.j4 = magician_motion::Range::new(-1e6, 1e6);
    });
    bench.set(&jog(true, command(4, true)));
    bench.pass(3600 * SECOND);
    near(joints(&bench)[3], way(3600.0, 15.0, 50.0));
    assert!(joints(&bench)[3] > 5e4 && JointAngles::from(joints(&bench)).is_finite());
}
