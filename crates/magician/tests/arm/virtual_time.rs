//! Arms in virtual time: runs take the arm's time and no wall-clock time. The wall clock of these
//! tests stands while any task has work.

use std::future::Future;
use std::time::Duration;

use magician::faults::Faults;
use magician::protocol::Set;
use magician::protocol::commands::{DeviceTime, Pose};
use magician::sim::{ArmInstant, ControllerState, ExternalEvent, Scenario};
use magician::{Arm, ErrorKind, Options, RunOptions, VirtualArm, blocking, build};
use tokio::task::yield_now;
use tokio::time::Instant;

/// Timeout of a call.
const TIMEOUT: Duration = Duration::from_secs(1);

async fn arm(window: usize) -> (VirtualArm, Arm) {
    let cell = VirtualArm::default().in_virtual_time();
    let arm = another(&cell, window).await;
    arm.clear_alarms().await.unwrap();
    (cell, arm)
}

async fn another(cell: &VirtualArm, window: usize) -> Arm {
    let options = Options::default().window(window).timeout(TIMEOUT);
    Arm::simulated(cell.clone(), options).await.unwrap()
}

/// Returns a curve so finely segmented that the arm needs a full queue to keep its speed.
fn curve(pieces: u16) -> Vec<Set> {
    let mut program = vec![
        build::path_speed(100.0, 100.0),
        build::move_to(255.0, 0.0, 20.0, 0.0),
    ];
    program.extend((1..=pieces).map(|nth| {
        let (sin, cos) = (f32::from(nth) * 0.01).sin_cos();
        build::path_to(225.0 + 30.0 * cos, 30.0 * sin, 20.0)
    }));
    program
}

/// Returns the arm's clock.
fn clock(cell: &VirtualArm) -> Duration {
    cell.state().now - ArmInstant::ZERO
}

/// Returns the first state for which `so` is true, during a run.
async fn once(cell: &VirtualArm, so: impl Fn(&ControllerState) -> bool) -> ControllerState {
    loop {
        let state = cell.state();
        if so(&state) {
            return state;
        }
        yield_now().await;
    }
}

async fn takes<T>(cell: &VirtualArm, work: impl Future<Output = T>) -> (T, Duration, Duration) {
    let (before, begun) = (clock(cell), Instant::now());
    let outcome = work.await;
    (outcome, clock(cell) - before, begun.elapsed())
}

#[tokio::test(start_paused = true)]
async fn a_path_takes_the_time_that_its_estimate_says() {
    for (window, pieces) in [(1, 1500), (4, 1500), (1, 1), (1, 31), (4, 33)] {
        let (cell, arm) = arm(window).await;
        let program = curve(pieces);
        let check = arm.preflight_for(&program).await.unwrap();
        let estimate = check.estimate(&program).unwrap();
        let (ran, arms, walls) = takes(&cell, arm.run(&program)).await;
        assert_eq!(ran.unwrap().commands, program.len() as u64);
        assert_eq!(arms, estimate, "{pieces} pieces, window {window}");
        assert_eq!(walls, Duration::ZERO);
    }
}

#[tokio::test(start_paused = true)]
async fn waits_and_moves_take_their_time_and_none_of_the_walls() {
    let (cell, arm) = arm(1).await;
    let day = build::wait(Duration::from_secs(24 * 3600));
    for program in [vec![day], vec![day, day, day]] {
        let (ran, arms, walls) = takes(&cell, arm.start(program.clone()).wait(|_| {})).await;
        ran.unwrap();
        let days = u32::try_from(program.len()).unwrap();
        assert_eq!(arms, days * Duration::from_secs(24 * 3600));
        assert_eq!(walls, Duration::ZERO);
    }
    let there = [build::line_to(220.0, 40.0, 20.0, 0.0)];
    let estimate = arm.preflight().await.unwrap().estimate(&there).unwrap();
    let (ran, arms, walls) = takes(&cell, arm.run(&there)).await;
    assert_eq!(
        (ran.unwrap().commands, arms, walls),
        (1, estimate, Duration::ZERO)
    );
}

#[tokio::test(start_paused = true)]
async fn what_no_run_waits_for_is_done_at_once() {
    let (cell, arm) = arm(1).await;
    arm.queue().start().await.unwrap();
    let wait = magician::commands::WaitCmd { timeout: 5000 };
    let index = arm.enqueue(&wait).await.unwrap();
    assert_eq!(arm.queue().current_index().await.unwrap(), index);
    assert_eq!(clock(&cell), Duration::from_secs(5));
}

#[tokio::test(start_paused = true)]
async fn an_arm_whose_clock_stands_was_not_reset() {
    let (cell, arm) = arm(1).await;
    let program = curve(100);
    for _ in 0..3 {
        arm.get::<DeviceTime>().await.unwrap();
        arm.run(&program).await.unwrap();
        arm.get::<DeviceTime>().await.unwrap();
        tokio::time::sleep(Duration::from_secs(3600)).await;
    }
    cell.with(|arm| arm.inject(ExternalEvent::Reset));
    arm.get::<DeviceTime>().await.unwrap();
    assert_eq!(
        arm.run(&program).await.unwrap_err().kind(),
        ErrorKind::Uncertain
    );
}

#[tokio::test(start_paused = true)]
async fn everybody_hears_his_own_answers() {
    let (cell, arm) = arm(1).await;
    let (left, right) = (another(&cell, 1).await, another(&cell, 1).await);
    let program = curve(2000);
    let estimate = arm.preflight_for(&program).await.unwrap();
    let estimate = estimate.estimate(&program).unwrap();
    let watch = async |other: &Arm| {
        let mut poses: Vec<Pose> = Vec::new();
        while cell.state().queue.current_index < 2001 {
            poses.push(other.get().await.unwrap());
            assert!(other.queue().current_index().await.unwrap().0 <= 2003);
            yield_now().await;
        }
        poses.dedup();
        poses.len()
    };
    let (ran, arms, _) = takes(&cell, async {
        tokio::join!(arm.run(&program), watch(&left), watch(&right))
    })
    .await;
    ran.0.unwrap();
    assert!(ran.1 > 10 && ran.2 > 10, "{} {}", ran.1, ran.2);
    assert_eq!(arms, estimate);
}

#[tokio::test(start_paused = true)]
async fn a_stop_finds_the_arm_under_way() {
    let (cell, arm) = arm(1).await;
    let program = curve(2000);
    let stop = async {
        let found = once(&cell, |state| state.queue.current_index > 100).await;
        arm.stop().await.unwrap();
        found
    };
    let (ran, found) = tokio::join!(arm.run(&program), stop);
    assert_eq!(ran.unwrap_err().kind(), ErrorKind::Closed);
    let stood = cell.state();
    assert!(!stood.moving && stood.queue.waiting == 0);
    // The arm braked where it was: the commands in its queue did not run first.
    assert!(
        stood.now - found.now < Duration::from_secs(1),
        "{found:?} {stood:?}"
    );
    // The next run finds everything in order.
    let home = [build::move_to(200.0, 0.0, 20.0, 0.0)];
    let estimate = arm.preflight().await.unwrap().estimate(&home).unwrap();
    let (ran, arms, _) = takes(&cell, arm.run(&home)).await;
    assert_eq!((ran.unwrap().commands, arms), (1, estimate));
}

#[tokio::test(start_paused = true)]
async fn whoever_lets_go_of_a_run_leaves_the_clock_to_the_arm() {
    let (cell, arm) = arm(1).await;
    let program = curve(2000);
    tokio::select! {
        biased;
        _ = once(&cell, |state| state.queue.current_index > 100) => {}
        ran = arm.run(&program) => panic!("{ran:?}"),
    }
    // The commands left in its queue run as on an arm at full speed, until a stop.
    once(&cell, |state| !state.moving && state.queue.waiting == 0).await;
    let left = cell.state().queue.current_index;
    assert!((101..200).contains(&left), "{left}");
    arm.stop().await.unwrap();
    arm.run(&[build::move_to(200.0, 0.0, 20.0, 0.0)])
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn an_alarm_ends_a_run() {
    let (cell, arm) = arm(1).await;
    let program = curve(2000);
    let raise = async {
        once(&cell, |state| state.queue.current_index > 100).await;
        cell.with(|arm| arm.inject(ExternalEvent::Alarm(0x20)));
    };
    let (ran, ()) = tokio::join!(arm.run(&program), raise);
    assert_eq!(ran.unwrap_err().kind(), ErrorKind::Alarm);
    assert!(!cell.state().moving);
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_answers_late_goes_on_by_the_wall() {
    let (cell, arm) = arm(1).await;
    cell.with(|arm| arm.inject(ExternalEvent::Delay(Duration::from_millis(30))));
    let wait = build::wait(Duration::from_millis(100));
    let late = async {
        cell.advance(Duration::from_millis(30));
        yield_now().await;
    };
    let mut run = arm.start(vec![wait; 40]);
    let run = async {
        let mut run = std::pin::pin!(run.wait(|_| {}));
        // Without a run nothing lets the late answers arrive.
        loop {
            tokio::select! {
                biased;
                ran = &mut run => return ran,
                () = tokio::time::sleep(Duration::from_millis(30)) => cell.advance(Duration::from_millis(30)),
            }
        }
    };
    late.await;
    let (ran, arms, walls) = takes(&cell, run).await;
    assert_eq!(ran.unwrap().commands, 40);
    assert!(
        arms >= Duration::from_secs(4) && walls > Duration::ZERO,
        "{arms:?} {walls:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_pulled_cable_ends_a_run_and_the_arm_goes_on_by_the_wall_meanwhile() {
    let (cell, arm) = arm(1).await;
    let program = curve(2000);
    let pull = async {
        once(&cell, |state| state.queue.current_index > 100).await;
        cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged: false }));
        clock(&cell)
    };
    let begun = Instant::now();
    let (ran, pulled) = tokio::join!(arm.run(&program), pull);
    let error = ran.unwrap_err();
    assert!(
        matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Uncertain),
        "{error}"
    );
    assert!(begun.elapsed() >= TIMEOUT);
    // The arm has finished its commands.
    let passed = clock(&cell) - pulled;
    // The arm may be ahead by its current period.
    let ahead = Duration::from_millis(20);
    assert!(passed <= begun.elapsed() + ahead, "{passed:?}");
    assert!(!cell.state().moving);
}

/// The arm has finished long before the cable returns, which follows the arm's own clock.
#[tokio::test(start_paused = true)]
async fn a_run_goes_on_when_a_scenario_puts_the_cable_in_again() {
    let fault = r#"fault = [{ kind = "cable", index = 60, for = 5 }]"#;
    let cell = VirtualArm::in_scenario(&Scenario::from_toml(fault).unwrap()).in_virtual_time();
    let arm = another(&cell, 1).await;
    arm.clear_alarms().await.unwrap();
    let begun = Instant::now();
    let ran = arm.run(&curve(200)).await.unwrap();
    assert_eq!((ran.commands, cell.state().line.pulls), (202, 1));
    assert!(begun.elapsed() < Duration::from_secs(10));
}

/// A program that reads the arm's state before it computes the next command: it sees that the
/// previous ones are done.
#[test]
fn a_program_may_wait_for_the_arm() {
    let cell = VirtualArm::default().in_virtual_time();
    let arm = blocking::Arm::simulated(cell.clone(), Options::default()).unwrap();
    let wait = build::wait(Duration::from_millis(10));
    let commands = (0..40).map(|nth| {
        while nth == 39 && cell.state().queue.current_index < 40 {
            std::thread::yield_now();
        }
        wait
    });
    let ran = arm.start(commands).wait(|_| {}).unwrap();
    assert_eq!(ran.commands, 40);
    assert!(cell.state().now.as_micros() >= 400_000);
}

/// Programs that interleave commands cannot rely on their indices, and report it; neither waits
/// forever.
#[tokio::test(start_paused = true)]
async fn of_two_programs_at_once_none_waits_for_the_other() {
    let (cell, arm) = arm(1).await;
    let other = another(&cell, 1).await;
    let wait = build::wait(Duration::from_millis(500));
    let keep = RunOptions::default().keep(true);
    for count in [1, 3, 60] {
        let begun = Instant::now();
        let mut ours = arm.start_with(vec![wait; count], keep);
        let mut theirs = other.start_with(vec![wait; count], keep);
        let (ours, theirs) = tokio::join!(ours.wait(|_| {}), theirs.wait(|_| {}));
        for ran in [ours, theirs] {
            match ran {
                Ok(ran) => assert_eq!(ran.commands, count as u64),
                Err(error) => assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}"),
            }
        }
        once(&cell, |state| state.queue.waiting == 0).await;
        assert_eq!(begun.elapsed(), Duration::ZERO);
    }
}

#[tokio::test(start_paused = true)]
async fn on_a_line_that_loses_answers_every_command_is_done_once() {
    let mut whole = 0;
    for seed in 0..20 {
        let cell = VirtualArm::default().in_virtual_time();
        let faults = Faults {
            drop_chunk: 0.05,
            seed,
            ..Faults::default()
        };
        let options = Options::default()
            .timeout(Duration::from_secs(10))
            .faults(faults);
        let arm = Arm::simulated(cell.clone(), options).await.unwrap();
        arm.clear_alarms().await.unwrap();
        let wait = build::wait(Duration::from_millis(50));
        match arm.start(vec![wait; 60]).wait(|_| {}).await {
            Ok(ran) => {
                assert_eq!(ran.commands, 60);
                whole += 1;
            }
            // The first one, whose index has no predecessor.
            Err(error) => assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}"),
        }
        assert!(
            [0, 61].contains(&cell.state().queue.current_index),
            "{seed}"
        );
    }
    assert!(whole > 10, "{whole}");
}

/// A connection that ends during a program stops the arm before the rest runs at once.
#[tokio::test(start_paused = true)]
async fn last_handle_dropped_during_run_stops_arm() {
    let (cell, arm) = arm(1).await;
    let other = another(&cell, 1).await;
    let run = tokio::spawn(async move { arm.start(curve(2000)).wait(|_| {}).await.map(drop) });
    let found = once(&cell, |state| state.queue.current_index > 100).await;
    run.abort();
    let _ = run.await;
    once(&cell, |state| !state.moving).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let state = cell.state();
    assert_eq!(state.queue.waiting, 0, "{state:?}");
    assert!(
        state.now - found.now < Duration::from_secs(1),
        "{:?} {:?}",
        found.now,
        state.now
    );
    other.get::<Pose>().await.unwrap();
}

/// A program that arrives while a jog is ending begins when the arm is at rest.
#[tokio::test(start_paused = true)]
async fn a_jog_that_is_being_ended_brakes_before_a_program_begins() {
    let (cell, arm) = arm(1).await;
    let jog = arm.jog(build::Axis::J1.plus()).await.unwrap();
    cell.advance(Duration::from_millis(400));
    assert!(cell.state().moving);
    let begun = Instant::now();
    drop(jog);
    let wait = build::wait(Duration::from_millis(100));
    let mut run = arm.start([wait]);
    let (ran, ()) = tokio::join!(run.wait(|_| {}), async {
        while !cell.state().queue.started {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let state = cell.state();
        assert!(!state.moving || state.queue.running.is_some(), "{state:?}");
    });
    ran.unwrap();
    assert!(
        begun.elapsed() < Duration::from_millis(200),
        "{:?}",
        begun.elapsed()
    );
}

/// Runs many short moves, one run each, as programs do that draw a line at a time.
async fn single_moves(arm: &Arm, count: u16) {
    for nth in 0..count {
        let x = 200.0 + f32::from(nth % 40);
        arm.run(&[build::line_to(x, 0.0, 20.0, 0.0)]).await.unwrap();
    }
}

#[tokio::test(start_paused = true)]
async fn an_arm_at_full_speed_takes_none_of_the_walls_time_for_a_run() {
    let arm = Arm::connect_with("sim", Options::default()).await.unwrap();
    arm.clear_alarms().await.unwrap();
    let begun = Instant::now();
    single_moves(&arm, 100).await;
    assert!(
        begun.elapsed() < Duration::from_millis(20),
        "{:?}",
        begun.elapsed()
    );
}

#[tokio::test(start_paused = true)]
async fn an_arm_at_full_speed_takes_for_a_run_what_one_in_virtual_time_takes() {
    let program = curve(200);
    let mut took = Vec::new();
    for cell in [
        VirtualArm::default(),
        VirtualArm::default().in_virtual_time(),
    ] {
        let arm = another(&cell, 1).await;
        arm.clear_alarms().await.unwrap();
        let (ran, took_arm, took_wall) = takes(&cell, arm.run(&program)).await;
        ran.unwrap();
        assert!(took_wall < Duration::from_millis(20), "{took_wall:?}");
        took.push(took_arm);
    }
    assert_eq!(took[0], took[1]);
}

#[tokio::test(start_paused = true)]
async fn between_runs_an_arm_at_full_speed_goes_by_the_wall() {
    let cell = VirtualArm::default();
    let arm = another(&cell, 1).await;
    arm.clear_alarms().await.unwrap();
    single_moves(&arm, 3).await;
    let (before, at) = (clock(&cell), cell.state().pose);
    tokio::time::sleep(Duration::from_secs(5)).await;
    assert_eq!(clock(&cell) - before, Duration::from_secs(5));
    assert_eq!(cell.state().pose, at);
}
