//! What calls return, and what they say of it.

use std::io::Write;
use std::sync::{Arc, Mutex};

use magician::commands::{PtpCommonParams, QueuedCmdStopExec};
use magician_capi::call;
use tracing_subscriber::fmt::MakeWriter;

use crate::bench::{
    DEADLINE, connect_v1, connect_v2, fault, fault_in, home, no_buffer, pose, pose_of, registry,
    run,
};

#[test]
fn a_full_queue_is_said_at_once_and_takes_nothing() {
    let registry = registry();
    connect_v1(&registry, "sim");
    run(&registry, "SetQueuedCmdStopExec", 0, |arm| {
        call::set(arm, &QueuedCmdStopExec {})
    });
    for index in 1..=32 {
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
    assert_eq!(fault_in(8), (length, "GetPose".to_owned()));
    assert_eq!(fault_in(1), (length, String::new()));
    assert_eq!(fault_in(0), (length, String::new()));
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

/// Where a test reads what was logged.
#[derive(Clone, Default)]
struct Pages(Arc<Mutex<Vec<u8>>>);

impl Write for Pages {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Pages {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

/// What this crate logs while something is done, a line each.
fn logged(level: tracing::Level, act: impl FnOnce()) -> Vec<String> {
    let pages = Pages::default();
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(pages.clone())
        .without_time()
        .with_ansi(false)
        .finish();
    tracing::subscriber::with_default(subscriber, act);
    let text = pages.0.lock().unwrap().clone();
    let text = String::from_utf8(text).unwrap();
    let lines = text.lines().filter(|line| line.contains(" magician_capi"));
    lines.map(str::to_owned).collect()
}

#[test]
fn a_call_is_a_line_of_the_session_log() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let ratios = PtpCommonParams {
        velocity_ratio: 50.0,
        acceleration_ratio: 12.5,
    };
    let lines = logged(tracing::Level::DEBUG, || {
        run(&registry, "SetPTPCommonParams", 0, |arm| {
            call::set(arm, &ratios)
        });
        home(&registry);
        pose(&registry);
        pose_of(&registry, 3);
    });
    let [set, home, pose, ..] = lines.as_slice() else {
        panic!("{lines:#?}")
    };
    assert!(
        set.contains("SetPTPCommonParams velocity_ratio=50 acceleration_ratio=12.5 -> 0 ("),
        "{set}"
    );
    assert!(
        home.contains("SetHOMECmd reserved=0 index 1 -> 0 ("),
        "{home}"
    );
    assert!(
        pose.contains("GetPose x=") && pose.contains(" -> 0 ("),
        "{pose}"
    );
    assert!(
        lines.last().unwrap().contains("GetPose -> 2 ("),
        "{lines:#?}"
    );
}

#[test]
fn a_fault_is_told_once_until_the_function_has_worked() {
    let registry = registry();
    // Another test may tell of a function of the same name; none has this one.
    let call = || run(&registry, "GetPoseOfThisTest", 0, |_| Ok(()));
    let faults = logged(tracing::Level::WARN, || {
        (0..5).for_each(|_| assert_eq!(call(), 2));
    });
    assert_eq!(faults.len(), 1, "{faults:?}");
    connect_v1(&registry, "sim");
    assert_eq!(call(), 0);
    registry.disconnect(0);
    let again = logged(tracing::Level::WARN, || assert_eq!(call(), 2));
    assert_eq!(again.len(), 1, "{again:?}");
}
