//! Clones share the connection, and each may stop the arm.

use std::time::Duration;

use magician::commands::{JogCmd, Pose, WaitCmd};
use magician::{Arm, ErrorKind, Link, Options, build};

use crate::bench::real_time;
use crate::desk::Desk;

fn of_any_thread<T: Clone + Send + Sync>() {}

#[test]
fn handles_and_stoppers_go_anywhere() {
    of_any_thread::<Arm>();
    of_any_thread::<magician::blocking::Arm>();
    of_any_thread::<magician::Stopper>();
}

#[tokio::test(start_paused = true)]
async fn the_last_clone_that_goes_stops_the_arm() {
    let desk = Desk::new();
    let first = desk.connect(Options::default()).await;
    let second = first.clone();
    // Unbounded, as a program of another library sends it.
    let jog = JogCmd::from(build::Axis::J1.plus());
    first.front_end().passing_jogs().set(&jog).await.unwrap();
    assert!(second.moving(), "what one sets going, all have");
    drop(first);
    tokio::time::sleep(Duration::from_millis(500)).await;
    assert!(desk.moves(), "somebody is left");
    second.get::<Pose>().await.unwrap();
    drop(second);
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
}

#[tokio::test(start_paused = true)]
async fn any_clone_may_detach() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    arm.clone().detach();
    drop(arm);
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn closing_ends_it_for_all_clones() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let waiting = {
        let arm = arm.clone();
        tokio::spawn(async move {
            arm.start([build::wait(Duration::from_secs(60))])
                .wait(|_| {})
                .await
        })
    };
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(arm.moving());
    arm.clone().close().await;
    assert_eq!(arm.link(), Link::Closed);
    assert!(
        !desk.with(|arm| arm.state().queue.started),
        "it was stopped"
    );
    let kind = |error: magician::Error| error.kind();
    assert_eq!(waiting.await.unwrap().map_err(kind), Err(ErrorKind::Closed));
    assert_eq!(
        arm.get::<Pose>().await.map_err(kind),
        Err(ErrorKind::Closed)
    );
    assert_eq!(arm.stats().await.map_err(kind), Err(ErrorKind::Closed));
    assert_eq!(
        arm.stopper().request_stop().map_err(kind),
        Err(ErrorKind::Closed)
    );
    assert_eq!(arm.events().next().await, None);
}

#[tokio::test(start_paused = true)]
async fn a_command_in_flight_when_all_is_closed_is_uncertain() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    desk.swallow(&[110]);
    let other = arm.clone();
    let adding = tokio::spawn(async move { other.enqueue(&WaitCmd { timeout: 1 }).await });
    tokio::time::sleep(Duration::from_millis(20)).await;
    arm.close().await;
    let error = adding.await.unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_thread_without_a_runtime_stops_a_run() {
    let arm = real_time().await;
    let stopper = arm.stopper();
    let running = {
        let arm = arm.clone();
        let moves = [100.0, -100.0].map(|y| build::move_to(200.0, y, 50.0, 0.0));
        let moves = moves.into_iter().cycle().take(100);
        tokio::spawn(async move { arm.start(moves).wait(|_| {}).await })
    };
    tokio::time::sleep(Duration::from_secs(3)).await;
    let asked = std::thread::spawn(move || stopper.request_stop());
    asked.join().unwrap().unwrap();
    let error = running.await.unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    arm.wait_still().await.unwrap();
    assert_eq!(arm.queue().left_space().await.unwrap(), 32);
    assert!(!arm.moving());
}

#[tokio::test(start_paused = true)]
async fn a_stopper_keeps_nothing_alive() {
    let arm = real_time().await;
    let stopper = arm.stopper();
    drop(arm);
    let error = stopper.request_stop().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed);
}

#[test]
fn blocking_calls_are_stopped_from_another_thread() {
    let arm = magician::blocking::Arm::connect("sim:1").unwrap();
    let stopper = arm.stopper();
    let (begun, began) = std::sync::mpsc::channel();
    let other = arm.clone();
    let running = std::thread::spawn(move || {
        let waits = [build::wait(Duration::from_secs(3600)); 3];
        other.start(waits).wait(|progress| {
            let _ = begun.send(progress.last);
        })
    });
    while began.recv().unwrap().0 == 0 {}
    stopper.stop_blocking().unwrap();
    let error = running.join().unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    assert_eq!(arm.queue().left_space().unwrap(), 32);
}
