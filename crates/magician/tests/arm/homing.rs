//! Homing: state of a connection, and the record of earlier ones.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::commands::HomeCmd;
use magician::{
    Act, Action, Arm, ArmIdentity, ClockRate, ErrorCode, HomingRecord, Options, RunOptions, Set,
    Setting, build,
};
use tokio::time::sleep;

use crate::desk::{Desk, only_reads};

/// In-memory record of one arm.
#[derive(Clone, Debug, Default)]
struct Memory(Arc<Mutex<Option<(ArmIdentity, Duration, ClockRate)>>>);

impl Memory {
    fn kept(&self) -> Option<(ArmIdentity, Duration, ClockRate)> {
        self.0.lock().unwrap().clone()
    }

    fn options(&self) -> Options {
        Options::default().homings(Some(Arc::new(self.clone()) as Arc<dyn HomingRecord>))
    }
}

impl HomingRecord for Memory {
    fn keep(&self, arm: &ArmIdentity, uptime: Duration, rate: ClockRate) {
        *self.0.lock().unwrap() = Some((arm.clone(), uptime, rate));
    }

    fn forget(&self, arm: &ArmIdentity) {
        let mut kept = self.0.lock().unwrap();
        kept.take_if(|(kept, ..)| kept == arm);
    }

    fn is_homed(&self, arm: &ArmIdentity, uptime: Duration) -> bool {
        let kept = self.kept();
        kept.is_some_and(|(kept, since, _)| kept == *arm && since <= uptime)
    }
}

fn homing() -> Set {
    build::home()
}

async fn is_refused(arm: &Arm) -> bool {
    match arm.homing().check().await {
        Ok(()) => false,
        Err(error) => {
            assert_eq!(error.code(), ErrorCode::NotHomed, "{error}");
            let remedies = error.remedies();
            assert_eq!(remedies[0].act, Act::Do(Action::Home));
            assert!(matches!(remedies[1].act, Act::Give(Setting::Unhomed, _)));
            true
        }
    }
}

#[tokio::test(start_paused = true)]
async fn cleared_reset_alarm_leaves_the_arm_unhomed() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    assert_eq!(arm.homing().is_homed().await.unwrap(), Some(false));
    desk.heard();
    assert!(is_refused(&arm).await);
    arm.clear_alarms().await.unwrap();
    assert_eq!(arm.homing().is_homed().await.unwrap(), None);
    desk.heard();
    assert!(is_refused(&arm).await);
    assert!(only_reads(&desk.heard()));
    arm.allowing_unhomed().homing().check().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn virtual_arm_is_never_refused() {
    let arm = Arm::connect("sim").await.unwrap();
    arm.homing().check().await.unwrap();
    let desk = Desk::new();
    let station = desk.connect(Options::default().virtual_arm(true)).await;
    station.homing().check().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn homing_counts_however_it_was_asked_for() {
    for way in 0..4 {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        match way {
            0 => arm.home().await.unwrap(),
            1 => assert_eq!(arm.run(&[homing()]).await.unwrap().commands, 1),
            // Within a program, with the reset alarm active all the time.
            2 => {
                let after = build::move_to(220.0, 0.0, 40.0, 0.0);
                arm.run(&[homing(), after]).await.unwrap();
                assert!(!arm.alarms().await.unwrap().is_empty());
            }
            _ => {
                let index = arm.enqueue(&HomeCmd { reserved: 0 }).await.unwrap();
                arm.queue().start().await.unwrap();
                arm.wait(index).await.unwrap();
            }
        }
        assert_eq!(
            arm.homing().is_homed().await.unwrap(),
            Some(true),
            "way {way}"
        );
        assert!(!is_refused(&arm).await, "way {way}");
    }
}

#[tokio::test(start_paused = true)]
async fn homing_that_was_stopped_does_not_count() {
    let desk = Desk::new();
    let memory = Memory::default();
    let arm = desk.connect(memory.options()).await;
    arm.home().await.unwrap();
    assert!(memory.kept().is_some());
    let other = arm.clone();
    let homes = tokio::spawn(async move { other.home().await });
    sleep(Duration::from_secs(2)).await;
    assert!(memory.kept().is_none(), "it is forgotten as homing begins");
    arm.stop().await.unwrap();
    homes.await.unwrap().unwrap_err();
    arm.clear_alarms().await.unwrap();
    assert!(is_refused(&arm).await);
    assert!(memory.kept().is_none());
}

#[tokio::test(start_paused = true)]
async fn reset_ends_it_whether_the_alarm_or_the_clock_tells() {
    for cleared in [false, true] {
        let desk = Desk::new();
        let memory = Memory::default();
        let arm = desk.connect(memory.options()).await;
        arm.home().await.unwrap();
        assert!(!is_refused(&arm).await);
        desk.reset();
        if cleared {
            desk.with(|arm| {
                let clear = magician::commands::ClearAlarmsState {};
                let frame = magician::FrameBuf::set(&clear.into(), magician::Ctrl::SET).unwrap();
                arm.receive(magician::sim::LinkId(9), frame.bytes());
            });
        }
        assert!(is_refused(&arm).await, "cleared: {cleared}");
    }
}

#[tokio::test(start_paused = true)]
async fn record_carries_homing_to_the_next_connection() {
    let desk = Desk::new();
    let memory = Memory::default();
    let arm = desk.connect(memory.options()).await;
    arm.home().await.unwrap();
    let (kept, uptime, rate) = memory.kept().expect("kept");
    assert_eq!(kept, ArmIdentity::new("arm A", arm.name()));
    assert!(uptime > Duration::from_secs(5) && rate == ClockRate::Steady);
    arm.close().await;
    let next = desk.connect(memory.options()).await;
    assert!(!is_refused(&next).await);
    assert_eq!(next.homing().is_homed().await.unwrap(), Some(true));
    next.close().await;
    let without = desk.connect(Options::default()).await;
    assert!(is_refused(&without).await, "nothing remembers");
    without.close().await;
    desk.replace("arm B");
    let other = desk.connect(memory.options()).await;
    assert!(is_refused(&other).await, "another arm");
}

#[tokio::test(start_paused = true)]
async fn lost_line_asks_the_record_again() {
    let desk = Desk::new();
    let memory = Memory::default();
    let arm = desk.connect(memory.options()).await;
    arm.home().await.unwrap();
    desk.unplug();
    sleep(Duration::from_secs(1)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    assert!(!is_refused(&arm).await, "it was on all the time");
    desk.unplug();
    sleep(Duration::from_secs(1)).await;
    desk.reset();
    desk.plug();
    arm.reconnected().await.unwrap();
    assert!(is_refused(&arm).await, "it was switched off and on");
}

#[tokio::test(start_paused = true)]
async fn watch_shows_what_is_known() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let mut watch = arm.state(20.0).unwrap();
    let mut sees = async |homed| {
        while watch.changed().await.unwrap().homed != homed {}
    };
    sees(Some(false)).await;
    arm.clear_alarms().await.unwrap();
    sees(None).await;
    arm.home_with(RunOptions::default()).await.unwrap();
    sees(Some(true)).await;
}

#[tokio::test(start_paused = true)]
async fn homing_that_another_program_breaks_off_is_an_error_and_does_not_count() {
    let desk = Desk::new();
    let memory = Memory::default();
    let arm = desk.connect(memory.options()).await;
    let other = desk.connect(Options::default()).await;
    let homes = arm.clone();
    let homes = tokio::spawn(async move { homes.home().await });
    sleep(Duration::from_secs(3)).await;
    other.stop().await.unwrap();
    let error = homes.await.unwrap().unwrap_err();
    assert_eq!(error.code(), ErrorCode::NotHomed, "{error}");
    assert!(is_refused(&arm).await);
    assert_eq!(memory.kept(), None);
    // The alarm of the reset still shows it.
    assert_eq!(arm.homing().is_homed().await.unwrap(), Some(false));
}
