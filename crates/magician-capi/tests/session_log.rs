//! Log output of a session. The subscriber is global to the process, so these tests have a binary
//! to themselves.

#[allow(dead_code)]
#[path = "session/bench.rs"]
mod bench;

use std::cell::RefCell;
use std::io::Write;
use std::sync::Once;

use magician::commands::PtpCommonParams;
use magician_capi::call;

use crate::bench::{connect_v1, home, pose, pose_of, registry, run};

thread_local! {
    /// Log lines of this thread.
    static LOG_LINES: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Writer that appends to this thread's lines.
struct LogWriter;

impl Write for LogWriter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        LOG_LINES.with_borrow_mut(|buffer| buffer.extend_from_slice(bytes));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Runs `act` and returns the lines that this crate logs on this thread.
fn logged(act: impl FnOnce()) -> Vec<String> {
    static SUBSCRIBED: Once = Once::new();
    SUBSCRIBED.call_once(|| {
        tracing_subscriber::fmt()
            .with_max_level(tracing::Level::DEBUG)
            .with_writer(|| LogWriter)
            .without_time()
            .with_ansi(false)
            .init();
    });
    LOG_LINES.take();
    act();
    let text = String::from_utf8(LOG_LINES.take()).unwrap();
    let lines = text.lines().filter(|line| line.contains(" magician_capi"));
    lines.map(str::to_owned).collect()
}

/// Runs `act` and returns the warnings that this thread logs.
fn warned(act: impl FnOnce()) -> Vec<String> {
    let mut lines = logged(act);
    lines.retain(|line| line.trim_start().starts_with("WARN"));
    lines
}

#[test]
fn each_call_is_logged_as_one_line() {
    let registry = registry();
    let ratios = PtpCommonParams {
        velocity_ratio: 50.0,
        acceleration_ratio: 12.5,
    };
    let lines = logged(|| {
        connect_v1(&registry, "sim");
        run(&registry, "SetPTPCommonParams", 0, |arm| {
            call::set(arm, &ratios)
        });
        home(&registry);
        pose(&registry);
        pose_of(&registry, 3);
        registry.disconnect(0);
    });
    let [connect, set, home, pose, .., unknown_id, disconnect] = lines.as_slice() else {
        panic!("{lines:#?}")
    };
    assert!(
        set.contains("SetPTPCommonParams velocity_ratio=50 acceleration_ratio=12.5 -> 0 ("),
        "{set}"
    );
    assert!(
        home.contains("SetHOMECmd reserved=0 index 2 -> 0 ("),
        "{home}"
    );
    assert!(
        pose.contains("GetPose x=") && pose.contains(" -> 0 ("),
        "{pose}"
    );
    assert!(unknown_id.contains("GetPose -> 2 ("), "{unknown_id}");
    assert!(connect.contains("ConnectDobot \"sim\" -> 0 ("), "{connect}");
    assert!(
        disconnect.contains("DisconnectDobot id=0 -> 0 ("),
        "{disconnect}"
    );
}

#[test]
fn fault_is_logged_once_until_the_function_succeeds() {
    let registry = registry();
    // Faults are remembered per function name, so use a name that no other test uses.
    let call = || run(&registry, "GetPoseOfThisTest", 0, |_| Ok(()));
    let faults = warned(|| {
        (0..5).for_each(|_| assert_eq!(call(), 2));
    });
    assert_eq!(faults.len(), 1, "{faults:?}");
    connect_v1(&registry, "sim");
    assert_eq!(call(), 0);
    registry.disconnect(0);
    let again = warned(|| assert_eq!(call(), 2));
    assert_eq!(again.len(), 1, "{again:?}");
}

#[test]
fn faults_are_logged_for_each_arm() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let call = |id| run(&registry, "GetPoseOfThatTest", id, |_| Ok(()));
    let faults = warned(|| {
        for _ in 0..5 {
            assert_eq!([0, 1, 2].map(call), [0, 2, 2]);
        }
    });
    assert_eq!(faults.len(), 2, "{faults:?}");
}
