//! Behaviour of the arm after its handle is dropped.

use std::time::Duration;

use magician::commands::{JogCmd, WaitCmd};
use magician::protocol::FrameBuf;
use magician::{Arm, Ctrl, Options, Set, build};
use tokio::io::{AsyncReadExt, duplex};

use crate::desk::Desk;

#[tokio::test(start_paused = true)]
async fn a_dropped_handle_stops_what_it_started_and_puts_the_laser_out() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default().allow_laser(true)).await;
    let Set::SetEndEffectorLaser(burn) = build::laser(true) else {
        panic!()
    };
    arm.set(&burn).await.unwrap();
    assert!(desk.with(|arm| arm.state().laser), "it does burn");
    arm.queue().start().await.unwrap();
    for y in [100.0, -100.0, 100.0] {
        let Set::PtpCmd(go) = build::move_to(200.0, y, 50.0, 0.0) else {
            panic!()
        };
        arm.enqueue(&go).await.unwrap();
    }
    drop(arm);
    tokio::time::sleep(Duration::from_secs(1)).await;
    let state = desk.with(|arm| arm.state());
    assert!(
        !state.laser && !state.queue.started && state.queue.waiting == 0,
        "{state:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_detached_handle_and_one_that_is_done_leave_the_arm_alone() {
    for detach in [true, false] {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        if detach {
            arm.queue().start().await.unwrap();
            arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
            arm.detach();
        } else {
            arm.start([build::wait(Duration::from_millis(1))])
                .wait(|_| {})
                .await
                .unwrap();
        }
        arm.close().await;
        assert!(
            desk.with(|arm| arm.state().queue.started),
            "detach {detach}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_was_asked_for_is_said_to_its_end_also_by_a_detached_handle() {
    for passed in [0, 1, 2, 5, 10, 20] {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        arm.queue().start().await.unwrap();
        for _ in 0..10 {
            arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
        }
        arm.detach();
        arm.stopper().request_stop().unwrap();
        tokio::time::sleep(Duration::from_millis(passed)).await;
        arm.close().await;
        desk.with(|arm| {
            let queue = arm.state().queue;
            assert!(
                !queue.started && queue.waiting == 0,
                "{passed} ms: {queue:?}"
            );
        });
    }
}

#[tokio::test(start_paused = true)]
async fn a_handle_that_goes_while_its_program_fills_the_queue_leaves_nothing_in_it() {
    let mut filled = 0;
    for patience in (10..80).step_by(2) {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        let program = vec![build::wait(Duration::from_secs(1)); 20];
        let mut run = arm.start(program);
        let patience = Duration::from_millis(patience);
        assert!(
            tokio::time::timeout(patience, run.wait(|_| {}))
                .await
                .is_err()
        );
        filled +=
            u32::from(desk.with(|arm| !arm.state().queue.started && arm.state().queue.waiting > 0));
        arm.close().await;
        desk.with(|arm| assert_eq!(arm.state().queue.waiting, 0, "{patience:?}"));
    }
    assert!(filled > 0, "it was filling the queue: {filled}");
}

#[test]
fn a_runtime_that_goes_first_still_lets_the_stop_out() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let (near, mut far) = duplex(1 << 16);
    runtime.block_on(async {
        let options = Options::default()
            .probe(false)
            .timeout(Duration::from_millis(1));
        let arm = Arm::over(near, options).await.unwrap();
        let jog = JogCmd::from(build::Axis::J1.plus());
        let _ = arm.front_end().passing_jogs().set(&jog).await;
    });
    drop(runtime);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .unwrap();
    let mut heard = Vec::new();
    runtime.block_on(far.read_to_end(&mut heard)).unwrap();
    let stop = FrameBuf::new(242, Ctrl::SET, &[]).unwrap();
    let stopped = heard
        .windows(stop.bytes().len())
        .any(|bytes| bytes == stop.bytes());
    assert!(stopped, "{heard:02X?}");
}
