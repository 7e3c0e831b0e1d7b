//! Transitions between motions: a change during a motion must not move the arm off its path, and a
//! refused command must change nothing.

use super::arm::{SECOND, TestArm, arm_with, home, jog, joints_to, ptp, running_arm};
use magician_motion::Geometry;
use std::time::Duration;

use magician_protocol::commands::*;
use magician_protocol::{Alarm, CpMode, Flag};

/// Segments along x from here are free.
const START: [f32; 4] = [180.0, 0.0, 0.0, 0.0];

/// An action on an arm.
type Act<'a> = &'a dyn Fn(&mut TestArm);

fn segment(cp_mode: CpMode, x: f32) -> CpCmd {
    CpCmd {
        cp_mode,
        x,
        y: 0.0,
        z: 0.0,
        velocity_or_power: 0.0,
    }
}

fn by(x: f32) -> CpCmd {
    segment(CpMode::Relative, x)
}

fn path_of(steps: &[f32]) -> TestArm {
    let mut bench = running_arm();
    bench.set(&ptp(1, START));
    bench.rest();
    bench.set(&QueuedCmdStopExec {});
    for step in steps {
        bench.enqueue(&by(*step));
    }
    bench.start();
    bench
}

/// Speed of the tool over the last millisecond before the next event, mm/s.
fn speed_before_event(bench: &mut TestArm) -> f64 {
    let at = bench.arm.poll_timeout().expect("it moves");
    bench.arm.advance(at - Duration::from_micros(1001));
    let before = bench.state().pose;
    bench.arm.advance(at - Duration::from_micros(1));
    bench.state().pose.distance_to(&before) * 1000.0
}

/// Changes the tool bias during a motion, then acts on the motion. The joints must continue from
/// where they are, and the pose must be that of the joints with the new tool.
#[track_caller]
fn keeps_its_way(mut bench: TestArm, act: impl FnOnce(&mut TestArm)) {
    let before = bench.state().joints.to_array();
    assert!(bench.state().moving);
    bench.suction_bias();
    act(&mut bench);
    let mut last = before;
    for _ in 0..2000 {
        let state = bench.state();
        let joints = state.joints.to_array();
        for (is, was) in joints.iter().zip(last) {
            assert!((is - was).abs() < 0.5, "{last:?} to {joints:?}");
        }
        let pose = Geometry::magician(state.tool).forward(&state.joints);
        let off = pose.distance_to(&state.pose);
        assert!(off < 1e-6, "{pose:?}, but it says {:?}", state.pose);
        last = joints;
        bench.pass(1000);
    }
}

#[test]
fn a_new_tool_tears_no_motion_from_its_way() {
    let force_stop = |bench: &mut TestArm| bench.set(&QueuedCmdForceStopExec {});
    for mode in [1, 2, 0] {
        let mut bench = running_arm();
        bench.enqueue(&ptp(mode, [230.0, 60.0, 40.0, 20.0]));
        bench.pass(SECOND / 2);
        keeps_its_way(bench, force_stop);
    }
    for cmd in 1..=8 {
        for is_joint in [false, true] {
            let mut bench = running_arm();
            bench.set(&jog(is_joint, cmd));
            bench.pass(SECOND / 2);
            let at = bench.arm.clone();
            keeps_its_way(bench, |bench| bench.set(&jog(is_joint, 0)));
            keeps_its_way(TestArm { arm: at.clone() }, force_stop);
            let back = if cmd % 2 == 1 { cmd + 1 } else { cmd - 1 };
            keeps_its_way(TestArm { arm: at }, |bench| bench.set(&jog(is_joint, back)));
        }
    }
    for grows in [false, true] {
        let mut bench = path_of(&[20.0, 20.0]);
        bench.pass(SECOND / 10);
        keeps_its_way(bench, |bench| {
            if grows {
                bench.enqueue(&by(20.0));
                bench.enqueue(&segment(CpMode::Absolute, 290.0));
            } else {
                bench.set(&QueuedCmdStopExec {});
            }
        });
    }
}

#[test]
fn what_is_refused_changes_nothing_under_way() {
    let bad_speeds = |bench: &mut TestArm| {
        bench.set(&JogCommonParams {
            velocity_ratio: 0.0,
            acceleration_ratio: 50.0,
        });
        bench.set(&JogLParams {
            velocity: f32::NAN,
            acceleration: 50.0,
        });
        bench.set(&SetDeviceWithL {
            with_l: Flag::ON,
            version: None,
        });
    };
    let refused: [(&str, u8, Act<'_>); 4] = [
        ("a segment", Alarm::PlanInvCalc, &|bench| {
            bench.set(&segment(CpMode::Absolute, 900.0));
        }),
        ("a jog", Alarm::PlanSpeedInputParam, &|bench| {
            bench.set(&jog(true, 1));
        }),
        ("a jog of the rail", Alarm::PlanSpeedInputParam, &|bench| {
            bench.set(&jog(true, 9));
        }),
        ("a move", Alarm::PlanInvCalc, &|bench| {
            bench.set(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
        }),
    ];
    for (what, alarm, refuse) in refused {
        let mut bench = running_arm();
        bad_speeds(&mut bench);
        let index = bench.enqueue(&joints_to([40.0, 45.0, 45.0, 0.0]));
        bench.pass(SECOND / 2);
        refuse(&mut bench);
        assert_eq!(bench.state().queue.running, Some(index), "{what}");
        assert_eq!(bench.alarms(), [alarm], "{what}");
        bench.rest();
        assert_eq!(bench.joints(), [40.0, 45.0, 45.0, 0.0], "{what}");
    }
}

#[test]
fn jogs_keep_to_the_ceilings_before_the_ratio() {
    let mut bench = arm_with(|profile| profile.ceilings.joint_velocity = [40.0; 4]);
    bench.set(&JogJointParams {
        velocity: [1000.0; 4],
        acceleration: [1000.0; 4],
    });
    bench.set(&jog(true, 1));
    bench.pass(SECOND);
    let before = bench.state().joints.j1;
    bench.pass(SECOND);
    let speed = bench.state().joints.j1 - before;
    assert!((speed - 20.0).abs() < 1e-6, "half of 40, not {speed}");
}

/// The ceiling is that of the profile, also above that of the known firmware.
#[test]
fn a_profile_that_raises_a_ceiling_raises_it() {
    let seconds = |linear_velocity: f64| {
        let mut bench = arm_with(|profile| {
            profile.ceilings.linear_velocity = linear_velocity;
            profile.ceilings.linear_acceleration = 1e5;
        });
        bench.set(&QueuedCmdStartExec {});
        bench.set(&PtpCommonParams {
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
        });
        bench.set(&PtpCoordinateParams {
            xyz_velocity: 1000.0,
            r_velocity: 1000.0,
            xyz_acceleration: 1e5,
            r_acceleration: 1e5,
        });
        bench.set(&ptp(2, [220.0, -120.0, 20.0, 0.0]));
        bench.rest();
        let begun = bench.state().now;
        bench.set(&ptp(2, [220.0, 120.0, 20.0, 0.0]));
        bench.rest();
        (bench.state().now - begun).as_secs_f64()
    };
    assert!((seconds(300.0) - 0.803).abs() < 1e-3, "{}", seconds(300.0));
    assert!((seconds(600.0) - 0.406).abs() < 1e-3, "{}", seconds(600.0));
    assert!((seconds(2000.0) - 0.25).abs() < 1e-3, "{}", seconds(2000.0));
}

#[test]
fn two_negative_speeds_make_no_positive_one() {
    let mut bench = running_arm();
    bench.set(&JogJointParams {
        velocity: [-20.0; 4],
        acceleration: [50.0; 4],
    });
    bench.set(&JogCommonParams {
        velocity_ratio: -50.0,
        acceleration_ratio: 50.0,
    });
    bench.set(&jog(true, 1));
    assert!(!bench.state().moving);
    assert_eq!(bench.alarms(), [Alarm::PlanSpeedInputParam]);
}

#[test]
fn homing_cut_short_leaves_no_place_for_a_straight_line() {
    let stand = || {
        let mut bench = running_arm();
        bench.arm = bench.arm.standing_at([100.0, 45.0, 45.0, 0.0].into());
        bench.set(&home());
        bench.pass(10 * SECOND);
        bench.set(&QueuedCmdForceStopExec {});
        bench.rest();
        let j1 = bench.state().joints.j1;
        assert!(j1 < -181.0, "the base knows nothing yet, and is at {j1}");
        bench
    };
    let straight: [Act<'_>; 5] = [
        &|bench| bench.set(&ptp(2, [200.0, 0.0, 0.0, 0.0])),
        &|bench| bench.set(&ptp(7, [1.0, 1.0, 0.0, 0.0])),
        &|bench| bench.set(&by(5.0)),
        &|bench| bench.set(&jog(false, 1)),
        &|bench| {
            bench.set(&CircleCmd {
                cir_point: [-190.0, 10.0, 0.0, 0.0],
                to_point: [-180.0, 20.0, 0.0, 0.0],
                count: 1,
            });
        },
    ];
    for act in straight {
        let mut bench = stand();
        let before = bench.state().joints;
        act(&mut bench);
        assert_eq!(bench.state().joints, before);
        assert!(!bench.state().moving);
        assert!(bench.alarms().contains(&Alarm::PlanInvLimit));
    }
    let mut bench = stand();
    bench.set(&joints_to([0.0, 45.0, 45.0, 0.0]));
    bench.rest();
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 0.0], "joints find back");
}

#[test]
fn a_path_that_was_broken_off_is_known_anew() {
    let mut bench = path_of(&[10.0, 10.0]);
    bench.enqueue(&segment(CpMode::Absolute, 230.0));
    bench.pass(SECOND / 10);
    // From there the line to 230 leads back instead of on.
    bench.set(&ptp(1, [225.0, 0.0, 0.0, 0.0]));
    while bench.state().queue.running != Some(2) {
        let at = bench.arm.poll_timeout().expect("the path goes on");
        bench.arm.advance(at);
    }
    let speed = speed_before_event(&mut bench);
    assert!(speed < 2.0, "{speed} mm/s into a reversal");
}

#[test]
fn a_path_comes_to_rest_before_speeds_that_are_none() {
    let mut bench = path_of(&[20.0, 20.0]);
    bench.pass(SECOND / 10);
    bench.set(&CpParams {
        plan_acc: f32::NAN,
        junction_vel: 100.0,
        acc_or_period: 100.0,
        real_time_track: Flag::OFF,
    });
    let speed = speed_before_event(&mut bench);
    assert!(speed < 1.0, "{speed} mm/s");
    bench.rest();
    assert_eq!(bench.alarms(), [Alarm::PlanSpeedInputParam]);
    assert_eq!(bench.pose()[0], 200.0);
}
