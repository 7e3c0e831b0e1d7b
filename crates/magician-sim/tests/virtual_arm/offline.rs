//! Stored programs: downloaded through the queue, run by the base key (model section 12).

use super::arm::{
    Micros, SECOND, TestArm, arm_with, home, homing_lasts, joints_to, ptp, running_arm, wait,
};
use magician_protocol::commands::*;
use magician_protocol::{CpMode, Ctrl};
use magician_sim::world::Press;
use magician_sim::{Event, ExternalEvent};

fn download(bench: &mut TestArm, total_loop: u32, lines: impl FnOnce(&mut TestArm)) {
    bench.set(&QueuedCmdStartDownload {
        total_loop,
        line_per_loop: 2,
    });
    lines(bench);
    bench.set(&QueuedCmdStopDownload {});
}

/// A running arm with a stored program: J1 by 10 degrees, a wait of a second, `loops` passes.
fn downloaded(loops: u32) -> TestArm {
    let mut bench = running_arm();
    download(&mut bench, loops, |bench| {
        bench.enqueue(&ptp(6, [10.0, 0.0, 0.0, 0.0]));
        bench.enqueue(&wait(1000));
    });
    bench
}

/// Duration of a move by 10 degrees at 100 deg/s and 100 deg/s2.
fn step() -> Micros {
    (2.0 * (0.1f64).sqrt() * 1e6).ceil() as Micros
}

#[test]
fn stored_commands_have_an_index_and_do_not_run() {
    let mut bench = running_arm();
    assert_eq!(bench.enqueue(&wait(1)), 1);
    bench.rest();
    bench.events();
    download(&mut bench, 1, |bench| {
        assert_eq!(bench.enqueue(&joints_to([10.0, 45.0, 45.0, 0.0])), 2);
        assert_eq!(bench.enqueue(&wait(100)), 3);
        assert_eq!(bench.left_space(), 32);
    });
    assert!(bench.events().iter().any(|event| matches!(
        event,
        Event::Downloaded {
            stored: 2,
            announced: 2
        }
    )));
    assert_eq!(bench.arm.flash().program(), (2, 1));
    assert_eq!(bench.rest(), 0);
    assert_eq!(bench.current_index(), 1);
    assert_eq!(bench.enqueue(&wait(1)), 4);
    bench.rest();
    assert_eq!(bench.current_index(), 4, "it passes over them");
}

#[test]
fn the_key_runs_the_program_as_often_as_it_says() {
    let mut bench = downloaded(3);
    bench.arm.press(Press::Short);
    assert!(bench.state().program && bench.state().moving);
    assert_eq!(bench.rest(), 3 * (step() + SECOND));
    assert!(!bench.state().program);
    assert_eq!(bench.joints()[0], 30.0);
    assert_eq!(bench.current_index(), 0, "it is none of the queue's");
    bench.arm.press(Press::Short);
    bench.rest();
    assert_eq!(bench.joints()[0], 60.0);
}

#[test]
fn it_needs_no_start_of_the_queue() {
    let mut bench = downloaded(1);
    bench.set(&QueuedCmdStopExec {});
    bench.arm.press(Press::Short);
    bench.rest();
    assert_eq!(bench.joints()[0], 10.0);
    assert!(!bench.state().queue.started);
}

#[test]
fn the_hosts_queue_takes_commands_and_waits_meanwhile() {
    let mut bench = downloaded(2);
    bench.arm.press(Press::Short);
    assert_eq!(bench.enqueue(&joints_to([-20.0, 45.0, 45.0, 0.0])), 3);
    assert_eq!(bench.left_space(), 31);
    let state = bench.state();
    assert_eq!((state.queue.waiting, state.queue.running), (1, None));
    bench.pass(2 * (step() + SECOND) - 1);
    assert_eq!(bench.current_index(), 0);
    assert_eq!(bench.joints()[0], 20.0);
    bench.pass(1);
    assert!(!bench.state().program && bench.state().moving);
    bench.rest();
    assert_eq!(bench.joints()[0], -20.0);
    assert_eq!(bench.current_index(), 3);
}

#[test]
fn it_begins_when_the_hosts_command_has_finished() {
    let mut bench = downloaded(1);
    bench.enqueue(&wait(2000));
    bench.enqueue(&joints_to([-20.0, 45.0, 45.0, 0.0]));
    bench.pass(SECOND);
    bench.arm.press(Press::Short);
    assert!(!bench.state().program);
    bench.pass(SECOND);
    assert!(bench.state().program);
    assert_eq!(bench.current_index(), 3);
    bench.pass(step() + SECOND);
    assert_eq!(bench.joints()[0], 10.0);
    bench.rest();
    assert_eq!(bench.joints()[0], -20.0);
}

#[test]
fn a_path_of_the_host_comes_to_rest_before_it() {
    let mut bench = downloaded(1);
    for x in 1..=20 {
        bench.enqueue(&CpCmd {
            cp_mode: CpMode::Relative,
            x: if x % 2 == 0 { 3.0 } else { 3.1 },
            y: 0.0,
            z: 0.0,
            velocity_or_power: 0.0,
        });
    }
    bench.pass(300_000);
    bench.arm.press(Press::Short);
    let before = bench.state();
    assert!(!before.program);
    bench.pass(SECOND);
    assert!(bench.state().program);
    bench.rest();
    assert_eq!(bench.current_index(), 22);
    // 20 segments, 61 mm in all, interrupted by the program's turn of 10 degrees.
    let (pose, began) = (bench.state().pose, 259.104_13);
    let turned = pose.y.hypot(pose.x) - began;
    assert!((40.0..61.0).contains(&turned), "{turned}");
    assert!(pose.y > 30.0, "{pose:?}");
}

#[test]
fn a_path_in_the_program_flows() {
    let cp = |x: f32| CpCmd {
        cp_mode: CpMode::Relative,
        x,
        y: 0.0,
        z: 0.0,
        velocity_or_power: 0.0,
    };
    let mut live = running_arm();
    live.set(&QueuedCmdStopExec {});
    for _ in 0..25 {
        live.enqueue(&cp(2.0));
    }
    live.start();
    let lasted = live.rest();
    let mut stored = running_arm();
    download(&mut stored, 1, |bench| {
        for _ in 0..25 {
            bench.enqueue(&cp(2.0));
        }
    });
    stored.arm.press(Press::Short);
    assert_eq!(stored.rest(), lasted, "it looks ahead as the queue does");
    assert_eq!(stored.state().pose, live.state().pose);

    // With more commands than the arm reads ahead.
    let mut long = running_arm();
    download(&mut long, 2, |bench| {
        for _ in 0..20 {
            bench.enqueue(&cp(2.0));
        }
        for _ in 0..20 {
            bench.enqueue(&cp(-2.0));
        }
    });
    long.arm.press(Press::Short);
    long.rest();
    assert!((long.state().pose.x - 259.104).abs() < 1e-2);
}

#[test]
fn the_key_stops_it_at_the_end_of_its_motion() {
    let mut bench = downloaded(100);
    bench.arm.press(Press::Short);
    bench.pass(step() + SECOND + step() / 2);
    bench.arm.press(Press::Short);
    assert!(bench.state().program && bench.state().moving);
    bench.rest();
    assert!(!bench.state().program);
    assert_eq!(bench.joints()[0], 20.0);

    bench.arm.press(Press::Short);
    bench.pass(step() + SECOND / 2);
    bench.arm.press(Press::Short);
    assert!(!bench.state().program, "a wait is cut short");
    assert_eq!(bench.rest(), 0);
}

#[test]
fn stop_and_force_stop_end_it_and_clear_does_not() {
    let mut bench = downloaded(100);
    bench.arm.press(Press::Short);
    bench.pass(step() / 2);
    bench.enqueue(&wait(1));
    bench.set(&QueuedCmdClear {});
    assert_eq!(bench.state().queue.waiting, 0);
    bench.pass(step() + SECOND);
    assert!(bench.state().program);
    bench.set(&QueuedCmdStopExec {});
    bench.rest();
    assert_eq!(bench.joints()[0], 20.0);
    assert!(!bench.state().program && !bench.state().queue.started);

    bench.arm.press(Press::Short);
    bench.pass(step() / 2);
    bench.set(&QueuedCmdForceStopExec {});
    bench.rest();
    let j1 = bench.joints()[0];
    assert!(j1 > 24.9 && j1 < 30.0, "{j1}");
    assert!(!bench.state().program);

    bench.enqueue(&wait(100));
    bench.arm.press(Press::Short);
    bench.set(&QueuedCmdForceStopExec {});
    bench.rest();
    bench.start();
    bench.rest();
    assert_eq!(bench.current_index(), 4);
}

#[test]
fn a_long_press_homes() {
    let mut bench = downloaded(100);
    bench.arm.press(Press::Long);
    let lasted = bench.rest() as f64 / 1e6;
    assert!((lasted - homing_lasts(0.0)).abs() < 1e-4);
    assert!(bench.state().homed);

    bench.arm.press(Press::Short);
    bench.pass(step());
    bench.arm.press(Press::Long);
    bench.rest();
    assert!(!bench.state().program);
    assert_eq!(bench.joints()[0], 0.0);
}

#[test]
fn alarms_hold_it_and_homing_in_it_runs_all_the_same() {
    let mut bench = running_arm();
    download(&mut bench, 1, |bench| {
        bench.enqueue(&home());
        bench.enqueue(&ptp(6, [10.0, 0.0, 0.0, 0.0]));
    });
    bench.arm.inject(ExternalEvent::Alarm(0x23));
    bench.arm.press(Press::Short);
    bench.rest();
    assert!(bench.state().homed && bench.state().program);
    bench.set(&ClearAllAlarmsState {});
    bench.rest();
    assert_eq!(bench.joints()[0], 10.0);
    assert!(!bench.state().program);
}

#[test]
fn the_unlock_key_holds_it() {
    let mut bench = downloaded(2);
    bench.arm.press(Press::Short);
    bench.pass(step() / 2);
    bench.arm.unlock(true);
    bench.pass(10 * SECOND);
    let halfway = bench.state().joints.j1;
    assert!((halfway - 5.0).abs() < 1e-3);
    bench.arm.unlock(false);
    bench.rest();
    assert!((bench.state().joints.j1 - halfway - 10.0).abs() < 1e-9);
}

#[test]
fn a_download_during_a_run_is_ignored() {
    let mut bench = downloaded(1);
    bench.arm.press(Press::Short);
    bench.set(&QueuedCmdStartDownload {
        total_loop: 7,
        line_per_loop: 7,
    });
    assert_eq!(bench.enqueue(&wait(5)), 3);
    bench.set(&QueuedCmdStopDownload {});
    assert_eq!(bench.arm.flash().program(), (2, 1));
    bench.rest();
    assert_eq!(bench.current_index(), 3, "it was queued");
}

#[test]
fn the_key_does_nothing_during_a_download_or_without_a_program() {
    let mut bench = running_arm();
    bench.arm.press(Press::Short);
    assert!(!bench.state().program);
    let mut bench = downloaded(1);
    bench.set(&QueuedCmdStartDownload {
        total_loop: 1,
        line_per_loop: 1,
    });
    bench.arm.press(Press::Short);
    assert!(!bench.state().program);
    bench.arm.inject(ExternalEvent::Reset);
    assert_eq!(
        bench.arm.flash().program(),
        (2, 1),
        "one that was not completed leaves the old one"
    );
    bench.arm.press(Press::Short);
    bench.rest();
    assert_eq!(bench.joints()[0], 10.0);

    let mut never = downloaded(0);
    never.arm.press(Press::Short);
    assert_eq!(never.rest(), 0);
}

#[test]
fn capacity_is_bounded() {
    let mut bench = arm_with(|profile| profile.offline.capacity = 3);
    download(&mut bench, 1, |bench| {
        for index in 1..=3 {
            assert_eq!(bench.enqueue(&wait(1)), index);
        }
        let reply = bench.frame(110, Ctrl::QUEUED, &1u32.to_le_bytes());
        assert_eq!(reply.frame().params(), [0; 8]);
        assert_eq!(reply.frame().ctrl(), Ctrl::QUEUED.with_error());
    });
    assert_eq!(bench.arm.flash().program(), (3, 1));
    bench.arm.press(Press::Short);
    assert_eq!(bench.rest(), 3000);
}

#[test]
fn a_program_that_takes_no_time_ends() {
    let mut bench = running_arm();
    download(&mut bench, u32::MAX, |bench| {
        for _ in 0..100 {
            bench.enqueue(&PtpCommonParams {
                velocity_ratio: 70.0,
                acceleration_ratio: 30.0,
            });
        }
    });
    bench.arm.press(Press::Short);
    assert!(!bench.state().program);
    assert_eq!(bench.get::<PtpCommonParams>().velocity_ratio, 70.0);
    assert_eq!(bench.rest(), 0);
}

#[test]
fn it_repeats_for_as_long_as_it_is_told() {
    let mut bench = running_arm();
    download(&mut bench, u32::MAX, |bench| {
        bench.enqueue(&wait(7));
    });
    bench.arm.press(Press::Short);
    bench.pass(60 * SECOND);
    assert!(bench.state().program);
    assert_eq!(bench.current_index(), 0);
}
