//! Frames that each command costs on the line: checks the table of docs/reference/FRAMES.md.

use std::time::Duration;

use magician::commands::{Pose, PtpCommonParams};
use magician::preflight::Preflight;
use magician::protocol::{IoFunction, Stepper};
use magician::sim::Controller;
use magician::{Arm, Options, Set, SimSpeed, ToolBias, VirtualArm, build};
use tokio::time::sleep;

use crate::bench::fast;

const PAGE: &str = include_str!("../../../../docs/reference/FRAMES.md");

/// Returns every command that `Arm::run` accepts, with its name.
fn all_commands() -> Vec<(&'static str, Set)> {
    let pose = Pose {
        x: 220.0,
        y: 0.0,
        z: 20.0,
        r: 0.0,
        joint_angle: [0.0; 4],
    };
    let second = Duration::from_secs(1);
    vec![
        ("move_to", build::move_to(220.0, 10.0, 20.0, 0.0)),
        ("line_to", build::line_to(220.0, 10.0, 20.0, 0.0)),
        ("jump_to", build::jump_to(220.0, 10.0, 20.0, 0.0)),
        ("jump_line_to", build::jump_line_to(220.0, 10.0, 20.0, 0.0)),
        ("move_joints", build::move_joints(5.0, 30.0, 30.0, 0.0)),
        ("line_joints", build::line_joints(5.0, 30.0, 30.0, 0.0)),
        ("jump_joints", build::jump_joints(5.0, 30.0, 30.0, 0.0)),
        ("move_by", build::move_by(0.0, 10.0, 0.0, 0.0)),
        ("line_by", build::line_by(0.0, 10.0, 0.0, 0.0)),
        ("move_joints_by", build::move_joints_by(3.0, 0.0, 0.0, 0.0)),
        (
            "arc_to",
            build::arc_to([230.0, 10.0, 20.0, 0.0], [220.0, 20.0, 20.0, 0.0]),
        ),
        (
            "circle",
            build::circle([230.0, 10.0, 20.0, 0.0], [220.0, 20.0, 20.0, 0.0], 1),
        ),
        ("path_to", build::path_to(220.0, 10.0, 20.0)),
        ("path_by", build::path_by(0.0, 10.0, 0.0)),
        ("home_at", build::home_at(220.0, 0.0, 20.0, 0.0)),
        ("wait", build::wait(second)),
        ("multiplex", build::multiplex(5, IoFunction::DigitalOutput)),
        ("output", build::output(5, true)),
        ("pwm", build::pwm(6, 1000.0, 10.0)),
        ("servo", build::servo(6, 1.5)),
        ("motor_by", build::motor_by(Stepper::Stepper1, 1000, 100)),
        ("suction", build::suction(true)),
        ("grip", build::grip()),
        ("release", build::release()),
        ("pump_off", build::pump_off()),
        ("laser off", build::laser(false)),
        ("tool", build::tool(ToolBias::PEN)),
        ("speed", build::speed(60.0, 60.0)),
        ("joint_speed", build::joint_speed([100.0; 4], [100.0; 4])),
        ("line_speed", build::line_speed(100.0, 100.0)),
        ("path_speed", build::path_speed(50.0, 50.0)),
        ("arc_speed", build::arc_speed(50.0, 50.0)),
        ("jump_height", build::jump_height(20.0, 100.0)),
        ("jump_heights", build::jump_heights(20.0, 10.0, 100.0)),
        ("jog_speed", build::jog_speed(50.0, 50.0)),
        ("rail_speed", build::rail_speed(50.0, 50.0)),
        ("rail_to", build::rail_to(50.0, &pose)),
        (
            "move_with_rail",
            build::move_with_rail(220.0, 10.0, 20.0, 0.0, 50.0),
        ),
    ]
}

/// Returns the number of frames that `work` takes.
async fn count(arm: &Arm, work: impl Future<Output = ()>) -> u64 {
    let before = arm.stats().await.unwrap().0.sent;
    work.await;
    arm.stats().await.unwrap().0.sent - before
}

/// Returns the number of frames that a command takes: once its settings are known, and as the first
/// command over a connection.
async fn frames(arm: Arm, command: &Set) -> [u64; 2] {
    let perform = async |commands: &[Set]| {
        arm.run(commands).await.unwrap();
    };
    let before = build::move_to(220.0, 0.0, 20.0, 0.0);
    // This run warns that the arm is not homed. After 2 s its readings have expired.
    perform(&[]).await;
    sleep(Duration::from_secs(2)).await;
    let first = count(&arm, perform(&[*command])).await;
    // Settings that only this command depends on become known, too.
    perform(&[before]).await;
    perform(&[*command]).await;
    perform(&[before]).await;
    [count(&arm, perform(&[*command])).await, first]
}

/// Returns an arm at power-up.
fn powered_up() -> Controller {
    Controller::default().with_tool(ToolBias::SUCTION)
}

/// Returns an arm that other programs may use as well.
async fn shared() -> Arm {
    let arm = VirtualArm::new(powered_up(), SimSpeed::Max);
    Arm::simulated(arm, Options::default()).await.unwrap()
}

#[tokio::test(start_paused = true)]
async fn table_of_the_docs_matches_the_counted_frames() {
    let mut table = String::new();
    for (name, command) in all_commands() {
        let [known, first] = frames(fast().await, &command).await;
        let [with_others, _] = frames(shared().await, &command).await;
        table += &format!("| `{name}` | {known} | {with_others} | {first} |\n");
    }
    assert!(
        PAGE.contains(&table),
        "the table of docs/reference/FRAMES.md is to be:\n{table}"
    );
}

#[tokio::test(start_paused = true)]
async fn checked_move_takes_five_frames() {
    let arm = fast().await;
    let there = build::move_to(220.0, 0.0, 20.0, 0.0);
    let back = build::line_to(220.0, 30.0, 20.0, 0.0);
    arm.run(&[there]).await.unwrap();
    let moves = async || {
        arm.run(&[back]).await.unwrap();
    };
    assert_eq!(count(&arm, moves()).await, 5);
    // A setting made over this connection is known.
    let ratio = PtpCommonParams {
        velocity_ratio: 30.0,
        acceleration_ratio: 30.0,
    };
    arm.set(&ratio).await.unwrap();
    assert_eq!(
        count(&arm, moves()).await,
        6,
        "it stands, but who knows where"
    );
    // A hand may have moved it since, and an alarm may hold it.
    sleep(Duration::from_secs(2)).await;
    assert_eq!(count(&arm, moves()).await, 7, "pose and alarms");
}

#[tokio::test(start_paused = true)]
async fn preflight_follows_moves_of_another_program() {
    let virtual_arm = VirtualArm::new(powered_up(), SimSpeed::Max);
    let arm = Arm::simulated(virtual_arm.clone(), Options::default())
        .await
        .unwrap();
    let other = Arm::simulated(virtual_arm, Options::default())
        .await
        .unwrap();
    let there = build::line_to(220.0, 0.0, 20.0, 0.0);
    arm.run(&[there]).await.unwrap();
    // Another program moves the arm: the index shows it, and everything is read again.
    let away = build::line_to(250.0, 60.0, 40.0, 0.0);
    let speeds = build::speed(20.0, 20.0);
    other.run(&[speeds, away]).await.unwrap();
    let seen = arm.preflight_for(&[there]).await.unwrap();
    let at = seen.arm().unwrap().pose;
    assert!((at.x - 250.0).abs() < 1e-3 && (at.y - 60.0).abs() < 1e-3);
    let read = other.preflight().await.unwrap();
    let time = |check: &Preflight| check.estimate(&[there]).unwrap();
    assert_eq!(time(&seen), time(&read));
}
