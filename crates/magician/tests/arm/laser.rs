//! Permission to light the laser, and switching it off.

use std::time::Duration;

use magician::build;
use magician::commands::{
    ClearAlarmsState, CpParams, IoMultiplexing, IoPwm, QueuedCmdStartExec, SetEndEffectorLaser,
    WaitCmd,
};
use magician::preflight::Guards;
use magician::protocol::{Flag, FrameBuf, IoFunction};
use magician::sim::Controller;
use magician::{
    Act, Action, Arm, Ctrl, ErrorCode, ErrorKind, Options, RunOptions, Set, SimSpeed, VirtualArm,
};
use tokio::time::sleep;

use crate::desk::{Desk, only_reads};

const LASER: u8 = 61;
const STOP: u8 = 241;
const FORCED_STOP: u8 = 242;
const CLEAR: u8 = 245;

fn on() -> SetEndEffectorLaser {
    SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::ON,
    }
}

fn burn(x: f32, y: f32) -> Set {
    build::engrave_to(x, y, 0.0, 60.0)
}

fn allowed() -> Options {
    Options::default().allow_laser(true)
}

/// Returns one command of each kind that lights the laser.
fn burning() -> [Set; 6] {
    let outputs = [build::Output {
        percent: 50,
        address: 4,
        high: true,
    }];
    [
        build::laser(true),
        burn(200.0, 10.0),
        build::output(2, true),
        build::output(4, true),
        build::pwm(4, 1000.0, 20.0),
        build::with_outputs(build::move_to(200.0, 0.0, 0.0, 0.0), &outputs).unwrap(),
    ]
}

#[tokio::test(start_paused = true)]
async fn nothing_burns_on_a_real_arm_that_nobody_has_allowed_it_on() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    for command in burning() {
        let frame = FrameBuf::set(&command, Ctrl::SET).unwrap();
        let (id, params) = (frame.frame().id(), frame.frame().params());
        let outcomes = [
            arm.set_any(&command).await.err(),
            arm.enqueue_set(&command).await.err(),
            arm.enqueue_form(id, params).await.err(),
            arm.raw(id, Ctrl::SET, params).await.err(),
            arm.raw(id, Ctrl::QUEUED, params).await.err(),
            arm.run_with(
                &[command],
                RunOptions::default().guards(Guards::NONE),
                |_| {},
            )
            .await
            .err(),
            arm.start([build::wait(Duration::from_millis(1)), command])
                .wait(|_| {})
                .await
                .err(),
        ];
        for (door, error) in outcomes.into_iter().enumerate() {
            let error = error.unwrap_or_else(|| panic!("door {door}: {command:?}"));
            assert_eq!(
                error.kind(),
                ErrorKind::InvalidInput,
                "door {door}: {error}"
            );
            assert_eq!(
                error.code(),
                ErrorCode::LaserNotAllowed,
                "door {door}: {error}"
            );
        }
        assert!(only_reads(&desk.heard()), "{command:?}");
        assert!(!arm.laser().burns(&build::laser(false)) && arm.laser().burns(&command));
        // With permission it is sent.
        arm.allowing_laser().set_any(&command).await.unwrap();
        assert!(!only_reads(&desk.heard()), "{command:?}");
    }
    // A long program ends before the command that burns.
    let waits = std::iter::repeat_n(build::wait(Duration::from_millis(1)), 60);
    let program = waits.chain([build::laser(true)]);
    let error = arm.start(program).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.code(), ErrorCode::LaserNotAllowed, "{error}");
    assert!(!desk.heard().contains(&(LASER, true)));
}

#[tokio::test(start_paused = true)]
async fn an_arm_without_a_laser_has_its_pins_for_itself() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default().laser_pins(false)).await;
    for command in burning() {
        let refused = arm.set_any(&command).await.is_err();
        let is_laser = matches!(command, Set::SetEndEffectorLaser(_) | Set::CpLeCmd(_));
        assert_eq!(refused, is_laser, "{command:?}");
    }
}

#[tokio::test]
async fn a_virtual_arm_in_this_process_is_never_refused() {
    let arm = Arm::simulated(VirtualArm::default(), Options::default()).await;
    let arm = arm.unwrap();
    assert!(arm.is_virtual() && arm.laser().may_burn());
    for command in burning() {
        arm.set_any(&command).await.unwrap();
    }
}

#[tokio::test(start_paused = true)]
async fn a_queue_with_commands_of_another_program_is_not_let_run() {
    let desk = Desk::new();
    let other = desk.connect(Options::default()).await;
    other.enqueue(&WaitCmd { timeout: 10 }).await.unwrap();
    other.detach();
    other.close().await;
    let arm = desk.connect(Options::default()).await;
    desk.heard();
    let keep = || RunOptions::default().keep(true);
    let wait = build::wait(Duration::from_millis(1));
    for (door, outcome) in [
        arm.queue().start().await,
        arm.clear_alarms().await,
        arm.set(&QueuedCmdStartExec {}).await,
        arm.set_any(&Set::ClearAlarmsState(ClearAlarmsState {}))
            .await,
        arm.raw(240, Ctrl::SET, &[]).await.map(drop),
        arm.start_with([wait], keep()).wait(|_| {}).await.map(drop),
        arm.home_with(keep()).await,
    ]
    .into_iter()
    .enumerate()
    {
        let error = outcome.expect_err(&format!("door {door}"));
        assert_eq!(
            error.code(),
            ErrorCode::LaserNotAllowed,
            "door {door}: {error}"
        );
    }
    assert!(only_reads(&desk.heard()));
    arm.allowing_laser().queue().start().await.unwrap();
    sleep(Duration::from_secs(1)).await;
    // Commands that this connection queued are known to it.
    arm.stop_gentle().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 10 }).await.unwrap();
    arm.queue().start().await.unwrap();
    arm.clear_alarms().await.unwrap();
}

/// Starts to burn a slow line of this length, mm.
async fn begin_to_burn(arm: &Arm, length: f32) {
    let speeds = CpParams {
        plan_acc: 100.0,
        junction_vel: 5.0,
        acc_or_period: 100.0,
        real_time_track: Flag::OFF,
    };
    arm.set(&speeds).await.unwrap();
    arm.run(&[build::path_to(200.0, 0.0, 0.0)]).await.unwrap();
    let arm = arm.clone();
    tokio::spawn(async move {
        let guards = Guards::default().laser(false);
        arm.run_with(
            &[burn(200.0, length)],
            RunOptions::default().guards(guards),
            |_| {},
        )
        .await
    });
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_found_again_puts_the_laser_out_before_anything_else() {
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    sleep(Duration::from_millis(200)).await;
    begin_to_burn(&arm, 100.0).await;
    sleep(Duration::from_secs(4)).await;
    assert!(desk.with(|arm| arm.state().laser));
    desk.unplug();
    sleep(Duration::from_millis(150)).await;
    desk.heard();
    desk.plug();
    arm.reconnected().await.unwrap();
    let heard = desk.heard();
    assert_eq!(heard[..2], [(LASER, true), (STOP, true)], "{heard:?}");
    let behind: Vec<_> = heard[2..].iter().filter(|(_, acts)| *acts).collect();
    assert_eq!(behind, [&(CLEAR, true)], "{heard:?}");
    desk.with(|arm| {
        let state = arm.state();
        assert!(
            !state.laser && !state.queue.started && state.queue.waiting == 0,
            "{state:?}"
        );
    });
    // Once is enough.
    desk.unplug();
    sleep(Duration::from_millis(150)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    assert!(only_reads(&desk.heard()));
}

/// A Clear may cut off the piece in progress, and the arm would count it as finished.
#[tokio::test(start_paused = true)]
async fn queue_of_a_burn_is_cleared_once_the_arm_stands_on_a_line_that_is_found_again() {
    for late in 0..10 {
        let desk = Desk::new();
        let arm = desk.connect(allowed()).await;
        sleep(Duration::from_millis(200)).await;
        begin_to_burn(&arm, 20.0).await;
        sleep(Duration::from_millis(2000 + 137 * late)).await;
        desk.unplug();
        sleep(Duration::from_millis(150)).await;
        assert!(desk.moves(), "{late}");
        desk.heard();
        desk.plug();
        arm.reconnected().await.unwrap();
        assert_eq!(desk.frames(CLEAR), [(vec![], false)], "{late}");
    }
}

/// Burns a segment of 20 s and loses the line, which is plugged in again on return.
async fn long_burn_is_found_again(desk: &Desk) -> Arm {
    let arm = desk.connect(allowed()).await;
    sleep(Duration::from_millis(200)).await;
    begin_to_burn(&arm, 0.5).await;
    sleep(Duration::from_secs(2)).await;
    arm.enqueue_set(&burn(200.0, 100.0)).await.unwrap();
    arm.queue().start().await.unwrap();
    sleep(Duration::from_secs(4)).await;
    desk.unplug();
    sleep(Duration::from_millis(150)).await;
    desk.heard();
    desk.plug();
    arm
}

/// Returns the ids of the frames since the last call that were no reads.
fn acts(desk: &Desk) -> Vec<u8> {
    let acting = desk.heard().into_iter().filter(|(_, acts)| *acts);
    acting.map(|(id, _)| id).collect()
}

#[tokio::test(start_paused = true)]
async fn arm_that_does_not_come_to_rest_is_stopped_on_a_line_that_is_found_again() {
    let desk = Desk::new();
    let arm = long_burn_is_found_again(&desk).await;
    sleep(Duration::from_millis(1900)).await;
    assert!(desk.moves());
    assert_eq!(acts(&desk), [LASER, STOP]);
    arm.reconnected().await.unwrap();
    assert_eq!(acts(&desk)[..3], [FORCED_STOP, LASER, CLEAR]);
    // Braking from 5 mm/s takes a few periods.
    sleep(Duration::from_millis(100)).await;
    assert!(!desk.moves());
    assert_eq!(desk.with(|arm| arm.state().queue.waiting), 0);
}

#[tokio::test(start_paused = true)]
async fn stop_does_not_wait_for_the_arm_to_stand_on_a_line_that_is_found_again() {
    for early in [false, true] {
        let desk = Desk::new();
        let arm = long_burn_is_found_again(&desk).await;
        if early {
            // Requested before the line is reopened.
            arm.stopper().request_stop().unwrap();
        }
        // A lost line is searched for every 250 ms.
        sleep(Duration::from_millis(300)).await;
        if !early {
            assert!(!acts(&desk).contains(&FORCED_STOP));
            arm.stopper().request_stop().unwrap();
            // Pose, version and serial number are read first.
            sleep(Duration::from_millis(60)).await;
        }
        assert!(acts(&desk).contains(&FORCED_STOP), "{early}");
        sleep(Duration::from_millis(100)).await;
        assert!(!desk.moves(), "{early}");
    }
}

#[tokio::test(start_paused = true)]
async fn run_that_was_stopped_on_a_line_that_is_found_again_does_not_go_on() {
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    sleep(Duration::from_millis(200)).await;
    begin_to_burn(&arm, 0.5).await;
    sleep(Duration::from_secs(2)).await;
    // A single piece.
    let options = RunOptions::default().laser_horizon(Duration::from_secs(60));
    let mut run = arm.start_with([burn(200.0, 100.0), burn(200.0, 101.0)], options);
    let other = desk.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs(3)).await;
        other.unplug();
        sleep(Duration::from_millis(300)).await;
        other.plug();
    });
    run.wait(|_| {}).await.unwrap_err();
    arm.reconnected().await.unwrap();
    desk.heard();
    // The outcome of the piece in progress is unknown.
    let error = run.wait(|_| {}).await.unwrap_err();
    assert!(!run.is_interrupted(), "{error}");
    sleep(Duration::from_secs(1)).await;
    assert!(!acts(&desk).contains(&LASER));
}

#[tokio::test(start_paused = true)]
async fn a_pin_that_was_raised_is_lowered_on_a_line_that_is_found_again() {
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    sleep(Duration::from_millis(200)).await;
    for address in [2, 4] {
        let multiplex = IoFunction::DigitalOutput;
        arm.set(&IoMultiplexing { address, multiplex })
            .await
            .unwrap();
        arm.set_any(&build::output(address, true)).await.unwrap();
    }
    assert!(desk.with(|arm| arm.state().laser));
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(true));
    desk.unplug();
    sleep(Duration::from_millis(150)).await;
    desk.heard();
    desk.plug();
    arm.reconnected().await.unwrap();
    let heard: Vec<_> = desk.heard().iter().map(|(id, _)| *id).collect();
    assert_eq!(heard[..2], [LASER, STOP]);
    assert!(heard.contains(&CLEAR), "{heard:?}");
    assert!(!desk.with(|arm| arm.state().laser));
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(false));
}

#[tokio::test(start_paused = true)]
async fn a_burning_run_goes_on_after_the_line_was_lost_with_every_segment_done() {
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    sleep(Duration::from_millis(200)).await;
    begin_to_burn(&arm, 0.5).await;
    sleep(Duration::from_secs(2)).await;
    let path = (1..=40).map(|step| burn(200.0, 0.5 + step as f32));
    let end = build::path_to(200.0, 45.0, 0.0);
    let mut run = arm.start(path.chain([end]));
    let other = desk.clone();
    tokio::spawn(async move {
        for pause in [3, 5] {
            sleep(Duration::from_secs(pause)).await;
            other.unplug();
            sleep(Duration::from_millis(700)).await;
            other.plug();
        }
    });
    let mut breaks = 0;
    while let Err(error) = run.wait(|_| {}).await {
        assert!(run.is_interrupted(), "{error}");
        breaks += 1;
        arm.reconnected().await.unwrap();
    }
    assert_eq!(breaks, 2);
    assert_eq!(run.ran().commands, 41);
    let pose = arm.get::<magician::commands::Pose>().await.unwrap();
    assert_eq!((pose.x, pose.y), (200.0, 45.0));
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(false));
    let clears = desk.frames(CLEAR);
    let stood = clears.iter().all(|(_, moved)| !moved);
    assert!(stood && clears.len() >= 2, "{clears:?}");
}

#[tokio::test(start_paused = true)]
async fn every_end_of_a_run_leaves_the_laser_off() {
    // End: completed.
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    begin_to_burn(&arm, 2.0).await;
    sleep(Duration::from_secs(5)).await;
    let heard = desk.heard();
    assert_eq!(
        heard.iter().filter(|one| **one == (LASER, true)).count(),
        1,
        "{heard:?}"
    );
    // End: stopped.
    begin_to_burn(&arm, 40.0).await;
    sleep(Duration::from_secs(4)).await;
    assert!(desk.with(|arm| arm.state().laser));
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(true));
    arm.stop().await.unwrap();
    assert!(!desk.with(|arm| arm.state().laser));
    // End: handle dropped.
    begin_to_burn(&arm, 40.0).await;
    sleep(Duration::from_secs(4)).await;
    assert!(desk.with(|arm| arm.state().laser));
    arm.close().await;
    assert!(!desk.with(|arm| arm.state().laser));
}

#[tokio::test(start_paused = true)]
async fn homing_puts_a_laser_out_first_and_a_program_does_not_begin_with_one() {
    let desk = Desk::new();
    let arm = desk.connect(allowed()).await;
    arm.set(&on()).await.unwrap();
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(true));
    let error = arm
        .front_end()
        .check_ready(&[], Guards::default())
        .await
        .unwrap_err();
    assert_eq!(error.code(), ErrorCode::LaserOn);
    assert_eq!(error.remedies()[0].act, Act::Do(Action::LaserOff));
    desk.heard();
    arm.home().await.unwrap();
    let written: Vec<_> = desk
        .heard()
        .into_iter()
        .filter(|(_, wrote)| *wrote)
        .collect();
    let ids: Vec<_> = written.iter().map(|(id, _)| *id).collect();
    let (off, home) = (
        ids.iter().position(|id| *id == LASER),
        ids.iter().position(|id| *id == 31),
    );
    assert!(off.is_some() && off < home, "{ids:?}");
    assert!(!desk.with(|arm| arm.state().laser));
}

#[tokio::test(start_paused = true)]
async fn a_pin_that_was_lowered_again_is_left_alone_at_the_end() {
    let (high, low) = (build::output(4, true), build::output(4, false));
    let (fast, off) = (build::pwm(4, 1000.0, 20.0), build::pwm(4, 1000.0, 0.0));
    for (raised, lowered, left) in [
        (vec![high], vec![low], false),
        (vec![fast], vec![off], false),
        (vec![high, fast], vec![low, off], false),
        (vec![high], vec![], true),
        // Another pin, another form of the same command, and a beam are other ways to light it.
        (
            vec![high, build::output(2, true)],
            vec![build::output(4, false)],
            true,
        ),
        (vec![high, fast], vec![low], true),
        (vec![high], vec![build::laser(false)], true),
        (vec![build::laser(true), high], vec![low], true),
    ] {
        let desk = Desk::new();
        let arm = desk.connect(allowed()).await;
        for command in raised.iter().chain(&lowered) {
            arm.set_any(command).await.unwrap();
        }
        desk.heard();
        arm.close().await;
        let heard = desk.heard();
        assert_eq!(!only_reads(&heard), left, "{raised:?} {lowered:?}");
    }
}

/// A job of another program burns segment by segment, while the laser's own setting reads off.
#[tokio::test(start_paused = true)]
async fn a_laser_is_not_said_to_be_off_while_commands_of_another_program_are_in_the_queue() {
    let cell = VirtualArm::new(Controller::default(), SimSpeed::Times(1.0));
    let [arm, other] = [cell.clone(), cell.clone()].map(|cell| Arm::simulated(cell, allowed()));
    let (arm, other) = (arm.await.unwrap(), other.await.unwrap());
    assert_eq!(other.laser().is_on().await.unwrap(), Some(false));
    arm.set(&ClearAlarmsState {}).await.unwrap();
    begin_to_burn(&arm, 40.0).await;
    sleep(Duration::from_secs(4)).await;
    assert!(cell.state().laser, "{:?}", cell.state());
    assert_eq!(arm.laser().is_on().await.unwrap(), Some(true));
    assert_eq!(other.laser().is_on().await.unwrap(), None);
    arm.stop().await.unwrap();
    // A reading of the queue is trusted for a moment.
    sleep(Duration::from_secs(1)).await;
    assert_eq!(other.laser().is_on().await.unwrap(), Some(false));
}

/// Returns commands with an invalid power, for each command that has one.
fn no_power() -> Vec<Set> {
    let shares = [-1.0, -0.001, 100.01, f32::NAN, f32::INFINITY];
    let both = |share| {
        let pulses = IoPwm {
            address: 4,
            frequency: 100.0,
            duty_cycle: share,
        };
        [build::engrave_to(220.0, 0.0, 20.0, share), pulses.into()]
    };
    shares.into_iter().flat_map(both).collect()
}

#[tokio::test(start_paused = true)]
async fn share_of_power_out_of_range_is_sent_by_no_call() {
    for options in [Options::default(), allowed()] {
        let desk = Desk::new();
        let arm = desk.connect(options).await;
        sleep(Duration::from_millis(200)).await;
        desk.heard();
        for command in no_power() {
            let name = command.row().set_name;
            let frame = FrameBuf::set(&command, Ctrl::QUEUED).unwrap();
            let params = frame.frame().params().to_vec();
            let id = command.row().id;
            let refused = [
                arm.set_any(&command).await.err(),
                arm.enqueue_set(&command).await.err(),
                arm.enqueue_form(id, &params).await.err(),
                arm.raw(id, Ctrl::SET, &params).await.err(),
                arm.raw(id, Ctrl::QUEUED, &params).await.err(),
                arm.run(&[command]).await.err(),
                arm.start([command]).wait(|_| {}).await.err(),
            ];
            for (nth, error) in refused.into_iter().enumerate() {
                let error = error.unwrap_or_else(|| panic!("{command:?} was sent by call {nth}"));
                assert_eq!(error.kind(), ErrorKind::InvalidInput, "{nth}: {error}");
                let said = error.to_string();
                let why = ["% is out of range: 0 to 100 %", "not a finite number"];
                let told = why.iter().any(|why| said.contains(why)) && said.contains(name);
                assert!(told, "{nth}: {said}");
            }
            assert!(only_reads(&desk.heard()), "{command:?}");
        }
    }
}
