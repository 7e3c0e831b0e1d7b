//! Jogs as a dead man's control.

use std::time::Duration;

use magician::commands::JogCommonParams;
use magician::{Arm, ErrorKind, JogOptions, Options, build};
use tokio::io::duplex;
use tokio::time::{Instant, sleep};

use crate::desk::Desk;

const JOG: u8 = 73;

fn turn() -> build::JogDirection {
    build::Axis::J1.plus()
}

#[tokio::test(start_paused = true)]
async fn a_jog_lasts_as_long_as_it_is_kept_up() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    for _ in 0..10 {
        sleep(Duration::from_millis(250)).await;
        jog.keep().unwrap();
        assert!(desk.moves());
    }
    sleep(Duration::from_millis(290)).await;
    assert_eq!(desk.count(JOG), 1, "nothing but its beginning was sent");
    sleep(Duration::from_millis(20)).await;
    assert_eq!(desk.count(JOG), 1, "its end");
    sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
    assert!(!arm.moving());
    let error = jog.keep().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_guard_that_is_dropped_and_one_that_stops() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    assert!(desk.moves());
    drop(jog);
    sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
    let jog = arm.jog(build::Axis::Z.plus()).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    assert!(desk.moves());
    jog.stop().await.unwrap();
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn a_guard_that_is_the_last_handle_still_ends_it() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    drop(arm);
    sleep(Duration::from_millis(200)).await;
    assert!(desk.moves());
    drop(jog);
    sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_is_not_answered_is_said_again() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    desk.heard();
    desk.swallow(&[JOG]);
    let stopping = tokio::spawn(jog.stop());
    sleep(Duration::from_secs(2)).await;
    let said = desk.count(JOG);
    assert!((3..10).contains(&said), "{said}");
    assert!(!stopping.is_finished(), "nobody has confirmed it");
    desk.swallow(&[]);
    stopping.await.unwrap().unwrap();
    assert!(!desk.moves());
    desk.heard();
    sleep(Duration::from_secs(5)).await;
    assert_eq!(desk.heard(), [], "then it is quiet");
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_cannot_be_confirmed_is_said_on_and_on() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    desk.swallow(&[JOG, 10]);
    let begun = Instant::now();
    let error = jog.stop().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    desk.heard();
    sleep(Duration::from_secs(10)).await;
    assert!(desk.count(JOG) > 10);
}

#[tokio::test(start_paused = true)]
async fn a_jog_that_may_have_begun_is_ended() {
    let desk = Desk::new();
    let options = Options::default().timeout(Duration::from_millis(200));
    let arm = desk.connect(options).await;
    desk.swallow(&[JOG]);
    let begun = Instant::now();
    let error = arm.jog(turn()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    assert!(begun.elapsed() <= Duration::from_millis(210));
    desk.swallow(&[]);
    sleep(Duration::from_secs(2)).await;
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn a_call_that_is_given_up_leaves_no_jog_behind() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let given_up = tokio::time::timeout(Duration::from_micros(500), arm.jog(turn())).await;
    assert!(given_up.is_err());
    sleep(Duration::from_secs(2)).await;
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn a_stop_ends_a_jog_and_a_new_jog_takes_its_place() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    arm.stop().await.unwrap();
    assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Closed);
    assert!(!desk.moves());
    let first = arm.jog(turn()).await.unwrap();
    let second = arm.jog(build::Axis::J1.minus()).await.unwrap();
    assert_eq!(first.keep().unwrap_err().kind(), ErrorKind::Closed);
    first.stop().await.unwrap();
    sleep(Duration::from_millis(200)).await;
    assert!(
        desk.moves(),
        "the end of the first is not that of the second"
    );
    second.keep().unwrap();
    // A jog that begins while another is being stopped waits for that.
    drop(second);
    let third = arm.jog(turn()).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    assert!(desk.moves());
    third.keep().unwrap();
    third.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_jog_that_waits_for_an_end_that_does_not_come_never_begins() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let first = arm.jog(turn()).await.unwrap();
    desk.swallow(&[JOG, 10]);
    drop(first);
    sleep(Duration::from_millis(10)).await;
    let begun = Instant::now();
    let error = arm.jog(build::Axis::J2.plus()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    desk.swallow(&[]);
    sleep(Duration::from_secs(2)).await;
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn options_out_of_range() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let invalid = |error: magician::Error| assert_eq!(error.kind(), ErrorKind::InvalidInput);
    for ratio in [0.0, 101.0, f32::NAN] {
        let options = JogOptions::default().ratio(ratio);
        invalid(arm.jog_with(turn(), options).await.unwrap_err());
    }
    let forever = JogOptions::default().keep(Duration::from_secs(60));
    invalid(arm.jog_with(turn(), forever).await.unwrap_err());
    let options = JogOptions::default()
        .ratio(10.0)
        .keep(Duration::from_millis(50));
    let jog = arm.jog_with(turn(), options).await.unwrap();
    let ratios: JogCommonParams = arm.get().await.unwrap();
    assert_eq!(ratios.velocity_ratio, 10.0);
    sleep(Duration::from_millis(60)).await;
    assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Timeout);
}

#[tokio::test(start_paused = true)]
async fn every_call_returns_by_its_deadline_on_a_line_that_takes_no_bytes() {
    for call in 0..8 {
        // A run waits longer than a single call, but not forever.
        let run = matches!(call, 2 | 7);
        let deadline = Duration::from_millis(if run { 30_010 } else { 3_010 });
        let (near, _far) = duplex(4);
        let arm = Arm::over(near, Options::default().probe(false))
            .await
            .unwrap();
        // The line is stuck already.
        let _ = tokio::time::timeout(Duration::from_millis(1), arm.alarms()).await;
        let begun = Instant::now();
        let wait = build::wait(Duration::from_millis(1));
        let ended = match call {
            0 => arm.get::<magician::commands::Pose>().await.map(drop),
            1 => arm.enqueue_set(&wait).await.map(drop),
            2 => arm.start([wait]).wait(|_| {}).await.map(drop),
            3 => arm.stop().await,
            4 => arm.stop_jog().await,
            5 => arm.jog(turn()).await.map(drop),
            6 => arm
                .jog_with(turn(), JogOptions::default().ratio(5.0))
                .await
                .map(drop),
            _ => arm.run(&[wait]).await.map(drop),
        };
        ended.unwrap_err();
        assert!(
            begun.elapsed() <= deadline,
            "call {call}: {:?}",
            begun.elapsed()
        );
        let begun = Instant::now();
        arm.close().await;
        assert!(begun.elapsed() <= Duration::from_millis(510));
    }
}

#[test]
fn a_blocking_jog() {
    let arm = magician::blocking::Arm::connect("sim:1").unwrap();
    // If the computer suspends this thread for longer than the hold time, another jog is started.
    let jog = loop {
        let jog = arm.jog(turn()).unwrap();
        match jog.keep() {
            Ok(()) => break jog,
            Err(error) => assert_eq!(error.kind(), ErrorKind::Timeout, "{error}"),
        }
    };
    jog.stop().unwrap();
    assert!(!arm.moving());
}

#[tokio::test(start_paused = true)]
async fn what_keeps_a_jog_up_too_late_does_not_even_when_nobody_has_noticed() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(turn()).await.unwrap();
    // Time passes while the task is not polled.
    let mut stalls = Box::pin(tokio::time::advance(std::time::Duration::from_millis(310)));
    let mut cx = std::task::Context::from_waker(std::task::Waker::noop());
    assert!(stalls.as_mut().poll(&mut cx).is_pending());
    let error = jog.keep().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
    stalls.await;
    sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
}
