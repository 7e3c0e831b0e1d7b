//! Holds of the queue, and states that only look like one.

use std::time::Duration;

use magician::commands::{Pose, PtpCmd, WaitCmd};
use magician::protocol::FrameBuf;
use magician::sim::{ArmInstant, Controller, LineTiming, Profile, Runner, Speed};
use magician::{Act, Action, Arm, Ctrl, ErrorCode, ErrorKind, Options, RunOptions, Set, build};
use tokio::io::{AsyncWriteExt, duplex};
use tokio::time::Instant;

use crate::bench::{next_request, real_time};

#[tokio::test(start_paused = true)]
async fn fails_on_the_first_blocking_alarm_and_names_the_cure() {
    let arm = real_time().await;
    let far = PtpCmd {
        ptp_mode: magician::protocol::PtpMode::MovjXyz,
        x: 900.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
    };
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 500 }).await.unwrap();
    arm.enqueue(&far).await.unwrap();
    let last = arm.enqueue(&WaitCmd { timeout: 500 }).await.unwrap();
    let error = arm.wait(last).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm);
    assert!(error.alarms().unwrap().contains(0x11), "{error}");
    assert!(
        error.remedies()[0].act == Act::Do(Action::ClearAlarms),
        "{error}"
    );
    arm.clear_alarms().await.unwrap();
    arm.wait(last).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_run_whose_last_motion_is_refused_has_failed() {
    let arm = real_time().await;
    let near = build::move_to(220.0, 0.0, 0.0, 0.0);
    let far = build::move_to(900.0, 0.0, 0.0, 0.0);
    for program in [vec![far], vec![near, far]] {
        let error = arm.start(program).wait(|_| {}).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Alarm);
        assert!(error.alarms().unwrap().contains(0x11), "{error}");
        arm.clear_alarms().await.unwrap();
    }
    arm.start([near]).wait(|_| {}).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_hold_without_an_alarm_is_found_out() {
    let arm = real_time().await;
    arm.queue().start().await.unwrap();
    // Into a limit, and out of it without the queue: the alarm bit clears, the hold stays.
    let Set::PtpCmd(out) = build::move_joints(0.0, 95.0, 45.0, 0.0) else {
        panic!()
    };
    arm.set(&out).await.unwrap();
    arm.wait_still().await.unwrap();
    assert!(arm.alarms().await.unwrap().contains(0x42));
    let Set::PtpCmd(back) = build::move_joints(0.0, 50.0, 45.0, 0.0) else {
        panic!()
    };
    arm.set(&back).await.unwrap();
    arm.wait_still().await.unwrap();
    assert!(!arm.alarms().await.unwrap().blocking());
    let Set::PtpCmd(back) = build::move_joints(0.0, 45.0, 45.0, 0.0) else {
        panic!()
    };
    let index = arm.enqueue(&back).await.unwrap();
    let error = arm.wait(index).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm);
    assert!(error.alarms().unwrap().is_empty());
    assert!(
        error.remedies()[0].act == Act::Do(Action::ClearAlarms),
        "{error}"
    );
    arm.clear_alarms().await.unwrap();
    arm.wait(index).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_move_of_the_rail_alone_is_no_hold() {
    let (near, mut far) = duplex(1 << 16);
    let bench = tokio::spawn(async move {
        let begun = Instant::now();
        let mut controller = Controller::new(Profile::default());
        let mut started = false;
        loop {
            let request = next_request(&mut far).await;
            let now = begun.elapsed();
            // The rail takes eight seconds, and nothing else moves meanwhile.
            if now > Duration::from_secs(8) && !std::mem::replace(&mut started, true) {
                let start = FrameBuf::new(240, Ctrl::SET, &[]).unwrap();
                controller.receive(magician::sim::LinkId(1), start.bytes());
            }
            let reply = match request.frame().id() {
                240 => Some(FrameBuf::new(240, Ctrl::SET, &[]).unwrap()),
                13 => {
                    let l = now.as_secs_f32() * 100.0;
                    Some(FrameBuf::new(13, Ctrl::GET, &l.to_le_bytes()).unwrap())
                }
                _ => {
                    controller.advance(ArmInstant::ZERO + now);
                    controller.receive(magician::sim::LinkId(0), request.bytes());
                    controller.poll_transmit(magician::sim::LinkId(0))
                }
            };
            let _ = far
                .write_all(reply.expect("every request is known").bytes())
                .await;
        }
    });
    let arm = Arm::over(near, Options::default()).await.unwrap();
    let here: Pose = arm.get().await.unwrap();
    let along = build::move_with_rail(here.x, here.y, here.z, here.r, 800.0);
    let begun = Instant::now();
    arm.start([along]).wait(|_| {}).await.unwrap();
    assert!(begun.elapsed() > Duration::from_secs(7));
    arm.close().await;
    bench.abort();
}

#[tokio::test(start_paused = true)]
async fn a_wait_of_another_program_before_ours_is_no_hold() {
    let mut controller = Controller::new(Profile::default());
    let left = FrameBuf::encode(110, Ctrl::QUEUED, &WaitCmd { timeout: 20_000 }).unwrap();
    controller.receive(magician::sim::LinkId(7), left.bytes());
    let runner = Runner::new(controller, Speed::Times(1.0), LineTiming::default());
    let arm = Arm::simulated(runner, Options::default()).await.unwrap();
    let options = RunOptions::default().keep(true);
    arm.start_with([build::move_to(200.0, 50.0, 20.0, 0.0)], options)
        .wait(|_| {})
        .await
        .unwrap();
}

/// Returns how a wait for the next command ends in a stopped queue, and after how long.
async fn given_up(arm: &Arm, command: impl Into<Set>) -> (Duration, magician::Error) {
    let index = arm.enqueue_set(&command.into()).await.unwrap();
    let begun = Instant::now();
    let error = arm.wait(index).await.unwrap_err();
    (begun.elapsed(), error)
}

#[tokio::test(start_paused = true)]
async fn a_wait_in_a_queue_that_this_handle_stopped_ends_soon() {
    let arm = real_time().await;
    arm.queue().start().await.unwrap();
    arm.stop_gentle().await.unwrap();
    for command in [
        build::wait(Duration::from_secs(3600)),
        build::move_by(0.0, 5.0, 0.0, 0.0),
    ] {
        let (after, error) = given_up(&arm, command).await;
        assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
        assert!(after < Duration::from_secs(2), "{after:?}");
        assert_eq!(error.code(), ErrorCode::QueueStopped);
        assert_eq!(error.remedies()[0].act, Act::Do(Action::StartQueue));
    }
    arm.queue().start().await.unwrap();
    arm.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_queue_that_nobody_of_this_program_started_is_given_time() {
    let arm = real_time().await;
    let (after, error) = given_up(&arm, build::move_by(0.0, 5.0, 0.0, 0.0)).await;
    assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
    let secs = after.as_secs_f64();
    assert!((5.0..5.5).contains(&secs), "{secs}");
    assert!(error.to_string().contains("not started, or is stopped"));
    assert_eq!(error.code(), ErrorCode::QueueStopped);
    // The command was not dropped.
    arm.queue().start().await.unwrap();
    let last = arm.enqueue(&WaitCmd { timeout: 0 }).await.unwrap();
    arm.wait(last).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn another_program_that_starts_the_queue_soon_is_waited_for() {
    let desk = crate::desk::Desk::new();
    let arm = desk.connect(Options::default()).await;
    let index = arm.enqueue(&WaitCmd { timeout: 100 }).await.unwrap();
    let (waited, ()) = tokio::join!(arm.wait(index), async {
        tokio::time::sleep(Duration::from_secs(4)).await;
        let start = FrameBuf::new(240, Ctrl::SET, &[]).unwrap();
        desk.with(|controller| controller.receive(magician::sim::LinkId(7), start.bytes()));
    });
    waited.unwrap();
    // The same for a queue that another task of this program starts.
    arm.stop_gentle().await.unwrap();
    let index = arm.enqueue(&WaitCmd { timeout: 100 }).await.unwrap();
    let (waited, started) = tokio::join!(arm.wait(index), async {
        tokio::time::sleep(Duration::from_secs(1)).await;
        arm.queue().start().await
    });
    waited.and(started).unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_motor_that_runs_for_long_is_no_hold() {
    let arm = real_time().await;
    let begun = Instant::now();
    let belt = build::conveyor_by(magician::protocol::Stepper::Stepper1, 800.0, 20.0);
    arm.start([belt]).wait(|_| {}).await.unwrap();
    assert!(begun.elapsed() > Duration::from_secs(39));
}
