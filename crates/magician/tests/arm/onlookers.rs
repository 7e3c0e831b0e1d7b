//! State watches and event listeners.

use std::time::Duration;

use magician::commands::{PtpCmd, WaitCmd};
use magician::protocol::PtpMode;
use magician::{Arm, ErrorKind, Event, Link, Options, Pin, StateOptions, build};
use tokio::io::duplex;
use tokio::time::{Instant, sleep};

use crate::desk::Desk;

const POSE: u8 = 10;
const ALARMS: u8 = 20;
const LEFT_SPACE: u8 = 247;

/// Returns the number of pose reads in ten seconds.
async fn poses(desk: &Desk) -> usize {
    desk.heard();
    sleep(Duration::from_secs(10)).await;
    desk.count(POSE)
}

#[tokio::test(start_paused = true)]
async fn however_many_watch_the_arm_is_asked_once() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    assert_eq!(poses(&desk).await, 0, "nobody watches");
    let slow: Vec<_> = (0..49).map(|_| arm.state(5.0).unwrap()).collect();
    let fast = arm.state(20.0).unwrap();
    let asked = poses(&desk).await;
    assert!((199..=201).contains(&asked), "{asked}");
    drop(fast);
    let asked = poses(&desk).await;
    assert!((49..=51).contains(&asked), "{asked}");
    for watch in &slow {
        assert_eq!(watch.latest().unwrap().left_space, 32);
    }
    drop(slow);
    assert_eq!(poses(&desk).await, 0);
    let watch = arm.state(1.0).unwrap();
    assert_eq!(watch.latest(), None, "what was long ago is not shown");
}

#[tokio::test(start_paused = true)]
async fn reads_are_spread_evenly_and_each_watch_has_its_own_rate() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let mut fast = arm.state(10.0).unwrap();
    let mut slow = arm.state(2.0).unwrap();
    fast.changed().await.unwrap();
    slow.changed().await.unwrap();
    for _ in 0..10 {
        desk.heard();
        sleep(Duration::from_millis(100)).await;
        let asked = desk.heard().len();
        assert!(
            (3..=5).contains(&asked),
            "four reads in each round: {asked}"
        );
    }
    let begun = Instant::now();
    for _ in 0..20 {
        slow.changed().await.unwrap();
    }
    let took = begun.elapsed();
    assert!((8.5..10.5).contains(&took.as_secs_f64()), "{took:?}");
    let begun = Instant::now();
    for _ in 0..20 {
        fast.changed().await.unwrap();
    }
    let took = begun.elapsed();
    assert!((1.7..2.1).contains(&took.as_secs_f64()), "{took:?}");
}

#[tokio::test(start_paused = true)]
async fn what_seldom_changes_is_read_ten_times_a_second_at_least() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    for (rate, seldom) in [(10.0, 100), (19.0, 190), (20.0, 100), (50.0, 250)] {
        let _watch = arm.state(rate).unwrap();
        desk.heard();
        sleep(Duration::from_secs(10)).await;
        let heard = desk.heard();
        for id in [ALARMS, LEFT_SPACE] {
            let asked = heard.iter().filter(|(heard, _)| *heard == id).count();
            assert!(asked.abs_diff(seldom) <= 1, "{asked} of {id} at {rate}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_watch_sees_the_arm_move() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let pins = [Pin::Input(1), Pin::Output(2), Pin::Analog(3)];
    let mut watch = arm.state_with(StateOptions::at(50.0).pins(pins)).unwrap();
    let before = watch.changed().await.unwrap();
    assert!(pins.iter().all(|pin| before.level(*pin).is_some()));
    assert_eq!(before.level(Pin::Input(2)), None, "nobody watches it");
    assert_eq!((before.current.0, &before.link), (0, &Link::Up));
    assert!(before.alarms.contains(0));
    arm.start([build::move_to(200.0, 50.0, 20.0, 0.0)])
        .wait(|_| {})
        .await
        .unwrap();
    sleep(Duration::from_millis(50)).await;
    let after = watch.latest().unwrap();
    assert_eq!((after.pose.y, after.current.0), (50.0, 2));
    assert!(after.at > before.at);
}

#[tokio::test(start_paused = true)]
async fn a_busy_line_is_polled_less_often() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    // An answer takes about 2 ms, so 1000 readings a second of three reads each are impossible.
    let _watch = arm.state(1000.0).unwrap();
    let asked = poses(&desk).await;
    assert!((1200..2000).contains(&asked), "{asked}");
    let begun = Instant::now();
    arm.alarms().await.unwrap();
    assert!(
        begun.elapsed() < Duration::from_millis(10),
        "others have their turn"
    );
    desk.swallow(&[POSE]);
    sleep(Duration::from_secs(2)).await;
    let begun = Instant::now();
    arm.stop().await.unwrap_err();
    assert!(begun.elapsed() <= Duration::from_millis(6020));
}

#[tokio::test(start_paused = true)]
async fn a_watch_sees_the_line_go_and_come_and_the_connection_end() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    sleep(Duration::from_secs(1)).await;
    let mut watch = arm.state(1.0).unwrap();
    watch.changed().await.unwrap();
    desk.unplug();
    let lost = watch.changed().await.unwrap();
    assert!(matches!(lost.link, Link::Lost { .. }));
    desk.plug();
    arm.reconnected().await.unwrap();
    assert_eq!(watch.latest().unwrap().link, Link::Up);
    let begun = watch.latest().unwrap().at;
    sleep(Duration::from_secs(3)).await;
    assert!(watch.latest().unwrap().at > begun, "it is read again");
    drop(arm);
    let error = loop {
        if let Err(error) = watch.changed().await {
            break error;
        }
    };
    assert_eq!(error.kind(), ErrorKind::Closed);
}

#[tokio::test(start_paused = true)]
async fn a_rate_or_pin_that_there_is_not_is_refused() {
    let (near, _far) = duplex(64);
    let arm = Arm::over(near, Options::default().probe(false))
        .await
        .unwrap();
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e9] {
        assert_eq!(arm.state(rate).unwrap_err().kind(), ErrorKind::InvalidInput);
    }
    for pin in [Pin::Input(0), Pin::Analog(21)] {
        let options = StateOptions::at(1.0).pins([pin]);
        let error = arm.state_with(options).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
    }
}

#[tokio::test(start_paused = true)]
async fn what_happens_is_told_and_costs_nothing() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    sleep(Duration::from_secs(1)).await;
    arm.alarms().await.unwrap();
    let mut events = arm.events();
    let mut others = arm.events();
    desk.heard();
    sleep(Duration::from_secs(10)).await;
    assert_eq!(desk.heard(), [], "no reads for events");
    let wait = build::wait(Duration::from_millis(200));
    arm.start([wait, wait, wait]).wait(|_| {}).await.unwrap();
    let mut next = 2;
    while next <= 4 {
        let Some(Event::CommandFinished { first, last }) = events.next().await else {
            panic!("nothing else has happened")
        };
        assert_eq!(first.0, next);
        next = last.0 + 1;
    }
    let far = PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: 900.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
    };
    let index = arm.enqueue(&far).await.unwrap();
    let _ = arm.wait(index).await;
    arm.alarms().await.unwrap();
    let raised = loop {
        match events.next().await {
            Some(Event::AlarmRaised { code }) => break code,
            Some(Event::CommandFinished { .. }) => {}
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(raised, 0x11);
    arm.clear_alarms().await.unwrap();
    arm.alarms().await.unwrap();
    let mut cleared = Vec::new();
    while cleared.len() < 2 {
        if let Some(Event::AlarmCleared { code }) = events.next().await {
            cleared.push(code);
        }
    }
    assert_eq!(cleared, [0x00, 0x11]);
    assert!(matches!(
        others.next().await,
        Some(Event::CommandFinished { .. })
    ));
}

#[tokio::test(start_paused = true)]
async fn who_does_not_listen_hears_how_much_was_missed() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let mut events = arm.events();
    arm.queue().start().await.unwrap();
    for _ in 0..300 {
        let index = arm.enqueue(&WaitCmd { timeout: 1 }).await.unwrap();
        arm.wait(index).await.unwrap();
    }
    assert_eq!(
        events.next().await,
        Some(Event::Missed { events: 300 - 256 })
    );
    let Some(Event::CommandFinished { first, .. }) = events.next().await else {
        panic!()
    };
    assert_eq!(first.0, 46);
}

#[tokio::test(start_paused = true)]
async fn moving_errs_towards_yes_and_ends() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    assert!(!arm.moving());
    arm.enqueue(&WaitCmd { timeout: 10 }).await.unwrap();
    assert!(arm.moving(), "nobody has said that the queue stands");
    arm.queue().start().await.unwrap();
    arm.wait(magician::protocol::QueuedCmdIndex(2))
        .await
        .unwrap();
    assert!(!arm.moving());
    let jog = arm.jog(build::Axis::J2.plus()).await.unwrap();
    assert!(arm.moving());
    jog.stop().await.unwrap();
    assert!(!arm.moving());
}

#[test]
fn blocking_onlookers() {
    let arm = magician::blocking::Arm::connect("sim").unwrap();
    let events = arm.events();
    let mut watch = arm.state(200.0).unwrap();
    let seen = watch.next().unwrap();
    assert_eq!(seen.left_space, 32);
    arm.run(&[build::move_to(200.0, 50.0, 20.0, 0.0)]).unwrap();
    while watch.changed().unwrap().pose.y != 50.0 {}
    arm.close();
    assert!(watch.changed().is_err());
    let told: Vec<_> = events.collect();
    let done = |event: &Event| matches!(event, Event::CommandFinished { .. });
    assert!(told.iter().any(done), "{told:?}");
}
