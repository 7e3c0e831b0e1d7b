//! Queued calls: indices, waiting, cancelling.

use std::time::Duration;

use magician_station::Role;
use magician_station::link::LinkOptions;
use serde_json::json;
use tokio::time::{Instant, sleep};

use super::program::Program;
use crate::bench::LocalStation;

const FAR: [(f64, f64); 2] = [(200.0, 60.0), (240.0, -60.0)];

fn to(x: f64, y: f64) -> serde_json::Value {
    json!({"ptpMode": 2, "x": x, "y": y, "z": 30, "r": 0, "timeout": 60_000})
}

#[tokio::test(start_paused = true)]
async fn waiting_move_is_answered_on_arrival() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let result = program.ok("SetPTPCmd", to(220.0, 40.0)).await;
    assert_eq!(result, json!(true));
    let pose = bench.arms[0].state().pose;
    assert_eq!((pose.x.round(), pose.y.round()), (220.0, 40.0));
    let told = program.ok("GetPose", json!({})).await;
    assert_eq!(told["x"], json!(220.0));
    assert_eq!(told["jointAngle"].as_array().map(Vec::len), Some(4));
}

#[tokio::test(start_paused = true)]
async fn non_waiting_call_returns_its_index() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let mut at = to(220.0, 40.0);
    at["isWaitForFinish"] = json!(false);
    let first = program.ok("SetPTPCmd", at.clone()).await["queuedCmdIndex"]
        .as_u64()
        .unwrap();
    let second = program.ok("SetPTPCmd", at).await["queuedCmdIndex"]
        .as_u64()
        .unwrap();
    assert_eq!(second, first + 1);
    let setting = json!({"velocityRatio": 50, "accelerationRatio": 50, "isQueued": true});
    let third = program.ok("SetPTPCommonParams", setting).await["queuedCmdIndex"]
        .as_u64()
        .unwrap();
    assert_eq!(third, second + 1);
}

#[tokio::test(start_paused = true)]
async fn calls_in_flight_keep_their_order() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let mut ids = Vec::new();
    for step in 0..100 {
        // More than fit into the queue: the rest is held back in order.
        let x = 200.0 + f64::from(step) * 0.5;
        let move_to = json!({"cpMode": 1, "x": x, "y": 0, "z": 30, "power": 100, "timeout": 100_000, "isWaitForFinish": false});
        ids.push(program.send("SetCPCmd", move_to).await);
    }
    let mut before = 0;
    for id in ids {
        let index = program.answer(id).await.unwrap()["queuedCmdIndex"]
            .as_u64()
            .unwrap();
        assert!(index > before, "{index} after {before}");
        before = index;
    }
}

#[tokio::test(start_paused = true)]
async fn foreign_stop_ends_a_wait_within_50_ms() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let mut viewer = bench.join_as("viewer", Role::Viewer).await;
    let id = program.send("SetPTPCmd", to(200.0, 150.0)).await;
    sleep(Duration::from_millis(300)).await;
    assert!(bench.arms[0].state().moving);
    let stopped = Instant::now();
    viewer.send("arm.stop", json!({}));
    let (code, _) = program.answer(id).await.unwrap_err();
    assert_eq!(code, 161);
    assert!(
        stopped.elapsed() <= Duration::from_millis(50),
        "{:?}",
        stopped.elapsed()
    );
}

#[tokio::test(start_paused = true)]
async fn own_stop_and_clear_end_waits_and_held_calls() {
    for (api, params) in [
        ("QueuedCmdStop", json!({})),
        ("QueuedCmdStop", json!({"forceStop": true})),
        ("QueuedCmdForceStop", json!({})),
        ("QueuedCmdClear", json!({})),
        ("DisconnectDobot", json!({})),
    ] {
        let bench = LocalStation::new(1).await;
        let mut program = Program::connected(&bench).await;
        let mut ids = Vec::new();
        for step in 0..60 {
            let (x, y) = FAR[step % 2];
            ids.push(program.send("SetPTPCmd", to(x, y)).await);
        }
        sleep(Duration::from_millis(400)).await;
        let begun = Instant::now();
        program.ok(api, params).await;
        for id in ids {
            let (code, why) = program.answer(id).await.unwrap_err();
            assert_eq!(code, 161, "{api}: {why}");
        }
        assert!(
            begun.elapsed() <= Duration::from_millis(50),
            "{api}: {:?}",
            begun.elapsed()
        );
    }
}

#[tokio::test(start_paused = true)]
async fn call_timeout_starts_when_it_is_next() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let first = program
        .send("SetWAITCmd", json!({"delay": 10_000, "timeout": 60_000}))
        .await;
    let second = program
        .send("SetWAITCmd", json!({"delay": 1_000, "timeout": 2_000}))
        .await;
    let third = program
        .send("SetWAITCmd", json!({"delay": 5_000, "timeout": 1_000}))
        .await;
    assert_eq!(program.answer(first).await, Ok(json!(true)));
    assert_eq!(program.answer(second).await, Ok(json!(true)));
    assert_eq!(program.answer(third).await.unwrap_err().0, 160);
}

#[tokio::test(start_paused = true)]
async fn blocking_alarm_ends_waits_and_is_reported() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let (code, why) = program.call("SetPTPCmd", to(600.0, 0.0)).await.unwrap_err();
    assert_eq!(code, 161, "{why}");
    assert!(why.contains("alarm"), "{why}");
}

#[tokio::test(start_paused = true)]
async fn permanently_full_queue_is_given_up() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let wait = json!({"delay": 60_000, "isWaitForFinish": false, "timeout": 1_000});
    let mut ids = Vec::new();
    for _ in 0..40 {
        ids.push(program.send("SetWAITCmd", wait.clone()).await);
    }
    let mut full = 0;
    for id in ids {
        if let Err((code, _)) = program.answer(id).await {
            assert_eq!(code, 151);
            full += 1;
        }
    }
    assert!(full > 0);
}

#[tokio::test(start_paused = true)]
async fn immediate_call_bypasses_a_full_queue() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    for _ in 0..40 {
        let wait = json!({"delay": 60_000, "isWaitForFinish": false, "timeout": 30_000});
        program.send("SetWAITCmd", wait).await;
    }
    let begun = Instant::now();
    let cup = json!({"enable": true, "on": true});
    assert_eq!(
        program.ok("SetEndEffectorSuctionCup", cup).await,
        json!(true)
    );
    assert!(
        begun.elapsed() < Duration::from_secs(1),
        "{:?}",
        begun.elapsed()
    );
}

#[tokio::test(start_paused = true)]
async fn jog_of_a_hanging_program_ends() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::with(&bench, LinkOptions::default());
    program.ok("ConnectDobot", json!({})).await;
    program
        .ok("SetJOGCmd", json!({"isJoint": true, "cmd": 1}))
        .await;
    sleep(Duration::from_secs(4)).await;
    assert!(bench.arms[0].state().moving);
    // Silent for more than five seconds.
    sleep(Duration::from_millis(1_500)).await;
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn closed_socket_stops_its_jog_but_not_the_queue() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    program
        .ok("SetJOGCmd", json!({"isJoint": true, "cmd": 1}))
        .await;
    sleep(Duration::from_millis(500)).await;
    drop(program);
    sleep(Duration::from_millis(500)).await;
    assert!(!bench.arms[0].state().moving);
    let mut program = Program::connected(&bench).await;
    let mut at = to(220.0, 40.0);
    at["isWaitForFinish"] = json!(false);
    program.ok("SetPTPCmd", at).await;
    drop(program);
    sleep(Duration::from_secs(10)).await;
    assert_eq!(bench.arms[0].state().pose.y.round(), 40.0);
}

#[tokio::test(start_paused = true)]
async fn jog_of_another_axis_starts_at_rest() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let jog = |cmd: u8| json!({"isJoint": false, "cmd": cmd});
    program.ok("SetJOGCmd", jog(1)).await;
    sleep(Duration::from_secs(1)).await;
    let y = bench.arms[0].state().pose.y;
    program.ok("SetJOGCmd", jog(4)).await;
    // A real arm would carry the speed along x over to y and move the wrong way.
    let x = bench.arms[0].state().pose.x;
    sleep(Duration::from_secs(3)).await;
    let state = bench.arms[0].state();
    assert!(state.moving, "the link keeps it up while the program lives");
    assert_eq!(state.pose.x, x, "x stood when y began");
    assert!(state.pose.y < y - 10.0);
    program.ok("SetJOGCmd", jog(0)).await;
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn jog_released_during_braking_does_not_start() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let jog = |cmd: u8| json!({"isJoint": false, "cmd": cmd});
    program.ok("SetJOGCmd", jog(1)).await;
    sleep(Duration::from_secs(1)).await;
    let begun = program.send("SetJOGCmd", jog(3)).await;
    sleep(Duration::from_millis(100)).await;
    let y = bench.arms[0].state().pose.y;
    program.ok("SetJOGCmd", jog(0)).await;
    program.answer(begun).await.unwrap_err();
    sleep(Duration::from_secs(2)).await;
    assert_eq!(bench.arms[0].state().pose.y, y);
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn queued_jog_of_a_program_is_refused() {
    let bench = LocalStation::new(1).await;
    let mut program = Program::connected(&bench).await;
    let jog = json!({"isJoint": true, "cmd": 1, "isQueued": true});
    let id = program.send("SetJOGCmd", jog).await;
    let (_, why) = program.answer(id).await.unwrap_err();
    assert!(why.contains("limit"), "{why}");
    sleep(Duration::from_secs(1)).await;
    assert!(!bench.arms[0].state().moving);
}
