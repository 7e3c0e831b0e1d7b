//! A program waits for a queue that stands still: when it gets an explanation, and which one.

use std::time::Duration;

use magician::commands::{
    ClearAlarmsState, PtpCmd, QueuedCmdStartExec, QueuedCmdStopExec, WaitCmd,
};
use magician::protocol::PtpMode;
use magician_capi::call;
use magician_capi::pointer::Out;
use magician_capi::session::{Registry, Timeouts};

use crate::bench::{connect_v1, fault, home, isolated_environment, long_timeouts, pose_of, run};

/// Creates a registry with a virtual arm, which looks for the reason of a standstill without delay.
fn registry() -> Registry {
    let timeouts = Timeouts {
        standing: Duration::ZERO,
        ..long_timeouts()
    };
    let registry = Registry::new(isolated_environment(), timeouts);
    connect_v1(&registry, "sim");
    registry
}

fn index(registry: &Registry) -> u64 {
    let mut index = 0;
    // SAFETY: `index` outlives the call.
    #[allow(unsafe_code)]
    let at = unsafe { Out::new(&raw mut index) };
    let code = run(registry, "GetQueuedCmdCurrentIndex", 0, |arm| {
        call::current_index(arm, at)
    });
    assert_eq!(code, 0);
    index
}

fn queue_move(registry: &Registry, x: f32) {
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

/// Replaces the last fault by another one, so that a repetition of the first would be noticed.
fn cause_another_fault(registry: &Registry) {
    pose_of(registry, 7);
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

fn send<T: magician::protocol::Writable>(registry: &Registry, command: &T) {
    assert_eq!(
        run(registry, "an order", 0, |arm| call::set(arm, command)),
        0
    );
}

#[test]
fn alarm_that_blocks_the_queue_is_reported_once() {
    let registry = registry();
    queue_move(&registry, 900.0);
    queue_move(&registry, 220.0);
    cause_another_fault(&registry);
    for _ in 0..3 {
        assert_eq!(index(&registry), 2, "the second one waits");
    }
    let message = fault();
    for word in ["command 3 is not finished", "0x11", "ClearAllAlarmsState"] {
        assert!(message.contains(word), "{message}");
    }
    cause_another_fault(&registry);
    for _ in 0..3 {
        index(&registry);
    }
    assert!(fault().starts_with("GetPose"), "it was said: {}", fault());
    send(&registry, &ClearAlarmsState {});
    while index(&registry) < 2 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn stopped_queue_is_reported() {
    let registry = registry();
    send(&registry, &QueuedCmdStopExec {});
    queue_move(&registry, 220.0);
    cause_another_fault(&registry);
    for _ in 0..4 {
        assert_eq!(index(&registry), 0);
    }
    assert!(fault().contains("SetQueuedCmdStartExec"), "{}", fault());
    cause_another_fault(&registry);
    send(&registry, &QueuedCmdStartExec {});
    while index(&registry) < 1 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn homing_is_not_reported_as_blocked_by_an_alarm() {
    let registry = registry();
    send(&registry, &QueuedCmdStopExec {});
    queue_move(&registry, 900.0);
    home(&registry);
    send(&registry, &QueuedCmdStartExec {});
    cause_another_fault(&registry);
    while index(&registry) < 2 {}
    assert!(fault().starts_with("GetPose"), "{}", fault());
}

#[test]
fn finished_queue_is_not_reported() {
    let registry = registry();
    cause_another_fault(&registry);
    for _ in 0..5 {
        index(&registry);
    }
    send(&registry, &QueuedCmdStopExec {});
    let pause = WaitCmd { timeout: 5 };
    assert_eq!(
        run(&registry, "SetWAITCmd", 0, |arm| arm
            .enqueue(&pause)
            .map(drop)),
        0
    );
    send(&registry, &magician::commands::QueuedCmdClear {});
    for _ in 0..5 {
        index(&registry);
    }
    assert!(fault().starts_with("GetPose"), "{}", fault());
}
