//! Refusals before anything is sent.

use std::time::Duration;

use magician::commands::{EndEffectorParams, JogCmd};
use magician::preflight::Guards;
use magician::protocol::{CpMode, Flag, FrameBuf, JogCommand};
use magician::sim::LinkId;
use magician::{Act, Action, Ctrl, ErrorKind, Options, RunOptions, Set, build};
use magician_motion::ArmModel;
use tokio::time::sleep;

use crate::bench::{fast, real_time};
use crate::desk::Desk;

#[tokio::test(start_paused = true)]
async fn checks_before_a_byte_is_sent() {
    let arm = fast().await;
    let (before, _) = arm.stats().await.unwrap();
    let bad = [
        build::line_to(250.0, 0.0, 20.0, 0.0),
        build::move_to(500.0, 0.0, 0.0, 0.0),
    ];
    let error = arm.run(&bad).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unreachable);
    assert_eq!(
        (error.command(), error.step()),
        (Some("SetPTPCmd"), Some(1))
    );
    assert!(error.value() > error.limit() && error.unit() == Some("mm"));
    let nan = arm
        .run(&[build::move_to(f32::NAN, 0.0, 0.0, 0.0)])
        .await
        .unwrap_err();
    assert_eq!((nan.kind(), nan.step()), (ErrorKind::InvalidInput, None));
    let (after, _) = arm.stats().await.unwrap();
    assert_eq!(after.sent - before.sent, 17, "only reads");
    assert_eq!(arm.queue().current_index().await.unwrap().0, 0);
}

#[test]
fn the_check_follows_the_arm() {
    use magician::{JointAngles, ToolBias, preflight::Preflight};

    let mut check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    check.check(&build::line_by(0.0, 50.0, 0.0, 0.0)).unwrap();
    assert!((check.arm().unwrap().pose.y - 50.0).abs() < 1e-9);
    check.check(&build::tool(ToolBias::SUCTION)).unwrap();
    assert!(
        check.arm().unwrap().pose.x > 250.0,
        "the tool point is further out now"
    );
    // Both ends are reachable, but the straight line between them passes through the base.
    check.check(&build::move_to(0.0, 200.0, 50.0, 0.0)).unwrap();
    let through = check
        .check(&build::line_to(0.0, -200.0, 50.0, 0.0))
        .unwrap_err();
    assert_eq!(through.kind(), ErrorKind::Unreachable);
    check
        .check(&build::move_to(0.0, -200.0, 50.0, 0.0))
        .unwrap();
    let relative = CpMode::Relative;
    let segment = magician::commands::CpCmd {
        cp_mode: relative,
        x: 0.0,
        y: -500.0,
        z: 0.0,
        velocity_or_power: 0.0,
    };
    assert!(check.check(&segment.into()).is_err());
    let strict = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let mut strict = strict.limits(ArmModel::MAGICIAN.guaranteed);
    let error = strict
        .check(&build::move_joints(100.0, 45.0, 45.0, 0.0))
        .unwrap_err();
    assert_eq!((error.value(), error.limit()), (Some(100.0), Some(90.0)));
    let slow = strict.check(&build::speed(0.0, 50.0)).unwrap_err();
    assert_eq!(slow.kind(), ErrorKind::InvalidInput);
    let tool = EndEffectorParams {
        x_bias: f32::INFINITY,
        y_bias: 0.0,
        z_bias: 0.0,
    };
    assert!(strict.check(&tool.into()).is_err());
}

#[tokio::test(start_paused = true)]
async fn nothing_begins_under_an_alarm_but_homing() {
    let arm = fast().await;
    arm.enqueue_set(&build::line_to(500.0, 0.0, 0.0, 0.0))
        .await
        .unwrap();
    arm.queue().start().await.unwrap();
    let near = [build::move_to(200.0, 50.0, 20.0, 0.0)];
    let error = arm.run(&near).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm);
    assert_eq!(error.remedies()[0].act, Act::Do(Action::ClearAlarms));
    assert!(error.alarms().is_some_and(|alarms| alarms.contains(0x11)));
    arm.run(&[build::home()]).await.unwrap();
    arm.clear_alarms().await.unwrap();
    arm.run(&near).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_was_not_homed_is_refused_on_request() {
    let arm = fast().await;
    let near = [build::move_to(200.0, 50.0, 20.0, 0.0)];
    let strict = Guards::ALL;
    let error = arm
        .run_with(&near, RunOptions::default().guards(strict), |_| {})
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    assert_eq!(error.guard(), Some("require_homed"), "{error}");
    arm.home().await.unwrap();
    arm.run_with(&near, RunOptions::default().guards(strict), |_| {})
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_moving_arm_is_at_an_unknown_start() {
    let arm = real_time().await;
    assert!(arm.preflight().await.unwrap().arm().is_some());
    let index = arm
        .enqueue_set(&build::move_to(200.0, 100.0, 20.0, 0.0))
        .await
        .unwrap();
    let waiting = arm.preflight().await.unwrap();
    assert!(waiting.arm().is_none(), "a command waits in the queue");
    arm.queue().start().await.unwrap();
    let line = [build::line_to(200.0, 0.0, 20.0, 0.0)];
    let error = arm.run(&line).await.unwrap_err();
    assert_eq!(error.guard(), Some("unknown_start"), "{error}");
    arm.wait(index).await.unwrap();
    arm.run(&line).await.unwrap();
}

/// During a jog of another program only poses show that the arm moves.
#[tokio::test(start_paused = true)]
async fn an_arm_that_moves_or_turns_round_is_at_an_unknown_start_however_fast_it_is_read() {
    // Frames at 1000, 200 and 50 Hz: six of them take less than a period, and more than two.
    for turnaround in [1, 5, 20].map(Duration::from_millis) {
        for phase in 0..12 {
            // Moving at constant speed, and close to zero speed, 0.5 s after a reversal.
            for (turned, later) in [(false, 600), (true, 440)] {
                let desk = Desk::new();
                let arm = desk.connect(Options::default()).await;
                desk.answers_after(turnaround);
                let jog = |command| {
                    let jog = JogCmd {
                        is_joint: Flag::OFF,
                        cmd: JogCommand::from(command),
                    };
                    let frame = FrameBuf::set(&Set::from(jog), Ctrl::SET).unwrap();
                    desk.with(|arm| arm.receive(LinkId(5), frame.bytes()));
                };
                jog(3);
                if turned {
                    sleep(Duration::from_millis(600)).await;
                    jog(4);
                }
                sleep(Duration::from_millis(later + 7 * phase)).await;
                let told = format!("{turnaround:?} {phase} {turned}");
                assert!(arm.preflight().await.unwrap().arm().is_none(), "{told}");
                jog(0);
                sleep(Duration::from_secs(2)).await;
                assert!(arm.preflight().await.unwrap().arm().is_some(), "{told}");
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_speeds_in_force_are_read() {
    let arm = fast().await;
    let line = build::line_by(0.0, 100.0, 0.0, 0.0);
    let slow = arm.preflight().await.unwrap().estimate(&[line]).unwrap();
    arm.set(&magician::commands::PtpCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    })
    .await
    .unwrap();
    let fast = arm
        .preflight_for(&[line])
        .await
        .unwrap()
        .estimate(&[line])
        .unwrap();
    // 1.414 s in whole periods of 20 ms.
    assert_eq!((slow.as_millis(), fast.as_millis()), (2000, 1420));
}
