//! A pulled cable, and the arm at its end after the reconnect.

use std::io;
use std::time::Duration;

use magician::commands::{Pose, WaitCmd};
use magician::{Arm, ErrorKind, Event, Link, Options, Set, build};
use tokio::io::DuplexStream;
use tokio::time::{Instant, sleep};

use crate::desk::{Desk, acquainted, only_reads};

const FORCE_STOP: u8 = 242;

#[tokio::test(start_paused = true)]
async fn a_connection_asks_once_what_the_arm_can_be_told_by() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let asked: Vec<_> = desk.heard().into_iter().map(|(id, _)| id).collect();
    assert_eq!(asked, [2, 247, 246], "connecting costs nothing more");
    sleep(Duration::from_secs(10)).await;
    let asked: Vec<_> = desk.heard().into_iter().map(|(id, _)| id).collect();
    assert_eq!(asked, [0, 4]);
    drop(arm);
    let arm = desk.connect(Options::default().reconnect(false)).await;
    sleep(Duration::from_secs(10)).await;
    assert_eq!(desk.heard().len(), 3, "nobody wants to know");
    drop(arm);
}

#[tokio::test(start_paused = true)]
async fn a_cable_pulled_during_a_read() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut events = arm.events();
    desk.swallow(&[10]);
    let other = arm.clone();
    let reading = tokio::spawn(async move { other.get::<Pose>().await });
    sleep(Duration::from_millis(20)).await;
    desk.unplug();
    let error = reading.await.unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    assert!(error.to_string().contains("looked for again"), "{error}");
    assert!(matches!(events.next().await, Some(Event::LinkLost { .. })));
    assert!(matches!(arm.link(), Link::Lost { sought: true, .. }));
    let begun = Instant::now();
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    assert_eq!(begun.elapsed(), Duration::ZERO, "nobody waits");

    sleep(Duration::from_secs(30)).await;
    desk.swallow(&[]);
    desk.heard();
    desk.plug();
    let begun = Instant::now();
    arm.reconnected().await.unwrap();
    assert!(begun.elapsed() < Duration::from_secs(2));
    assert_eq!(arm.link(), Link::Up);
    assert_eq!(events.next().await, Some(Event::LinkFound { reset: false }));
    arm.get::<Pose>().await.unwrap();
    assert!(only_reads(&desk.heard()));
}

#[tokio::test(start_paused = true)]
async fn a_cable_pulled_while_a_command_is_queued() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    desk.swallow(&[110]);
    let other = arm.clone();
    let adding = tokio::spawn(async move { other.enqueue(&WaitCmd { timeout: 100 }).await });
    sleep(Duration::from_millis(20)).await;
    desk.unplug();
    sleep(Duration::from_millis(50)).await;
    desk.swallow(&[]);
    desk.heard();
    desk.plug();
    arm.reconnected().await.unwrap();
    // Uncertain, or its real outcome once the indices have shown it.
    match adding.await.unwrap() {
        // Arms begin with index 1 or 2: the lower one, so that a wait for it ends.
        Ok(index) => assert_eq!(index.0, 1),
        Err(error) => assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}"),
    }
    assert!(only_reads(&desk.heard()), "it is not sent again");
    assert_eq!(arm.queue().left_space().await.unwrap(), 31);
    arm.allowing_laser().queue().start().await.unwrap();
    assert!(arm.moving(), "it counts as set going");
}

#[tokio::test(start_paused = true)]
async fn a_cable_pulled_during_a_run() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let other = arm.clone();
    let running = tokio::spawn(async move {
        let wait = build::wait(Duration::from_millis(300));
        let mut run = other.start(std::iter::repeat_n(wait, 30));
        let error = run.wait(|_| {}).await.unwrap_err();
        (run, error)
    });
    sleep(Duration::from_secs(2)).await;
    desk.unplug();
    let (mut run, error) = running.await.unwrap();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    assert!(run.is_interrupted());
    let last = run.ran().last.unwrap();
    assert!((8..16).contains(&last.0), "two seconds ahead: {last:?}");
    assert!(arm.moving());
    sleep(Duration::from_secs(1)).await;
    desk.heard();
    desk.plug();
    arm.reconnected().await.unwrap();
    assert!(only_reads(&desk.heard()));
    assert!(arm.moving(), "nothing is forgotten");
    // Commands in the queue can be awaited as before.
    arm.wait(last).await.unwrap();
    assert!(!arm.moving());
    // On another `wait` it continues with the very next command.
    let ran = run.wait(|_| {}).await.unwrap();
    assert_eq!(
        (ran.commands, ran.last.map(|index| index.0)),
        (30, Some(31))
    );
    assert!(!run.is_interrupted());
}

#[tokio::test(start_paused = true)]
async fn what_goes_on_behind_a_lost_line_is_stopped_when_it_is_back_and_the_last_handle_goes() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    desk.unplug();
    sleep(Duration::from_secs(1)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    arm.close().await;
    assert!(!desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn a_handle_that_goes_while_the_line_is_lost_waits_for_nothing() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    desk.unplug();
    sleep(Duration::from_millis(50)).await;
    let begun = Instant::now();
    arm.close().await;
    assert_eq!(begun.elapsed(), Duration::ZERO);
    assert!(
        desk.with(|arm| arm.state().queue.started),
        "it cannot be told"
    );
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_was_reset_meanwhile() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let wait = build::wait(Duration::from_millis(1));
    arm.start([wait, wait]).wait(|_| {}).await.unwrap();
    for _ in 0..3 {
        arm.enqueue(&WaitCmd { timeout: 5_000 }).await.unwrap();
    }
    let mut events = arm.events();
    desk.unplug();
    desk.reset();
    desk.heard();
    desk.plug();
    sleep(Duration::from_millis(1)).await;
    arm.reconnected().await.unwrap();
    assert!(matches!(events.next().await, Some(Event::LinkLost { .. })));
    let Some(Event::Reset {
        gone: Some((first, last)),
    }) = events.next().await
    else {
        panic!("the reset is told first")
    };
    assert_eq!((first.0, last.0), (4, 6));
    assert_eq!(events.next().await, Some(Event::LinkFound { reset: true }));
    let error = arm.start([wait]).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    assert!(error.to_string().contains("reset"), "{error}");
    assert!(only_reads(&desk.heard()), "nothing is sent again");
    arm.start([wait]).wait(|_| {}).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn every_wait_hears_of_a_reset() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    let waits: Vec<_> = [100, 60_000].map(|timeout| WaitCmd { timeout }).into();
    let mut last = None;
    for wait in &waits {
        last = Some(arm.enqueue(wait).await.unwrap());
    }
    let waiting: Vec<_> = (0..3)
        .map(|_| {
            let (arm, last) = (arm.clone(), last.unwrap());
            tokio::spawn(async move { arm.wait(last).await })
        })
        .collect();
    sleep(Duration::from_secs(1)).await;
    desk.reset();
    for wait in waiting {
        let error = wait.await.unwrap().unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    }
}

#[tokio::test(start_paused = true)]
async fn another_arm_in_its_place_is_not_talked_to() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut events = arm.events();
    desk.unplug();
    desk.replace("arm B");
    desk.heard();
    desk.plug();
    sleep(Duration::from_secs(20)).await;
    assert!(desk.heard().iter().all(|(id, _)| [0, 2].contains(id)));
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    let message = error.to_string();
    assert!(
        message.contains("arm A") && message.contains("arm B"),
        "{message}"
    );
    assert!(matches!(arm.link(), Link::Lost { why, .. } if why.contains("arm B")));
    desk.replace("arm A");
    arm.reconnected().await.unwrap();
    assert!(matches!(events.next().await, Some(Event::LinkLost { .. })));
    assert!(matches!(
        events.next().await,
        Some(Event::LinkFound { .. } | Event::Reset { .. })
    ));
    arm.get::<Pose>().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_is_still_starting_up_is_waited_for() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    desk.unplug();
    desk.swallow(&[0, 2, 4, 246, 247]);
    desk.plug();
    sleep(Duration::from_secs(10)).await;
    assert!(matches!(arm.link(), Link::Lost { .. }));
    desk.swallow(&[246]);
    sleep(Duration::from_secs(10)).await;
    assert!(
        matches!(arm.link(), Link::Lost { .. }),
        "how far it is, is not known"
    );
    desk.swallow(&[]);
    let begun = Instant::now();
    arm.reconnected().await.unwrap();
    assert!(begun.elapsed() < Duration::from_secs(2));
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_there_was_no_line_for_comes_first() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    desk.unplug();
    sleep(Duration::from_millis(50)).await;
    let error = arm.stop().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    desk.heard();
    desk.plug();
    arm.reconnected().await.unwrap();
    let heard = desk.heard();
    let stop = heard.iter().position(|(id, _)| *id == FORCE_STOP);
    let greeting = heard.iter().take_while(|(id, _)| [0, 2].contains(id));
    assert_eq!(stop, Some(greeting.count()), "{heard:?}");
    assert!(!desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn a_stop_from_a_thread_waits_for_the_line_too() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    desk.unplug();
    sleep(Duration::from_millis(50)).await;
    arm.stopper().request_stop().unwrap();
    sleep(Duration::from_millis(50)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    assert!(!desk.with(|arm| arm.state().queue.started));
    desk.heard();
    sleep(Duration::from_secs(5)).await;
    assert_eq!(desk.count(FORCE_STOP), 0, "once is enough");
}

#[tokio::test(start_paused = true)]
async fn a_jog_whose_line_breaks_is_ended_over_the_next() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let jog = arm.jog(build::Axis::J1.plus()).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    desk.unplug();
    sleep(Duration::from_millis(10)).await;
    assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Port);
    assert_eq!(jog.stop().await.unwrap_err().kind(), ErrorKind::Port);
    assert!(desk.moves(), "the arm does not know");
    desk.plug();
    arm.reconnected().await.unwrap();
    sleep(Duration::from_secs(1)).await;
    assert!(!desk.moves());
    assert!(!arm.moving());
}

#[tokio::test(start_paused = true)]
async fn without_the_option_it_is_not_looked_for() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default().reconnect(false)).await;
    desk.unplug();
    desk.plug();
    sleep(Duration::from_secs(5)).await;
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
    assert!(!error.to_string().contains("looked for"), "{error}");
    assert!(matches!(arm.link(), Link::Lost { sought: false, .. }));
    let error = arm.reconnected().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port);
}

#[tokio::test(start_paused = true)]
async fn while_the_line_is_looked_for_every_call_ends_at_once() {
    let desk = Desk::new();
    let mut first = Some(desk.opener()());
    let opener = move || {
        let first = first.take();
        async move {
            match first {
                Some(first) => first.await,
                // The next attempt to open never ends.
                None => std::future::pending::<io::Result<DuplexStream>>().await,
            }
        }
    };
    let arm = Arm::over_with(opener, Options::default()).await.unwrap();
    desk.unplug();
    sleep(Duration::from_secs(5)).await;
    let begun = Instant::now();
    let port = |error: magician::Error| assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    let wait = build::wait(Duration::from_millis(1));
    let Set::WaitCmd(queued) = wait else { panic!() };
    port(arm.get::<Pose>().await.unwrap_err());
    port(arm.enqueue(&queued).await.unwrap_err());
    port(arm.queue().start().await.unwrap_err());
    port(arm.start([wait]).wait(|_| {}).await.unwrap_err());
    port(arm.stop().await.unwrap_err());
    port(arm.stop_jog().await.unwrap_err());
    port(arm.jog(build::Axis::J1.plus()).await.unwrap_err());
    arm.stats().await.unwrap();
    arm.close().await;
    assert_eq!(begun.elapsed(), Duration::ZERO);
}
