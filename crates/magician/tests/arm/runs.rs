//! Runs: their flow, and their ends.

use std::time::Duration;

use magician::commands::{Pose, WaitCmd};
use magician::protocol::FrameBuf;
use magician::sim::{Controller, LineTiming, Profile, Runner, Speed};
use magician::{
    Action, Arm, Ctrl, ErrorCode, ErrorKind, Options, Remedy, RunOptions, Setting, SettingValue,
    build,
};
use tokio::time::{Instant, sleep};

use crate::bench::{real_time, runner};
use crate::desk::{Desk, begin_immediate_motion};

#[tokio::test(start_paused = true)]
async fn a_queue_longer_than_the_arms_flows_and_never_overruns() {
    for window in [1, 4] {
        let options = Options::default().window(window);
        let arm = Arm::simulated(runner(Speed::Times(1.0)), options)
            .await
            .unwrap();
        let wait = build::wait(Duration::from_millis(20));
        let mut seen = 0;
        let begun = Instant::now();
        let ran = arm
            .start(std::iter::repeat_n(wait, 200))
            .wait(|progress| {
                assert!(progress.current.0 >= seen);
                assert!(progress.sent + 1 - progress.current.0.max(1) <= 32);
                seen = progress.current.0;
                assert_eq!(progress.total, Some(200));
            })
            .await
            .unwrap();
        assert_eq!(
            (ran.commands, ran.first.unwrap().0, ran.last.unwrap().0),
            (200, 2, 201)
        );
        assert_eq!(seen, 201);
        // The queue never ran dry: the waits alone take four seconds.
        let took = begun.elapsed();
        assert!(
            took < Duration::from_millis(4600),
            "window {window}: {took:?}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn a_stop_while_a_program_is_checked_ends_it() {
    let arm = real_time().await;
    let (stops, before) = (arm.stops(), arm.get::<Pose>().await.unwrap());
    let check = arm.preflight().await.unwrap();
    arm.stop().await.unwrap();
    let options = RunOptions::default().unless_stopped_since(stops);
    let run = arm.start_with([build::move_by(0.0, 40.0, 0.0, 0.0)], options);
    let mut run = run.along(check);
    let error = run.wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed);
    assert_eq!(arm.queue().current_index().await.unwrap().0, 0);
    assert!(!arm.moving());
    assert_eq!(arm.get::<Pose>().await.unwrap(), before);
}

#[tokio::test(start_paused = true)]
async fn a_stop_from_another_task_ends_a_run() {
    let arm = std::sync::Arc::new(real_time().await);
    let running = {
        let arm = std::sync::Arc::clone(&arm);
        let moves = (0..100).map(|at| match at % 2 {
            0 => build::move_to(200.0, 100.0, 50.0, 0.0),
            _ => build::move_to(200.0, -100.0, 50.0, 0.0),
        });
        tokio::spawn(async move { arm.start(moves.collect::<Vec<_>>()).wait(|_| {}).await })
    };
    tokio::time::sleep(Duration::from_secs(3)).await;
    arm.stop().await.unwrap();
    let before: Pose = arm.get().await.unwrap();
    tokio::time::sleep(Duration::from_secs(5)).await;
    let after: Pose = arm.get().await.unwrap();
    assert_eq!(before, after);
    assert_eq!(arm.queue().left_space().await.unwrap(), 32);
    let outcome = tokio::time::timeout(Duration::from_secs(120), running).await;
    let outcome = outcome.expect("it ends").unwrap();
    assert_eq!(outcome.unwrap_err().kind(), ErrorKind::Closed);
    // Another run works again.
    arm.start([build::move_to(200.0, 0.0, 50.0, 0.0)])
        .wait(|_| {})
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn will_not_start_what_others_left_behind() {
    let mut controller = Controller::new(Profile::default());
    let left = FrameBuf::encode(110, Ctrl::QUEUED, &WaitCmd { timeout: 10 }).unwrap();
    controller.receive(magician::sim::LinkId(7), left.bytes());
    let runner = Runner::new(controller, Speed::Max, LineTiming::default());
    let arm = Arm::simulated(runner, Options::default()).await.unwrap();
    let mine = [build::wait(Duration::from_millis(1))];
    let error = arm.start(mine).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    assert_eq!(error.code(), ErrorCode::ForeignCommands);
    let ways = [
        Remedy::new(Action::Stop, "drops it"),
        Remedy::new((Setting::Keep, SettingValue::On), "runs it"),
    ];
    assert_eq!(error.remedies(), ways);
    assert_eq!(
        arm.queue().left_space().await.unwrap(),
        31,
        "nothing was sent"
    );
    arm.start_with(mine, RunOptions::default().keep(true))
        .wait(|_| {})
        .await
        .unwrap();
}

/// A start in the middle of a motion would cut it off.
#[tokio::test(start_paused = true)]
async fn queue_of_an_arm_that_moves_is_started_when_the_arm_stands() {
    for empty in [true, false] {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        begin_immediate_motion(&arm).await;
        if empty {
            assert!(arm.queue().start_if_empty().await.unwrap());
        } else {
            arm.queue().start().await.unwrap();
        }
        let Pose { x, y, z, .. } = arm.get().await.unwrap();
        assert_eq!([x, y, z], [220.0, 60.0, 20.0]);
        assert!(desk.with(|arm| arm.state().queue.started));
    }
}

#[tokio::test(start_paused = true)]
async fn queue_that_runs_a_motion_is_not_started_again() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    arm.queue().start().await.unwrap();
    let there = build::line_to(220.0, 60.0, 20.0, 0.0);
    let index = arm.enqueue_set(&there).await.unwrap();
    sleep(Duration::from_millis(300)).await;
    desk.heard();
    arm.queue().start().await.unwrap();
    assert_eq!(desk.count(240), 0);
    arm.wait(index).await.unwrap();
    let Pose { x, y, z, .. } = arm.get().await.unwrap();
    assert_eq!([x, y, z], [220.0, 60.0, 20.0]);
}

#[tokio::test(start_paused = true)]
async fn an_index_that_was_cleared_will_not_come() {
    let arm = std::sync::Arc::new(real_time().await);
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 1_000 }).await.unwrap();
    let dropped = arm.enqueue(&WaitCmd { timeout: 1_000 }).await.unwrap();
    arm.queue().clear().await.unwrap();
    let begun = Instant::now();
    let error = arm.wait(dropped).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    assert!(error.to_string().contains("will not come"), "{error}");
    assert!(begun.elapsed() < Duration::from_secs(5));
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_is_reset_ends_a_wait_and_says_what_is_gone() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let wait = build::wait(Duration::from_millis(500));
    let mut run = arm.start(std::iter::repeat_n(wait, 30));
    let resetting = async {
        sleep(Duration::from_secs(2)).await;
        desk.reset();
    };
    let (ended, ()) = tokio::join!(run.wait(|_| {}), resetting);
    let error = ended.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    assert!(error.to_string().contains("reset"), "{error}");
    let (from, to) = (error.from_index().unwrap(), error.to_index().unwrap());
    assert!(from > 1, "{error}");
    assert!(
        to - from <= 4,
        "no more than two seconds were queued: {error}"
    );
    assert_eq!(
        arm.queue().left_space().await.unwrap(),
        32,
        "nothing was sent again"
    );
    arm.start([wait]).wait(|_| {}).await.unwrap();
}

/// Returns an arm on a line that stalls now and then, each time for this long.
async fn held_now_and_then(seconds: u64, rate: f64) -> Arm {
    let ms = seconds * 1000;
    let faults = format!("stall={rate},stall-min-ms={ms},stall-ms={ms},only=replies,seed=3");
    let options = Options::default()
        .probe(false)
        .faults(faults.parse().unwrap());
    let arm = Arm::simulated(runner(Speed::Times(1.0)), options).await;
    arm.unwrap()
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_held_does_not_end_a_run() {
    for (seconds, rate) in [(1, 0.03), (3, 0.03), (8, 0.03), (20, 0.01)] {
        let arm = held_now_and_then(seconds, rate).await;
        let wait = build::wait(Duration::from_millis(20));
        let mut silent = Duration::ZERO;
        let told = |progress: magician::Progress| silent = silent.max(progress.silent);
        let ran = arm.start(std::iter::repeat_n(wait, 200)).wait(told).await;
        let ran = ran.unwrap_or_else(|error| panic!("held for {seconds} s: {error}"));
        assert_eq!((ran.commands, ran.last.unwrap().0), (200, 201));
        let least = Duration::from_secs(seconds - 1);
        assert!(
            silent >= least && silent < Duration::from_secs(30),
            "{silent:?}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn a_patient_handle_waits_for_a_line_that_is_held() {
    let (mut hasty, mut patient) = (0, 0);
    for (patience, failed) in [(0, &mut hasty), (30, &mut patient)] {
        let arm = held_now_and_then(8, 0.1).await;
        let arm = arm.front_end().patient(Duration::from_secs(patience));
        for _ in 0..20 {
            *failed += u32::from(arm.get::<Pose>().await.is_err());
        }
    }
    assert!(hasty > 0);
    assert_eq!(patient, 0);
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_held_for_longer_than_a_runs_patience_ends_it_and_calls_end_as_ever() {
    let arm = held_now_and_then(60, 1.0).await;
    let begun = Instant::now();
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(begun.elapsed() < Duration::from_millis(3100));
    for seconds in [30, 5, 1] {
        let begun = Instant::now();
        let patience = Duration::from_secs(seconds);
        let options = RunOptions::default().patience(patience);
        let wait = build::wait(Duration::from_millis(20));
        let mut run = arm.start_with(std::iter::repeat_n(wait, 20), options);
        let error = run.wait(|_| {}).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
        let (took, least) = (begun.elapsed(), patience.max(Duration::from_secs(3)));
        assert!(
            took >= least && took < least + Duration::from_secs(4),
            "{took:?}"
        );
    }
}
