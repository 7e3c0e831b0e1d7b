//! Point-to-point motion: times, ends, and the pose on the way.

use super::arm;
use super::arm::{SECOND, arm, arm_with, joints_to, lasts, ptp, running_arm};
use magician_motion::ToolBias;
use magician_protocol::commands::*;
use magician_protocol::{PoCmd, PoList, PtpMode};

const HOME: [f32; 4] = [259.104_13, 0.0, -8.485_281, 0.0];

#[track_caller]
#[test]
fn a_line_of_100_mm_takes_2_s_and_at_full_ratio_1_414_s() {
    for (full, seconds) in [(false, 2.0), (true, 2.0_f64.sqrt())] {
        let mut bench = running_arm();
        if full {
            bench.full_speed();
        }
        bench.enqueue(&ptp(7, [0.0, 100.0, 0.0, 0.0]));
        lasts(bench.rest(), seconds);
    }
}

#[test]
fn a_joint_move_of_90_degrees_takes_1_897_s_and_at_full_ratio_1_342_s() {
    for (full, seconds) in [(false, 1.897_367), (true, 1.341_641)] {
        let mut bench = running_arm();
        if full {
            bench.full_speed();
        }
        bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
        lasts(bench.rest(), seconds);
    }
}

#[test]
fn half_way_through_the_time_is_half_the_way() {
    let mut bench = running_arm();
    bench.enqueue(&ptp(2, [259.104_13, 100.0, -8.485_281, 0.0]));
    bench.pass(SECOND);
    let [x, y, z, r] = bench.pose();
    assert!(
        (x - HOME[0]).abs() < 1e-4 && (y - 50.0).abs() < 1e-3,
        "{x} {y}"
    );
    assert!((z - HOME[2]).abs() < 1e-4 && r.abs() < 1e-4);
}

#[test]
fn every_mode_ends_where_it_says() {
    let start = [220.0, 20.0, 30.0, 5.0];
    let angles = [10.0, 30.0, 40.0, -10.0];
    let by = [5.0, -10.0, 8.0, 3.0];
    for mode in 0..=9 {
        let mut bench = running_arm();
        bench.enqueue(&ptp(1, start));
        bench.rest();
        assert_eq!(bench.pose(), start, "to the last bit");
        let from = bench.joints();
        let target = match mode {
            3..=5 => angles,
            6..=8 => by,
            _ => [210.0, -40.0, 12.5, -20.0],
        };
        bench.enqueue(&ptp(mode, target));
        assert!(bench.rest() > 100_000, "mode {mode} takes time");
        assert!(
            bench.alarms().is_empty(),
            "mode {mode}: {:?}",
            bench.alarms()
        );
        let sum = |from: [f32; 4]| [0, 1, 2, 3].map(|axis| from[axis] + by[axis]);
        match mode {
            3..=5 => assert_eq!(bench.joints(), angles, "mode {mode}"),
            6 => {
                for (joint, wanted) in bench.joints().iter().zip(sum(from)) {
                    assert!((joint - wanted).abs() < 1e-4, "mode {mode}");
                }
            }
            7 | 8 => assert_eq!(bench.pose(), sum(start), "mode {mode}"),
            _ => assert_eq!(bench.pose(), target, "mode {mode}"),
        }
    }
}

#[test]
fn a_jump_rises_by_its_height_and_no_higher_than_its_limit() {
    for (height, z_limit, top) in [(20.0, 100.0, 50.0), (20.0, 40.0, 40.0)] {
        let mut bench = running_arm();
        bench.enqueue(&ptp(1, [200.0, 0.0, 30.0, 0.0]));
        bench.rest();
        bench.set(&PtpJumpParams {
            jump_height: height,
            z_limit,
        });
        bench.enqueue(&ptp(9, [200.0, 60.0, 10.0, 0.0]));
        let mut highest = f32::MIN;
        while bench.arm.poll_timeout().is_some() {
            highest = highest.max(bench.pose()[2]);
            bench.pass(1000);
        }
        assert!((highest - top).abs() < 1e-3, "{highest}, expected {top}");
        assert_eq!(bench.pose(), [200.0, 60.0, 10.0, 0.0]);
    }
}

#[test]
fn increments_count_from_where_the_command_starts() {
    let mut bench = arm();
    bench.enqueue(&ptp(6, [10.0, 0.0, 0.0, 0.0]));
    bench.enqueue(&ptp(6, [10.0, 0.0, 0.0, 0.0]));
    bench.start();
    bench.rest();
    assert_eq!(bench.joints(), [20.0, 45.0, 45.0, 0.0]);
}

#[test]
fn a_move_is_planned_when_it_starts_and_not_changed_later() {
    let mut bench = arm();
    bench.enqueue(&ptp(7, [0.0, 100.0, 0.0, 0.0]));
    bench.full_speed();
    bench.start();
    bench.set(&PtpCommonParams {
        velocity_ratio: 1.0,
        acceleration_ratio: 1.0,
    });
    lasts(bench.rest(), 2.0_f64.sqrt());
}

#[test]
fn speeds_beyond_the_ceilings_are_set_to_them() {
    let mut bench = running_arm();
    let fast = PtpJointParams {
        velocity: [1e9; 4],
        acceleration: [f32::INFINITY; 4],
    };
    bench.set(&fast);
    bench.full_speed();
    let most = PtpJointParams {
        velocity: [320.0, 320.0, 320.0, 480.0],
        acceleration: [300.0; 4],
    };
    assert_eq!(bench.get::<PtpJointParams>(), most);
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    // 300 deg/s2: a triangle that does not reach 320 deg/s.
    lasts(bench.rest(), 2.0 * (90.0_f64 / 300.0).sqrt());
}

#[test]
fn a_move_to_where_the_arm_is_finishes_at_once_without_alarm() {
    let mut bench = running_arm();
    let speeds = PtpJointParams {
        velocity: [f32::NAN; 4],
        acceleration: [0.0; 4],
    };
    bench.set(&speeds);
    bench.enqueue(&joints_to([0.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.current_index(), 1);
    assert!(bench.alarms().is_empty());
}

#[test]
fn the_bias_moves_the_reported_pose_at_once_and_no_joint() {
    let mut bench = arm_with(|profile| profile.power_up.tool = ToolBias::NONE);
    let joints = bench.joints();
    assert_eq!(bench.pose()[0], 199.404_11);
    bench.suction_bias();
    assert_eq!(bench.pose()[0], 259.104_13);
    assert_eq!(bench.joints(), joints);
    assert_eq!(bench.get::<HomeParams>().x, 259.104_13);
    // The same during a motion.
    bench.set(&ptp(7, [0.0, 50.0, 0.0, 0.0]));
    bench.pass(500_000);
    let before = bench.get::<Pose>();
    bench.set(&EndEffectorParams {
        x_bias: 0.0,
        y_bias: 0.0,
        z_bias: 0.0,
    });
    let after = bench.get::<Pose>();
    assert_eq!(before.joint_angle, after.joint_angle);
    let radius = |pose: &Pose| pose.x.hypot(pose.y);
    assert!((radius(&before) - radius(&after) - 59.7).abs() < 1e-3);
    bench.rest();
    bench.suction_bias();
    assert_eq!(bench.pose()[1], 50.0, "the target again, to the last bit");
}

#[test]
fn an_immediate_motion_replaces_the_queues_and_the_queue_goes_on_after_it() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&joints_to([0.0, 45.0, 45.0, 30.0]));
    bench.pass(SECOND);
    let from = bench.joints()[0];
    bench.set(&joints_to([-20.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.current_index(), 1, "replaced counts as finished");
    assert_eq!(bench.joints()[0], from);
    assert_eq!(
        bench.left_space(),
        31,
        "the queue waits for the immediate motion"
    );
    let mut lowest = f32::MAX;
    while bench.arm.poll_timeout().is_some() {
        lowest = lowest.min(bench.joints()[0]);
        bench.pass(1000);
    }
    assert!((lowest + 20.0).abs() < 1e-3, "{lowest}");
    assert_eq!(bench.joints(), [0.0, 45.0, 45.0, 30.0]);
    assert_eq!(bench.current_index(), 2);
    assert!(bench.alarms().is_empty());
}

#[test]
fn an_immediate_motion_that_is_refused_disturbs_nothing_under_way() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.set(&ptp(1, [900.0, 0.0, 0.0, 0.0]));
    assert_eq!(bench.alarms(), [0x11]);
    bench.rest();
    assert_eq!(bench.joints()[0], 90.0);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn an_immediate_motion_leaves_a_running_wait_alone() {
    let mut bench = running_arm();
    bench.enqueue(&arm::wait(500));
    bench.enqueue(&arm::wait(0));
    bench.set(&joints_to([90.0, 45.0, 45.0, 0.0]));
    bench.pass(500_000);
    assert_eq!(bench.current_index(), 1);
    bench.pass(SECOND);
    assert_eq!(
        bench.current_index(),
        1,
        "the next one waits for the motion"
    );
    bench.rest();
    assert_eq!(bench.current_index(), 2);
}

#[test]
fn motion_finish_tells_whether_something_moves() {
    let mut bench = arm();
    assert!(bench.get::<QueuedCmdMotionFinish>().is_finish.is_on());
    bench.set(&joints_to([90.0, 45.0, 45.0, 0.0]));
    assert!(!bench.get::<QueuedCmdMotionFinish>().is_finish.is_on());
    bench.rest();
    assert!(bench.get::<QueuedCmdMotionFinish>().is_finish.is_on());
}

#[test]
fn ptp_time_is_the_time_that_the_move_then_takes() {
    let mut bench = running_arm();
    let [x, y, z, r] = [0.0, 100.0, 0.0, 0.0];
    let ptp_mode = PtpMode::MovlXyzInc;
    let query = GetPtpTime {
        ptp_mode,
        x,
        y,
        z,
        r,
    };
    assert_eq!(bench.get_with::<PtpTime>(&query).ptp_time, 2000);
    let nowhere = GetPtpTime {
        ptp_mode: PtpMode::MovjXyz,
        x: 1e6,
        ..query
    };
    assert_eq!(bench.get_with::<PtpTime>(&nowhere).ptp_time, 0);
    assert!(bench.alarms().is_empty(), "asking is no motion");
}

#[test]
fn reset_pose_sets_two_joints_when_nothing_moves() {
    let mut bench = arm();
    let reset = |manual, j2, j3| ResetPose {
        manual: magician_protocol::Flag(manual),
        rear_arm_angle: j2,
        front_arm_angle: j3,
    };
    bench.set(&reset(1, 20.0, 30.0));
    assert_eq!(bench.joints(), [0.0, 20.0, 30.0, 0.0]);
    bench.set(&reset(0, 1.0, 2.0));
    bench.set(&reset(1, f32::NAN, 2.0));
    bench.set(&reset(1, 1.0, f32::INFINITY));
    bench.set(&joints_to([10.0, 20.0, 30.0, 0.0]));
    bench.set(&reset(1, 1.0, 2.0));
    bench.rest();
    assert_eq!(bench.joints(), [10.0, 20.0, 30.0, 0.0]);
}

#[test]
fn a_move_switches_outputs_when_their_share_of_the_path_is_done() {
    let mut bench = running_arm();
    let [x, y, z, r] = [0.0, 100.0, 0.0, 0.0];
    let output = |ratio, address, level| PoCmd {
        ratio,
        address,
        level,
    };
    let outputs = [
        output(50, 4, 1),
        output(0, 2, 1),
        output(100, 4, 0),
        output(50, 6, 1),
        output(30, 999, 1),
    ];
    bench.enqueue(&PtpPoCmd {
        ptp_mode: PtpMode::MovlXyzInc,
        x,
        y,
        z,
        r,
        po: PoList::new(&outputs).unwrap(),
    });
    let level = |bench: &mut arm::TestArm, address| {
        let address = Some(address);
        bench.get_with::<IoDo>(&GetIoDo { address }).level.0
    };
    assert_eq!(level(&mut bench, 2), 1);
    bench.pass(SECOND - 2);
    assert_eq!([level(&mut bench, 4), level(&mut bench, 6)], [0, 0]);
    bench.pass(4);
    assert_eq!([level(&mut bench, 4), level(&mut bench, 6)], [1, 1]);
    lasts(SECOND + 2 + bench.rest(), 2.0);
    assert_eq!(level(&mut bench, 4), 0);
    assert_eq!(bench.current_index(), 1);
}

#[test]
fn outputs_beyond_where_a_limit_ends_the_move_are_not_switched() {
    let mut bench = running_arm();
    let [x, y, z, r] = [270.0, 45.0, 45.0, 0.0];
    let outputs = [(25, 2), (75, 3)].map(|(ratio, address)| PoCmd {
        ratio,
        address,
        level: 1,
    });
    bench.enqueue(&PtpPoCmd {
        ptp_mode: PtpMode::MovjAngle,
        x,
        y,
        z,
        r,
        po: PoList::new(&outputs).unwrap(),
    });
    bench.rest();
    assert_eq!(bench.alarms(), [0x40]);
    let levels = [2, 3].map(|address| {
        let address = Some(address);
        bench.get_with::<IoDo>(&GetIoDo { address }).level.0
    });
    assert_eq!(levels, [1, 0]);
}
