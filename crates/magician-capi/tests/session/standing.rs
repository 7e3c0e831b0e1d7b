//! A program that waits for a queue that stands still.

use std::time::Duration;

use magician::commands::{
    ClearAlarmsState, PtpCmd, QueuedCmdStartExec, QueuedCmdStopExec, WaitCmd,
};
use magician::protocol::PtpMode;
use magician_capi::call;
use magician_capi::pointer::Out;
use magician_capi::session::{Registry, Timeouts};

use crate::bench::{alone, connect_v1, fault, home, long_timeouts, pose_of, run};

/// Registry that looks for the reason without delay.
fn registry() -> Registry {
    let timeouts = Timeouts {
        standing: Duration::ZERO,
        ..long_timeouts()
    };
    let registry = Registry::new(alone(), timeouts);
    connect_v1(&registry, "sim");
    registry
}

fn index(registry: &Registry) -> u64 {
    let mut index = 0;
    // SAFETY: it outlives the call.
    #[allow(unsafe_code)]
    let at = unsafe { Out::new(&raw mut index) };
    let code = run(registry, "GetQueuedCmdCurrentIndex", 0, |arm| {
        call::current_index(arm, at)
    });
    assert_eq!(code, 0);
    index
}

fn go(registry: &Registry, x: f32) {
    let to = PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x,
        y: 0.0,
        z: 20.0,
        r: 0.0,
    };
    let code = run(registry, "SetPTPCmd", 0, |arm| arm.enqueue(&to).map(drop));
    assert_eq!(code, 0);
}

/// Causes another fault, so that a repeated one is visible again.
fn another(registry: &Registry) {
    pose_of(registry, 7);
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

fn order<T: magician::protocol::Writable>(registry: &Registry, command: &T) {
    assert_eq!(
        run(registry, "an order", 0, |arm| call::set(arm, command)),
        0
    );
}

#[test]
fn alarm_that_blocks_the_queue_is_reported_once() {
    let registry = registry();
    go(&registry, 900.0);
    go(&registry, 220.0);
    another(&registry);
    for _ in 0..3 {
        assert_eq!(index(&registry), 2, "the second one waits");
    }
    let told = fault();
    for word in ["command 3 is not finished", "0x11", "ClearAllAlarmsState"] {
        assert!(told.contains(word), "{told}");
    }
    another(&registry);
    for _ in 0..3 {
        index(&registry);
    }
    assert!(fault().starts_with("GetPose"), "it was said: {}", fault());
    order(&registry, &ClearAlarmsState {});
    while index(&registry) < 2 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn stopped_queue_is_reported() {
    let registry = registry();
    order(&registry, &QueuedCmdStopExec {});
    go(&registry, 220.0);
    another(&registry);
    for _ in 0..4 {
        assert_eq!(index(&registry), 0);
    }
    assert!(fault().contains("SetQueuedCmdStartExec"), "{}", fault());
    another(&registry);
    order(&registry, &QueuedCmdStartExec {});
    while index(&registry) < 1 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn homing_is_not_reported_as_blocked_by_an_alarm() {
    let registry = registry();
    order(&registry, &QueuedCmdStopExec {});
    go(&registry, 900.0);
    home(&registry);
    order(&registry, &QueuedCmdStartExec {});
    another(&registry);
    while index(&registry) < 2 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn finished_queue_is_not_reported() {
    let registry = registry();
    another(&registry);
    for _ in 0..5 {
        index(&registry);
    }
    order(&registry, &QueuedCmdStopExec {});
    let pause = WaitCmd { timeout: 5 };
    assert_eq!(
        run(&registry, "SetWAITCmd", 0, |arm| arm
            .enqueue(&pause)
            .map(drop)),
        0
    );
    order(&registry, &magician::commands::QueuedCmdClear {});
    for _ in 0..5 {
        index(&registry);
    }
    assert!(fault().starts_with("GetPose"), "{}", fault());
}
