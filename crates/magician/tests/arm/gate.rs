//! Motion gate: successive jogs, unbounded jogs, motors.

use std::time::Duration;

use magician::build::{self, Axis, JogDirection};
use magician::commands::{EMotor, EMotorS, JogCmd, SetDeviceWithL};
use magician::protocol::{Flag, FrameBuf, JogCommand, RailVersion, Stepper};
use magician::sim::LinkId;
use magician::{
    Act, Action, Arm, Ctrl, ErrorCode, ErrorKind, Jog, Options, RunOptions, Set, VirtualArm,
};
use tokio::time::{Instant, sleep, timeout};

use crate::desk::{Desk, begin_immediate_motion, only_reads};

const JOG: u8 = 73;
const MOTOR: u8 = 135;

/// Renews a jog for this time.
async fn hold(jog: &Jog, ms: u64) {
    for _ in 0..ms / 50 {
        jog.keep().unwrap();
        sleep(Duration::from_millis(50)).await;
    }
}

fn params(direction: JogDirection) -> Vec<u8> {
    let frame = FrameBuf::set(&direction.into(), Ctrl::SET).unwrap();
    frame.frame().params().to_vec()
}

/// True for each motor output that is running.
fn turning(desk: &Desk) -> [bool; 2] {
    desk.with(|arm| {
        arm.steppers()
            .map(|stepper| stepper.pulses_per_second != 0.0)
    })
}

fn belt(speed: f32) -> Set {
    build::conveyor(Stepper::Stepper1, speed)
}

#[tokio::test(start_paused = true)]
async fn jog_of_another_axis_begins_when_the_arm_stands() {
    let changes = [
        (Axis::X.plus(), Axis::Y.plus()),
        (Axis::X.plus(), Axis::Z.minus()),
        (Axis::Z.minus(), Axis::X.plus()),
        (Axis::J1.plus(), Axis::J2.plus()),
        (Axis::X.plus(), Axis::J1.plus()),
    ];
    for (first, second) in changes {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        desk.heard();
        let held = arm.jog(first).await.unwrap();
        hold(&held, 500).await;
        // Another handle jogs while the first is held.
        let next = arm.clone().jog(second).await.unwrap();
        assert_eq!(held.keep().unwrap_err().kind(), ErrorKind::Closed);
        hold(&next, 300).await;
        let jogs = desk.frames(JOG);
        let (begun, moved): (Vec<_>, Vec<_>) = jogs
            .iter()
            .filter(|(params, _)| params[1] != 0)
            .cloned()
            .unzip();
        assert_eq!(begun, [params(first), params(second)]);
        assert_eq!(
            moved,
            [false, false],
            "each begins at rest: {first} {second}"
        );
        let stops = jogs
            .iter()
            .position(|(params, moved)| params[1] == 0 && *moved);
        assert_eq!(stops, Some(1), "the stop of the first: {jogs:?}");
        next.stop().await.unwrap();
        held.stop().await.unwrap();
    }
}

/// The pose of the arm does not show that its rail brakes.
#[tokio::test(start_paused = true)]
async fn jog_behind_one_of_the_rail_begins_when_the_rail_stands() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let rail = SetDeviceWithL {
        with_l: Flag::ON,
        version: Some(RailVersion::V2),
    };
    arm.set(&rail).await.unwrap();
    let held = arm.jog(Axis::L.plus()).await.unwrap();
    hold(&held, 1000).await;
    desk.heard();
    let next = arm.jog(Axis::X.plus()).await.unwrap();
    let jogs = desk.frames(JOG);
    let begun = jogs.iter().filter(|(params, _)| params[1] != 0);
    let moved: Vec<_> = begun.map(|(_, moved)| *moved).collect();
    assert_eq!(moved, [false], "{jogs:?}");
    next.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn opposite_direction_of_the_same_axis_begins_at_once() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    desk.heard();
    let first = arm.jog(Axis::X.plus()).await.unwrap();
    hold(&first, 500).await;
    let second = arm.jog(Axis::X.minus()).await.unwrap();
    hold(&second, 300).await;
    let jogs = desk.frames(JOG);
    let expected = [
        (params(Axis::X.plus()), false),
        (params(Axis::X.minus()), true),
    ];
    assert_eq!(jogs, expected);
}

#[tokio::test(start_paused = true)]
async fn stop_returns_once_the_arm_has_stood_although_another_jog_begins_then() {
    // In each case the end of the jog and the stop read the pose at different times.
    for ended in (0..100).step_by(7) {
        for later in [1, 11, 21] {
            let desk = Desk::new();
            let arm = desk.connect(Options::default()).await;
            let first = arm.jog(Axis::Y.plus()).await.unwrap();
            hold(&first, 500).await;
            drop(first);
            sleep(Duration::from_millis(ended)).await;
            let began = Instant::now();
            let stop = arm.clone();
            let stop = tokio::spawn(async move { stop.stop().await.map(|()| began.elapsed()) });
            sleep(Duration::from_millis(later)).await;
            let next = arm.jog(Axis::Y.minus()).await.unwrap();
            hold(&next, 3000).await;
            let took = stop.await.unwrap().unwrap();
            let limit = Duration::from_millis(500);
            assert!(took < limit, "{ended} ms, {later} ms: {took:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn reversal_passes_each_place_twice_and_goes_on() {
    // In each case the reads have another phase to the turning point.
    for first in (300..500).step_by(10) {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        let left = arm.jog(Axis::X.plus()).await.unwrap();
        for _ in 0..first / 10 {
            left.keep().unwrap();
            sleep(Duration::from_millis(10)).await;
        }
        let right = arm.jog(Axis::X.minus()).await.unwrap();
        hold(&right, 1500).await;
        assert!(desk.moves(), "after {first} ms");
    }
}

#[tokio::test(start_paused = true)]
async fn jog_released_while_the_arm_comes_to_rest_starts_nothing() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let first = arm.jog(Axis::X.plus()).await.unwrap();
    hold(&first, 500).await;
    desk.heard();
    let given_up = timeout(Duration::from_millis(100), arm.jog(Axis::Y.plus())).await;
    assert!(given_up.is_err(), "the arm brakes for 0.5 s");
    sleep(Duration::from_secs(2)).await;
    assert!(!desk.moves());
    let jogs = desk.frames(JOG);
    assert!(jogs.iter().all(|(params, _)| params[1] == 0), "{jogs:?}");
}

#[tokio::test(start_paused = true)]
async fn stop_while_the_arm_comes_to_rest_ends_the_jog_that_waits() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let first = arm.jog(Axis::X.plus()).await.unwrap();
    hold(&first, 500).await;
    let other = arm.clone();
    let waiting = tokio::spawn(async move { other.jog(Axis::Y.plus()).await });
    sleep(Duration::from_millis(100)).await;
    desk.heard();
    arm.stopper().request_stop().unwrap();
    let error = waiting.await.unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    sleep(Duration::from_secs(2)).await;
    assert!(!desk.moves());
    let jogs = desk.frames(JOG);
    assert!(jogs.iter().all(|(params, _)| params[1] == 0), "{jogs:?}");
}

#[tokio::test(start_paused = true)]
async fn jog_that_nothing_holds_is_refused_before_anything_is_sent() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = JogCmd::from(Axis::J1.plus());
    let command = Set::from(jog);
    let frame = FrameBuf::set(&command, Ctrl::SET).unwrap();
    let bytes = frame.frame().params().to_vec();
    desk.heard();
    let refused = [
        arm.set(&jog).await.map(drop),
        arm.set_any(&command).await,
        arm.raw(JOG, Ctrl::SET, &bytes).await.map(drop),
        arm.raw(JOG, Ctrl::QUEUED, &bytes).await.map(drop),
        arm.enqueue(&jog).await.map(drop),
        arm.enqueue_form(JOG, &bytes).await.map(drop),
        arm.run(&[command]).await.map(drop),
        arm.start([command]).wait(|_| {}).await.map(drop),
        {
            let (feeder, streaming) = arm.stream(1, RunOptions::default());
            feeder.push(command);
            feeder.end();
            streaming.wait(|_| {}).await.map(drop)
        },
    ];
    for (nth, refused) in refused.into_iter().enumerate() {
        let error = refused.unwrap_err();
        assert_eq!(error.code(), ErrorCode::Guarded, "{nth}: {error}");
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        let acts = error.remedies().iter().map(|remedy| remedy.act.clone());
        assert_eq!(acts.collect::<Vec<_>>(), [Act::Do(Action::Jog)]);
    }
    assert!(only_reads(&desk.heard()), "nothing was sent");
    // In the middle of a list the commands before it are sent.
    let list = [build::wait(Duration::ZERO), command];
    let error = arm.start(list).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.code(), ErrorCode::Guarded, "{error}");
    assert_eq!(desk.count(JOG), 0);
    // The end of a jog is a stop.
    let stop = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Stop,
    };
    arm.set(&stop).await.unwrap();
    assert_eq!(desk.count(JOG), 1);
}

#[tokio::test(start_paused = true)]
async fn jog_of_another_program_ends_before_one_of_ours_begins() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let passed = arm.front_end().passing_jogs();
    passed.set(&JogCmd::from(Axis::X.plus())).await.unwrap();
    sleep(Duration::from_millis(500)).await;
    desk.heard();
    // The same axis, with another holder.
    let jog = arm.jog(Axis::X.minus()).await.unwrap();
    hold(&jog, 200).await;
    let jogs = desk.frames(JOG);
    let begun = jogs.iter().find(|(params, _)| params[1] != 0);
    assert_eq!(begun, Some(&(params(Axis::X.minus()), false)), "{jogs:?}");
    assert_eq!(jogs[0].0[1], 0, "{jogs:?}");
}

#[tokio::test(start_paused = true)]
async fn jog_into_the_end_of_its_axis_ends() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let jog = arm.jog(Axis::J1.plus()).await.unwrap();
    let mut kept = 0;
    let error = loop {
        match jog.keep() {
            Ok(()) => kept += 1,
            Err(error) => break error,
        }
        sleep(Duration::from_millis(50)).await;
    };
    assert_eq!(error.kind(), ErrorKind::Unreachable, "{error}");
    let stood = desk.with(|arm| arm.state().joints.j1);
    assert_eq!(stood.round(), 135.0, "after {kept} keeps");
    sleep(Duration::from_millis(200)).await;
    let jogs = desk.frames(JOG);
    assert_eq!(jogs.last().map(|(params, _)| params[1]), Some(0));
    assert!(!arm.moving());
    // Outwards it does not move, inwards it does.
    let out = arm.jog(Axis::J1.plus()).await.unwrap();
    for _ in 0..20 {
        let _ = out.keep();
        sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(out.keep().unwrap_err().kind(), ErrorKind::Unreachable);
    let back = arm.jog(Axis::J1.minus()).await.unwrap();
    hold(&back, 1000).await;
    back.stop().await.unwrap();
    assert!(desk.with(|arm| arm.state().joints.j1) < 134.0);
}

#[tokio::test(start_paused = true)]
async fn stop_switches_both_motor_outputs_off_behind_its_own_frames() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let acts = || {
        let acts = desk.heard().into_iter().filter(|(_, acts)| *acts);
        acts.map(|(id, _)| id).collect::<Vec<_>>()
    };
    let foreign = EMotor {
        index: Stepper::Stepper2,
        is_enabled: Flag::ON,
        speed: 1000,
    };
    let foreign = FrameBuf::set(&foreign.into(), Ctrl::SET).unwrap();
    for by_stopper in [false, true] {
        arm.set_any(&belt(50.0)).await.unwrap();
        // Another program started the other output.
        desk.with(|arm| arm.receive(LinkId(5), foreign.bytes()));
        assert_eq!(turning(&desk), [true, true]);
        assert_eq!(arm.motors().running(), [Stepper::Stepper1]);
        acts();
        if by_stopper {
            arm.stopper().request_stop().unwrap();
            sleep(Duration::from_millis(100)).await;
        } else {
            arm.stop().await.unwrap();
        }
        assert_eq!(turning(&desk), [false, false]);
        assert_eq!(acts(), [242, 61, 245, MOTOR, MOTOR]);
        assert_eq!(arm.motors().running(), []);
    }
    // A stop does not fail on an arm without motor outputs.
    desk.swallow(&[MOTOR]);
    arm.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn motor_ends_with_the_last_handle_unless_detached() {
    let steady = belt(50.0);
    let counted = Set::from(EMotorS {
        index: Stepper::Stepper1,
        is_enabled: Flag::ON,
        speed: 1000,
        distance: 1_000_000,
    });
    for (command, queued, detached) in [
        (steady, false, false),
        (steady, false, true),
        (steady, true, false),
        (counted, false, false),
    ] {
        let desk = Desk::new();
        let arm = desk.connect(Options::default()).await;
        if queued {
            arm.run(&[command]).await.unwrap();
        } else {
            arm.set_any(&command).await.unwrap();
        }
        assert!(turning(&desk)[0]);
        if detached {
            arm.detach();
        }
        arm.close().await;
        assert_eq!(turning(&desk)[0], detached, "{command:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn motor_that_the_queue_is_to_stop_ends_with_a_handle_that_goes_before() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let program = [belt(50.0), build::wait(Duration::from_secs(60)), belt(0.0)];
    let ran = arm.clone();
    let running = tokio::spawn(async move { ran.start(program).wait(|_| {}).await });
    sleep(Duration::from_secs(2)).await;
    assert!(turning(&desk)[0]);
    arm.close().await;
    assert!(!turning(&desk)[0]);
    running.await.unwrap().unwrap_err();
}

#[tokio::test(start_paused = true)]
async fn motors_are_switched_off_alone() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    arm.motors().stop().await.unwrap();
    desk.heard();
    arm.set_any(&belt(50.0)).await.unwrap();
    arm.motors().stop().await.unwrap();
    assert_eq!(desk.count(MOTOR), 2, "one on, one off");
    assert_eq!(turning(&desk), [false, false]);
}

#[tokio::test(start_paused = true)]
async fn jogs_keep_to_the_gate_on_a_virtual_arm_in_the_process() {
    let arm = Arm::simulated(VirtualArm::default(), Options::default())
        .await
        .unwrap();
    let jog = JogCmd::from(Axis::J1.plus());
    let error = arm.set(&jog).await.unwrap_err();
    assert_eq!(error.code(), ErrorCode::Guarded, "{error}");
}

/// Jogs a moving arm: one jog begins, and only when the arm is at rest.
async fn jog_begins_at_rest(desk: &Desk, arm: &Arm) {
    desk.heard();
    let held = arm.jog(Axis::Z.plus()).await.unwrap();
    hold(&held, 200).await;
    let begun = desk.frames(JOG);
    let begun = begun.iter().filter(|(params, _)| params[1] != 0);
    let moved: Vec<_> = begun.map(|(_, moved)| *moved).collect();
    assert_eq!(moved, [false]);
    held.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn jog_behind_a_forced_stop_begins_when_the_arm_stands() {
    let far = build::line_to(220.0, 120.0, 20.0, 0.0);
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    let mut moving = arm.start([far]);
    let waited = tokio::spawn(async move { moving.wait(|_| {}).await });
    sleep(Duration::from_millis(800)).await;
    let stop = magician::commands::QueuedCmdForceStopExec {};
    arm.set_any(&Set::from(stop)).await.unwrap();
    waited.await.unwrap().unwrap_err();
    assert!(desk.moves(), "it brakes");
    jog_begins_at_rest(&desk, &arm).await;
}

/// An immediate motion has no index: only the pose shows its end.
#[tokio::test(start_paused = true)]
async fn jog_behind_an_immediate_motion_begins_when_the_arm_stands() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    begin_immediate_motion(&arm).await;
    jog_begins_at_rest(&desk, &arm).await;
}
