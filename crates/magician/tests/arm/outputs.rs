//! Tools and laser as known to a handle without a read.

use std::time::Duration;

use magician::sim::Controller;
use magician::{Arm, GripperState, Options, SimSpeed, VirtualArm, build};
use tokio::time::sleep;

fn virtual_arm() -> VirtualArm {
    VirtualArm::new(Controller::default(), SimSpeed::Times(1.0))
}

async fn connect(virtual_arm: &VirtualArm) -> Arm {
    Arm::simulated(virtual_arm.clone(), Options::default())
        .await
        .unwrap()
}

async fn frames(arm: &Arm) -> u64 {
    arm.stats().await.unwrap().0.sent
}

#[tokio::test(start_paused = true)]
async fn outputs_are_unknown_until_they_were_read_and_cost_no_frame() {
    let virtual_arm = virtual_arm();
    let first = connect(&virtual_arm).await;
    first.set_any(&build::suction(true)).await.unwrap();
    first
        .run(&[build::move_to(220.0, 0.0, 20.0, 0.0)])
        .await
        .unwrap();
    drop(first);
    let arm = connect(&virtual_arm).await;
    let outputs = arm.outputs();
    assert_eq!((outputs.suction, outputs.laser), (None, None));
    // A queue that was used before this connection does not count as another program's.
    let outputs = arm.read_outputs().await.unwrap();
    assert_eq!(outputs.suction, Some(true));
    assert_eq!(outputs.gripper, Some(GripperState::Off));
    assert_eq!(outputs.laser, Some(false));
    assert!(outputs.tool.is_some() && outputs.speed.is_some());
    let before = frames(&arm).await;
    assert_eq!(arm.outputs(), outputs);
    assert_eq!(frames(&arm).await, before);
}

#[tokio::test(start_paused = true)]
async fn outputs_of_a_run_are_told_while_it_runs() {
    let virtual_arm = virtual_arm();
    let arm = connect(&virtual_arm).await;
    arm.clear_alarms().await.unwrap();
    arm.read_outputs().await.unwrap();
    let mut watch = arm.state(20.0).unwrap();
    let mut program = vec![build::move_to(220.0, 0.0, 20.0, 0.0)];
    for round in 0..4_u8 {
        let y = f32::from(round) * 10.0;
        program.extend([
            build::suction(round % 2 == 0),
            build::engrave_to(240.0, y, 20.0, 50.0),
            build::engrave_to(220.0, y, 20.0, 50.0),
            build::engrave_to(220.0, y + 10.0, 20.0, 0.0),
            build::wait(Duration::from_millis(400)),
        ]);
    }
    program.push(build::laser(false));
    let running = tokio::spawn({
        let arm = arm.clone();
        async move { arm.run(&program).await.map(drop) }
    });
    let (mut burnt, mut sucked) = (0, 0);
    while !running.is_finished() {
        watch.changed().await.unwrap();
        let (state, told) = (virtual_arm.state(), arm.outputs());
        assert!(!state.laser || told.laser == Some(true), "{told:?}");
        burnt += u32::from(state.laser);
        sucked += u32::from(told.suction == Some(true));
    }
    running.await.unwrap().unwrap();
    assert!(burnt > 10 && sucked > 10, "{burnt} {sucked}");
    let (state, told) = (virtual_arm.state(), arm.outputs());
    assert_eq!(told.laser, Some(state.laser));
    assert_eq!(told.suction, Some(state.suction.commanded));
    assert_eq!(told.laser, Some(false));
}

#[tokio::test(start_paused = true)]
async fn outputs_are_unknown_after_commands_of_another_program() {
    let virtual_arm = virtual_arm();
    let arm = connect(&virtual_arm).await;
    arm.clear_alarms().await.unwrap();
    arm.run(&[build::suction(false)]).await.unwrap();
    arm.read_outputs().await.unwrap();
    let other = connect(&virtual_arm).await;
    other.run(&[build::suction(true)]).await.unwrap();
    let lapses = arm.snapshot().lapses;
    // The steps of one call share a reading of the queue for a while.
    sleep(Duration::from_millis(200)).await;
    // Either error or success will do here.
    let _ = arm.run(&[build::wait(Duration::from_millis(10))]).await;
    assert!(arm.snapshot().lapses > lapses);
    assert_eq!(arm.outputs().suction, None);
    assert_eq!(arm.read_outputs().await.unwrap().suction, Some(true));
}

#[tokio::test(start_paused = true)]
async fn laser_is_told_dark_as_soon_as_a_stop_was_answered() {
    let virtual_arm = virtual_arm();
    let arm = connect(&virtual_arm).await;
    arm.clear_alarms().await.unwrap();
    arm.read_outputs().await.unwrap();
    arm.enqueue_set(&build::engrave_to(240.0, 20.0, 20.0, 50.0))
        .await
        .unwrap();
    arm.queue().start().await.unwrap();
    sleep(Duration::from_millis(300)).await;
    assert!(virtual_arm.state().laser);
    assert_eq!(arm.outputs().laser, Some(true));
    arm.stop().await.unwrap();
    assert!(!virtual_arm.state().laser);
    assert_eq!(arm.outputs().laser, Some(false));
}
