//! Streaming runs on an arm in virtual time: the arm does not pause between commands, and the
//! source is never further ahead than allowed.

use std::time::Duration;

use magician::protocol::Set;
use magician::sim::{ArmInstant, Controller, ExternalEvent};
use magician::{
    Arm, ErrorKind, Feeder, Options, Result, RunOptions, RunSummary, SimSpeed, VirtualArm, build,
};
use tokio::task::yield_now;
use tokio::time::sleep;

async fn arm() -> (VirtualArm, Arm) {
    let cell = VirtualArm::default().in_virtual_time();
    let options = Options::default().timeout(Duration::from_secs(1));
    let arm = Arm::simulated(cell.clone(), options).await.unwrap();
    arm.clear_alarms().await.unwrap();
    (cell, arm)
}

/// Returns a curve in short segments.
fn curve(pieces: u16) -> Vec<Set> {
    let mut program = vec![
        build::path_speed(100.0, 100.0),
        build::move_to(255.0, 0.0, 20.0, 0.0),
    ];
    program.extend((1..=pieces).map(|nth| {
        let (sin, cos) = (f32::from(nth) * 0.02).sin_cos();
        build::path_to(225.0 + 30.0 * cos, 30.0 * sin, 20.0)
    }));
    program
}

fn clock(cell: &VirtualArm) -> Duration {
    cell.state().now - ArmInstant::ZERO
}

/// Pushes commands one by one, each after a wall-clock pause; returns how many were accepted.
async fn tell(feeder: Feeder, program: &[Set], pause: Duration) -> usize {
    let mut told = 0;
    for command in program {
        if !feeder.has_room().await {
            break;
        }
        if !pause.is_zero() {
            sleep(pause).await;
        }
        feeder.push(*command);
        told += 1;
    }
    told
}

async fn stream(
    arm: &Arm,
    ahead: usize,
    program: &[Set],
    pause: Duration,
) -> (Result<RunSummary>, usize) {
    let (feeder, run) = arm.stream(ahead, RunOptions::default());
    tokio::join!(run.wait(|_| {}), tell(feeder, program, pause))
}

#[tokio::test(start_paused = true)]
async fn a_path_that_is_told_while_it_runs_takes_the_time_of_one_that_is_known() {
    for pause in [Duration::ZERO, Duration::from_millis(300)] {
        let (cell, arm) = arm().await;
        let program = curve(300);
        let check = arm.preflight_for(&program).await.unwrap();
        let estimate = check.estimate(&program).unwrap();
        let before = clock(&cell);
        let (ran, told) = stream(&arm, 40, &program, pause).await;
        assert_eq!((ran.unwrap().commands, told), (302, 302));
        let took = clock(&cell) - before;
        assert_eq!(took, estimate, "after {pause:?} each");
    }
    // Commands pushed one by one make it stop in between.
    let (cell, arm) = arm().await;
    let program = curve(300);
    let check = arm.preflight_for(&program).await.unwrap();
    let estimate = check.estimate(&program).unwrap();
    let before = clock(&cell);
    for piece in program.chunks(40) {
        arm.run(piece).await.unwrap();
    }
    assert!(clock(&cell) - before > estimate.mul_f64(1.1));
}

#[tokio::test(start_paused = true)]
async fn few_commands_ahead_are_enough_not_to_stop_at_corners() {
    let (cell, arm) = arm().await;
    let program = curve(60);
    arm.run(&program[..2]).await.unwrap();
    // The arm's speed, mm/s, sampled from outside 100 times a second of its clock.
    let before = clock(&cell);
    let (feeder, run) = arm.stream(4, RunOptions::default());
    let (ran, _) = tokio::join!(
        run.wait(|_| {}),
        tell(feeder, &program[2..], Duration::ZERO)
    );
    ran.unwrap();
    let flowing = clock(&cell) - before;
    arm.run(&program[1..2]).await.unwrap();
    let before = clock(&cell);
    for piece in program[2..].chunks(4) {
        arm.run(piece).await.unwrap();
    }
    let stopping = clock(&cell) - before;
    // At 100 mm/s2 four segments of 0.6 mm from rest to rest take 5, 2, 2 and 5 periods of 20 ms.
    // In the flow each takes 2, except the first and the last.
    let periods = |count: u32| count * Duration::from_millis(20);
    assert!(
        flowing <= periods(60 * 2 + 6) && stopping >= periods(60 / 4 * 14),
        "{flowing:?} {stopping:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn the_source_is_no_more_before_the_arm_than_was_allowed() {
    let (cell, arm) = arm().await;
    for ahead in [1, 3, 32, 100] {
        let (feeder, run) = arm.stream(ahead, RunOptions::default());
        let begun = cell.state().queue.current_index;
        let told = async {
            let mut most = 0;
            for told in 1..=200_u64 {
                assert!(feeder.has_room().await);
                feeder.push(build::wait(Duration::from_millis(20)));
                let done = cell.state().queue.current_index - begun;
                most = most.max(told - done);
            }
            feeder.end();
            most
        };
        let (ran, most) = tokio::join!(run.wait(|_| {}), told);
        assert_eq!(ran.unwrap().commands, 200);
        assert!(most <= ahead as u64, "{most} of {ahead}");
        assert!(ahead > 32 || most == ahead as u64, "{most} of {ahead}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_refused_command_ends_the_program_after_those_before_it() {
    let (_, arm) = arm().await;
    let mut program = curve(10);
    program.push(build::move_to(900.0, 0.0, 0.0, 0.0));
    program.extend(curve(100));
    let (ran, told) = stream(&arm, 5, &program, Duration::ZERO).await;
    let error = ran.unwrap_err();
    assert_eq!(
        (error.kind(), error.step()),
        (ErrorKind::Unreachable, Some(12))
    );
    assert!((13..=18).contains(&told), "{told}");
    assert_eq!(arm.queue().current_index().await.unwrap().0, 13);
    // The first command is refused, so none runs.
    let far = [build::line_to(400.0, 0.0, 0.0, 0.0)];
    let (ran, _) = stream(&arm, 5, &far, Duration::ZERO).await;
    assert_eq!(ran.unwrap_err().step(), Some(0));
    let (ran, _) = stream(&arm, 5, &[], Duration::ZERO).await;
    assert_eq!(ran.unwrap().commands, 0);
}

#[tokio::test(start_paused = true)]
async fn nothing_is_sent_after_a_stop() {
    let (cell, arm) = arm().await;
    let program = curve(2000);
    let stop = async {
        while cell.state().queue.current_index < 100 {
            yield_now().await;
        }
        arm.stop().await.unwrap();
        cell.state().queue.current_index
    };
    let (streamed, stopped) = tokio::join!(stream(&arm, 32, &program, Duration::ZERO), stop);
    assert_eq!(streamed.0.unwrap_err().kind(), ErrorKind::Closed);
    assert!(streamed.1 < 200, "{}", streamed.1);
    sleep(Duration::from_secs(5)).await;
    let state = cell.state();
    assert!(!state.moving && state.queue.waiting == 0);
    assert!(state.queue.current_index <= stopped + 1);
}

/// A source that waits for the arm, or for an event in its world.
#[tokio::test(start_paused = true)]
async fn a_source_that_has_nothing_for_now_lets_time_pass() {
    let (cell, arm) = arm().await;
    let (feeder, run) = arm.stream(8, RunOptions::default());
    let told = async {
        feeder.push(build::wait(Duration::from_secs(60)));
        while cell.state().queue.current_index < 1 {
            feeder.rest().await;
        }
        let until = clock(&cell) + Duration::from_secs(2);
        while clock(&cell) < until {
            feeder.rest().await;
        }
        feeder.push(build::wait(Duration::from_secs(1)));
        feeder.end();
    };
    let begun = tokio::time::Instant::now();
    let (ran, ()) = tokio::join!(run.wait(|_| {}), told);
    assert_eq!(ran.unwrap().commands, 2);
    // A minute of waiting took no wall-clock time; only the arm at rest follows the wall clock.
    assert!(
        begun.elapsed() < Duration::from_secs(3),
        "{:?}",
        begun.elapsed()
    );
    assert!(clock(&cell) >= Duration::from_secs(63));
}

#[tokio::test(start_paused = true)]
async fn a_laser_is_dark_while_the_source_has_nothing() {
    let cell = VirtualArm::new(Controller::default(), SimSpeed::Times(1.0));
    let arm = Arm::simulated(cell.clone(), Options::default()).await;
    let arm = arm.unwrap().allowing_laser();
    arm.clear_alarms().await.unwrap();
    let (feeder, run) = arm.stream(8, RunOptions::default());
    let told = async {
        feeder.push(build::line_to(220.0, 0.0, 20.0, 0.0));
        feeder.push(build::laser(true));
        for [x, y] in [[220.0, 20.0], [220.0, 60.0], [240.0, 60.0], [240.0, 0.0]] {
            assert!(feeder.has_room().await);
            feeder.push(build::line_to(x, y, 20.0, 0.0));
            let (mut lit, mut burnt_in) = (0, 0);
            for _ in 0..400 {
                sleep(Duration::from_millis(10)).await;
                let state = cell.state();
                lit += u32::from(state.laser);
                burnt_in += u32::from(state.laser && !state.moving);
            }
            assert!(!cell.state().laser && !cell.state().moving, "at {x}, {y}");
            assert!(
                lit > 10 && burnt_in < 2,
                "lit {lit}, {burnt_in} at rest: {x}, {y}"
            );
        }
        feeder.push(build::laser(false));
        feeder.end();
    };
    let (ran, ()) = tokio::join!(run.wait(|_| {}), told);
    ran.unwrap();
    assert!(!cell.state().laser);
}

#[tokio::test(start_paused = true)]
async fn a_laser_that_no_gap_would_put_out_is_refused() {
    let (cell, arm) = arm().await;
    let arm = arm.allowing_laser();
    let program = [
        build::line_to(220.0, 0.0, 20.0, 0.0),
        build::output(4, true),
    ];
    let (ran, _) = stream(&arm, 8, &program, Duration::ZERO).await;
    let error = ran.unwrap_err();
    assert_eq!(
        (error.kind(), error.step()),
        (ErrorKind::InvalidInput, Some(1))
    );
    arm.set_any(&build::laser(true)).await.unwrap();
    let (ran, _) = stream(&arm, 8, &program[..1], Duration::ZERO).await;
    assert_eq!(ran.unwrap_err().kind(), ErrorKind::InvalidInput);
    assert_eq!(cell.state().queue.current_index, 2);
}

#[tokio::test(start_paused = true)]
async fn an_alarm_ends_a_program_that_is_told() {
    let (cell, arm) = arm().await;
    let program = curve(2000);
    let alarm = async {
        while cell.state().queue.current_index < 100 {
            yield_now().await;
        }
        cell.with(|arm| arm.inject(ExternalEvent::Reset));
    };
    let (streamed, ()) = tokio::join!(stream(&arm, 32, &program, Duration::ZERO), alarm);
    assert!(streamed.0.is_err());
    assert!(streamed.1 < 300);
}

#[tokio::test(start_paused = true)]
async fn an_iterator_is_not_asked_after_its_end() {
    let (_, arm) = arm().await;
    for end in [1, 2, 40, 100] {
        let mut asked = 0;
        let source = std::iter::from_fn(|| {
            asked += 1;
            (asked != end).then(|| build::wait(Duration::from_millis(1)))
        });
        let ran = arm.start(source).wait(|_| {}).await.unwrap();
        assert_eq!(ran.commands, end - 1);
    }
}
