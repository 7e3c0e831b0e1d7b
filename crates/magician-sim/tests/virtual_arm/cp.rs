//! Continuous paths over the protocol: times, ends, corners, and stops (document 1.11, model
//! section 8).

use super::arm;
use super::arm::{SECOND, TestArm, arm, lasts, ptp, running_arm};
use std::time::Duration;

use magician_protocol::commands::*;
use magician_protocol::{CpMode, Flag};
use magician_sim::ExternalEvent;

/// Pose from which the paths of these tests meet no limit.
const START: [f32; 4] = [200.0, 0.0, 0.0, 0.0];

/// An action on a moving arm.
type Act<'a> = &'a dyn Fn(&mut TestArm);

fn to([x, y, z]: [f32; 3]) -> CpCmd {
    CpCmd {
        cp_mode: CpMode::Absolute,
        x,
        y,
        z,
        velocity_or_power: 0.0,
    }
}

fn by(step: [f32; 3]) -> CpCmd {
    CpCmd {
        cp_mode: CpMode::Relative,
        ..to(step)
    }
}

fn burning([x, y, z]: [f32; 3], velocity_or_power: f32) -> CpLeCmd {
    CpLeCmd {
        cp_mode: CpMode::Relative,
        x,
        y,
        z,
        velocity_or_power,
    }
}

/// An arm at the start, its queue started.
fn at_start() -> TestArm {
    let mut bench = running_arm();
    bench.enqueue(&ptp(1, START));
    bench.rest();
    bench
}

/// The same with the queue stopped, so that a whole path is queued before it runs.
fn collecting() -> TestArm {
    let mut bench = at_start();
    bench.set(&QueuedCmdStopExec {});
    bench
}

fn run(bench: &mut TestArm) -> u64 {
    bench.start();
    bench.rest()
}

fn speeds(plan_acc: f32, junction_vel: f32) -> CpParams {
    CpParams {
        plan_acc,
        junction_vel,
        acc_or_period: 100.0,
        real_time_track: Flag::OFF,
    }
}

/// Advances the arm by 1 ms; returns the mean speed of the tool, mm/s.
fn speed(bench: &mut TestArm) -> f64 {
    let before = bench.state().pose;
    bench.pass(1000);
    bench.state().pose.distance_to(&before) * 1e3
}

#[track_caller]
#[test]
fn a_line_takes_the_same_time_whole_and_in_pieces() {
    // 100 mm at 100 mm/s and 100 mm/s2: a ramp of a second up and one down.
    for pieces in [1u8, 2, 20, 31] {
        let mut bench = collecting();
        for piece in 1..=pieces {
            let y = 100.0 * f32::from(piece) / f32::from(pieces);
            bench.enqueue(&to([200.0, y, 0.0]));
        }
        lasts(run(&mut bench), 2.0);
        assert_eq!(bench.pose()[..3], [200.0, 100.0, 0.0]);
    }
}

#[test]
fn acceleration_and_speed_are_those_set_up_to_the_ceilings() {
    for (plan_acc, junction_vel, seconds) in [
        (200.0, 50.0, 100.0 / 50.0 + 50.0 / 200.0),
        (400.0, 1000.0, 2.0 * (100.0_f64 / 400.0).sqrt()),
        (9e9, f32::INFINITY, 2.0 * (100.0_f64 / 400.0).sqrt()),
    ] {
        let mut bench = at_start();
        bench.set(&speeds(plan_acc, junction_vel));
        bench.enqueue(&by([0.0, 100.0, 0.0]));
        lasts(bench.rest(), seconds);
    }
}

#[test]
fn a_corner_is_taken_at_the_speed_of_its_angle() {
    // v = acceleration * 20 ms / (2 sin(angle / 2)); angles above 90 degrees count as 90.
    for (turn, counts_as) in [
        (20.0_f64, 20.0_f64),
        (60.0, 60.0),
        (90.0, 90.0),
        (150.0, 90.0),
    ] {
        let corner = 0.5 * 100.0 * 0.02 / (0.5 * counts_as.to_radians()).sin();
        let peak = (100.0 * 40.0 + 0.5 * corner * corner).sqrt();
        let mut bench = collecting();
        let (sin, cos) = turn.to_radians().sin_cos();
        bench.enqueue(&by([0.0, 40.0, 0.0]));
        bench.enqueue(&by([(40.0 * sin) as f32, (40.0 * cos) as f32, 0.0]));
        let began = bench.arm.now();
        bench.start();
        let reached = 2.0 * peak / 100.0 - corner / 100.0;
        bench.pass((reached * 1e6) as u64 - 1000);
        let speed = speed(&mut bench);
        assert!(
            (speed - corner).abs() < 0.11,
            "{turn}: {speed}, expected {corner}"
        );
        bench.rest();
        lasts(bench.arm.now().micros_since(began), 2.0 * reached);
    }
}

#[test]
fn ends_are_exact_and_r_drifts_with_the_base() {
    let mut bench = at_start();
    let [_, _, _, j4] = bench.joints();
    for end in [
        [210.5, 33.25, -7.125],
        [180.1, 60.3, 20.7],
        [199.9, -80.0, 0.3],
    ] {
        bench.enqueue(&to(end));
        bench.rest();
        let (pose, joints) = (bench.pose(), bench.joints());
        assert_eq!(pose[..3], end);
        assert_eq!(joints[3], j4, "J4 stands still");
        assert!((pose[3] - joints[0] - j4).abs() < 1e-5);
    }
    assert!(bench.pose()[3] < -20.0, "r went with J1");
}

#[test]
fn relative_segments_count_from_the_end_of_the_one_before() {
    let mut bench = collecting();
    bench.enqueue(&to([210.0, 10.0, 5.0]));
    bench.enqueue(&by([0.0, 10.0, 0.0]));
    bench.enqueue(&by([-10.0, 0.0, 1.0]));
    run(&mut bench);
    assert_eq!(bench.pose()[..3], [200.0, 20.0, 6.0]);
    // After another motion, from where that one ended.
    bench.enqueue(&ptp(7, [0.0, -20.0, -6.0, 0.0]));
    bench.enqueue(&by([0.0, 0.0, 3.0]));
    bench.rest();
    assert_eq!(bench.pose()[..3], [200.0, 0.0, 3.0]);
}

#[test]
fn in_real_time_a_segment_takes_a_period_and_corners_do_not_count() {
    let real_time = CpParams {
        acc_or_period: 20.0,
        real_time_track: Flag::ON,
        ..speeds(100.0, 100.0)
    };
    // 1 mm in 20 ms is 50 mm/s; 30 mm with a ramp of half a second at either end.
    for zigzag in [false, true] {
        let mut bench = collecting();
        bench.set(&real_time);
        for piece in 0..30 {
            let step = if zigzag && piece % 2 == 0 {
                [1.0, 0.0, 0.0]
            } else {
                [0.0, 1.0, 0.0]
            };
            bench.enqueue(&by(step));
        }
        lasts(run(&mut bench), 30.0 / 50.0 + 50.0 / 100.0);
    }
}

#[test]
fn segments_that_come_in_time_lose_none() {
    // A segment queued a second before the end is early enough: the ramp down takes a second.
    let mut bench = at_start();
    bench.enqueue(&by([0.0, 60.0, 0.0]));
    bench.pass(300_000);
    bench.enqueue(&by([0.0, 20.0, 0.0]));
    bench.pass(300_000);
    bench.enqueue(&by([0.0, 20.0, 0.0]));
    lasts(600_000 + bench.rest(), 2.0);
    assert_eq!(bench.pose()[1], 100.0);
}

#[test]
fn a_path_that_runs_dry_rests_at_its_end_and_begins_again() {
    let mut bench = at_start();
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    lasts(bench.rest(), 1.0);
    bench.pass(SECOND);
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    lasts(bench.rest(), 1.0);
    // Any other command ends the path as well.
    bench.set(&QueuedCmdStopExec {});
    bench.enqueue(&by([0.0, -25.0, 0.0]));
    bench.enqueue(&arm::wait(0));
    bench.enqueue(&by([0.0, -25.0, 0.0]));
    lasts(run(&mut bench), 2.0);
}

#[test]
fn stop_ends_a_path_at_the_end_of_its_segment_and_clear_where_it_is() {
    let stop = |bench: &mut TestArm| bench.set(&QueuedCmdStopExec {});
    let clear = |bench: &mut TestArm| bench.set(&QueuedCmdClear {});
    let alarm = |bench: &mut TestArm| bench.arm.inject(ExternalEvent::Alarm(0x20));
    let endings: [(&str, Act<'_>); 3] = [("stop", &stop), ("clear", &clear), ("alarm", &alarm)];
    for (name, end) in endings {
        let mut bench = collecting();
        for _ in 0..4 {
            bench.enqueue(&burning([0.0, 20.0, 0.0], 50.0));
        }
        bench.start();
        // 80 mm from rest to rest; after 0.8 s 32 mm are done: in the second segment, at 80 mm/s.
        bench.pass(800_000);
        assert!(bench.state().laser);
        end(&mut bench);
        bench.rest();
        let end = if name == "clear" { 32.0 } else { 40.0 };
        let [x, y, z, _] = bench.pose();
        assert!(
            (y - end).abs() < 1e-3 && [x, z] == [200.0, 0.0],
            "{name}: {y}"
        );
        assert!(!bench.state().laser && !bench.state().moving, "{name}");
        assert_eq!(speed(&mut bench), 0.0, "{name}");
        match name {
            "stop" => bench.start(),
            "clear" => assert_eq!(bench.left_space(), 32),
            _ => bench.set(&ClearAllAlarmsState {}),
        }
        bench.rest();
        let end = if name == "clear" { y } else { 80.0 };
        assert_eq!(bench.pose()[1], end, "{name}");
        assert!(!bench.state().laser, "{name}");
    }
}

#[test]
fn start_in_the_middle_of_a_segment_ends_it_and_begins_the_next() {
    let mut bench = collecting();
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    bench.start();
    bench.pass(300_000);
    bench.set(&QueuedCmdStopExec {});
    bench.pass(200_000);
    // The first segment ends after 0.5 s at 100 mm/s2; the next 50 mm run from rest to rest.
    bench.start();
    lasts(bench.rest(), 2.0 * 0.5_f64.sqrt());
    let way = bench.pose()[1];
    assert!((way - 62.5).abs() < 1e-3, "{way}");
}

#[test]
fn the_laser_burns_along_its_segments_and_never_at_rest() {
    let mut bench = collecting();
    bench.enqueue(&burning([0.0, 20.0, 0.0], 30.0));
    bench.enqueue(&by([0.0, 20.0, 0.0]));
    bench.enqueue(&burning([0.0, 20.0, 0.0], 100.0));
    bench.start();
    let mut seen = Vec::new();
    while bench.state().moving {
        let state = bench.state();
        let burns_here = !(20.0..40.0).contains(&state.pose.y);
        assert_eq!(state.laser, burns_here, "{state:?}");
        if seen.last() != Some(&state.laser) {
            seen.push(state.laser);
        }
        bench.pass(1000);
    }
    assert_eq!(seen, [true, false, true]);
    assert!(!bench.state().laser);
}

#[test]
fn a_force_stop_brakes_and_darkens_a_path() {
    let mut bench = at_start();
    bench.enqueue(&burning([0.0, 50.0, 0.0], 50.0));
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    bench.pass(600_000);
    bench.set(&QueuedCmdForceStopExec {});
    let braked = bench.rest();
    assert!(braked > 0 && braked < 400_000, "{braked}");
    assert!(!bench.state().laser && !bench.state().moving);
    let y = bench.pose()[1];
    assert!(y > 18.0 && y < 45.0, "{y}");
    assert_eq!(bench.left_space(), 31);
}

#[test]
fn whatever_takes_over_from_a_segment_is_dark() {
    let jog = JogCmd {
        is_joint: Flag::ON,
        cmd: magician_protocol::JogCommand::Axis1Minus,
    };
    let replacing: [(&str, Act<'_>); 4] = [
        ("move", &|bench| bench.set(&ptp(7, [0.0, 0.0, 30.0, 0.0]))),
        ("jog", &|bench| bench.set(&jog)),
        ("home", &|bench| bench.set(&arm::home())),
        ("segment", &|bench| bench.set(&by([0.0, 0.0, 5.0]))),
    ];
    for (name, replace) in replacing {
        let mut bench = at_start();
        bench.enqueue(&burning([0.0, 50.0, 0.0], 50.0));
        bench.pass(500_000);
        assert!(bench.state().laser);
        replace(&mut bench);
        assert!(bench.state().moving && !bench.state().laser, "{name}");
    }
}

#[test]
fn a_segment_out_of_reach_is_refused_and_the_path_rests_before_it() {
    let mut bench = collecting();
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    bench.enqueue(&to([900.0, 0.0, 0.0]));
    bench.enqueue(&to([f32::NAN, 0.0, 0.0]));
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    run(&mut bench);
    assert_eq!(bench.alarms(), [0x11]);
    assert_eq!(bench.pose()[..3], [200.0, 25.0, 0.0]);
    bench.set(&ClearAllAlarmsState {});
    assert_eq!(bench.alarms(), [0x11], "the next one");
    bench.set(&ClearAllAlarmsState {});
    bench.rest();
    // The unreachable point is not a start for the next: the last segment counts from where the arm
    // stands.
    assert_eq!(bench.pose()[..3], [200.0, 50.0, 0.0]);
    assert!(bench.alarms().is_empty());
}

#[test]
fn impossible_segments_are_dropped_silently_where_the_profile_says_so() {
    let mut bench = arm::arm_with(|profile| profile.motion.cp_drop_silently = true);
    bench.start();
    bench.enqueue(&ptp(1, START));
    bench.rest();
    bench.set(&QueuedCmdStopExec {});
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    bench.enqueue(&to([900.0, 0.0, 0.0]));
    bench.enqueue(&to([f32::NAN, 0.0, 0.0]));
    bench.enqueue(&by([0.0, 25.0, 0.0]));
    let index = bench.current_index();
    run(&mut bench);
    assert!(bench.alarms().is_empty());
    assert_eq!(bench.current_index(), index + 4, "the index goes on");
    assert_eq!(bench.pose()[..3], [200.0, 50.0, 0.0]);
}

#[test]
fn a_segment_that_leaves_the_limits_on_its_way_ends_there() {
    let mut bench = running_arm();
    bench.no_tool();
    // From one side of the base to the other the straight line leads too close to it.
    bench.enqueue(&ptp(1, [40.0, 140.0, 0.0, 0.0]));
    bench.rest();
    bench.set(&QueuedCmdStopExec {});
    bench.enqueue(&burning([0.0, -20.0, 0.0], 50.0));
    bench.enqueue(&burning([0.0, -260.0, 0.0], 50.0));
    bench.enqueue(&by([0.0, 10.0, 0.0]));
    run(&mut bench);
    assert_eq!(bench.alarms(), [0x22]);
    assert!(!bench.state().moving && !bench.state().laser);
    assert_eq!(bench.current_index(), 3);
    let [x, y, z, _] = bench.pose();
    // The limit J2 - J3 = -70 degrees is a sphere of radius 50.4 mm around the origin.
    let limit = (135.0_f32.powi(2) + 147.0_f32.powi(2)
        - 2.0 * 135.0 * 147.0 * 70.0_f32.to_radians().sin())
    .sqrt();
    assert!((x.hypot(y) - limit).abs() < 1e-3 && y > 0.0, "{x} {y} {z}");
}

#[test]
fn an_immediate_segment_replaces_a_motion_and_the_queue_goes_on_after_it() {
    let mut bench = at_start();
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    bench.enqueue(&to([200.0, 0.0, 10.0]));
    bench.pass(500_000);
    bench.set(&to([210.0, 5.0, 0.0]));
    assert_eq!(bench.current_index(), 2, "the queue's has ended");
    let first = bench.arm.poll_timeout().expect("it moves");
    bench.arm.advance(first - Duration::from_micros(1));
    let pose = bench.state().pose;
    assert!(
        (pose.x - 210.0).abs() + (pose.y - 5.0).abs() < 1e-3,
        "{pose:?}"
    );
    bench.rest();
    assert_eq!(bench.pose()[..3], [200.0, 0.0, 10.0]);
    assert!(bench.alarms().is_empty());
}

#[test]
fn speeds_that_are_none_are_refused_and_a_segment_of_no_length_is_not_missed() {
    for bad in [0.0, -1.0, f32::NAN] {
        let mut bench = at_start();
        bench.set(&speeds(bad, 100.0));
        let index = bench.enqueue(&by([0.0, 10.0, 0.0]));
        assert_eq!((bench.alarms(), bench.current_index()), (vec![0x1A], index));
    }
    let mut bench = collecting();
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    bench.enqueue(&by([0.0; 3]));
    bench.enqueue(&by([0.0, 50.0, 0.0]));
    lasts(run(&mut bench), 2.0);
    assert_eq!(bench.current_index(), 4);
}

#[test]
fn the_sum_of_a_path_does_not_depend_on_how_early_it_is_sent() {
    // A ring in 30 chords of 4.2 mm, within the look-ahead of a full queue: sent at once, then one
    // per millisecond.
    let chords: Vec<CpCmd> = (1..=30)
        .map(|at| {
            let (sin, cos) = (f64::from(at) * 12.0_f64).to_radians().sin_cos();
            to([(180.0 + 20.0 * cos) as f32, (20.0 * sin) as f32, 0.0])
        })
        .collect();
    let mut whole = collecting();
    for chord in &chords {
        whole.enqueue(chord);
    }
    let together = run(&mut whole);
    let mut bench = at_start();
    let began = bench.arm.now();
    for chord in &chords {
        bench.enqueue(chord);
        bench.pass(1000);
    }
    bench.rest();
    let apart = bench.arm.now().micros_since(began);
    assert!(together.abs_diff(apart) < 1000, "{together} {apart}");
    assert_eq!(whole.pose(), bench.pose());
    let mut fresh = arm();
    assert_eq!(fresh.get::<CpParams>(), speeds(100.0, 100.0));
}

/// Before an impossible segment the arm brakes along its path; it does not stop abruptly.
#[test]
fn a_path_comes_to_rest_before_a_segment_that_cannot_be() {
    for bad in [[900.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]] {
        let (mut followed, mut alone) = (running_arm(), running_arm());
        for bench in [&mut followed, &mut alone] {
            bench.enqueue(&to([250.0, 0.0, 0.0]));
        }
        followed.enqueue(&to(bad));
        assert_eq!(followed.rest(), alone.rest());
        assert_eq!(followed.alarms(), [0x11]);
        assert_eq!(followed.state().pose.x, 250.0);
    }
}
