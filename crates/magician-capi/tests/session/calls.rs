//! Return codes of calls, and the sentences behind them.

use magician::commands::QueuedCmdStopExec;
use magician_capi::call;

use crate::bench::{
    DEADLINE, connect_v1, connect_v2, fault, fault_truncated_to, home, no_buffer, pose, pose_of,
    registry, run,
};

#[test]
fn full_queue_is_reported_at_once_without_side_effect() {
    let registry = registry();
    connect_v1(&registry, "sim");
    run(&registry, "SetQueuedCmdStopExec", 0, |arm| {
        call::set(arm, &QueuedCmdStopExec {})
    });
    for index in 2..=33 {
        assert_eq!(home(&registry), (0, index));
    }
    for _ in 0..3 {
        assert_eq!(home(&registry), (1, 0), "the index is left alone");
    }
    assert!(fault().contains("queue is full"), "{}", fault());
}

#[test]
fn the_last_fault_is_a_sentence_of_this_thread() {
    let registry = registry();
    std::thread::scope(|scope| {
        scope.spawn(|| assert_eq!(fault(), ""));
    });
    pose(&registry);
    let sentence = fault();
    assert!(sentence.starts_with("GetPose: no arm"), "{sentence}");
    let length = i32::try_from(sentence.len()).unwrap();
    assert_eq!(fault_truncated_to(8), (length, "GetPose".to_owned()));
    assert_eq!(fault_truncated_to(1), (length, String::new()));
    assert_eq!(fault_truncated_to(0), (length, String::new()));
    assert_eq!(magician_capi::session::last_error(no_buffer(), 0), length);
    std::thread::scope(|scope| {
        scope.spawn(|| assert_eq!(fault(), "", "another thread has none"));
    });
}

#[test]
fn a_timeout_is_remembered_for_the_id() {
    let registry = registry();
    registry.set_timeout(1, u32::try_from(DEADLINE.as_millis()).unwrap());
    for id in 0..2 {
        assert_eq!(connect_v2(&registry, "sim").id, id);
        assert_eq!(pose_of(&registry, id).0, 0);
    }
    assert_eq!(registry.set_timeout(1, 0), 0);
    assert_eq!(registry.set_timeout(7, u32::MAX), 0);
    assert_eq!(pose_of(&registry, 0).0, 0, "the other arm's is its own");
}
