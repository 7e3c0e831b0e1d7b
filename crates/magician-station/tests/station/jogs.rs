//! Keep-alive of jogs.

use std::time::Duration;

use serde_json::json;

use magician_station::Role;

use crate::bench::{LocalStation, Tester};

async fn jogging(bench: &LocalStation) -> (Tester, serde_json::Value) {
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let jog = anna.ok("jog.start", json!({"axis": "y+"})).await["jog"].clone();
    (anna, jog)
}

/// Keeps a jog alive for this time.
async fn keep(anna: &mut Tester, jog: &serde_json::Value, time: Duration) {
    for _ in 0..time.as_millis() / 50 {
        anna.notify("jog.keep", json!({"jog": jog}));
        anna.listen(Duration::from_millis(50)).await;
    }
}

#[tokio::test(start_paused = true)]
async fn jog_lasts_while_kept_and_stops_on_request() {
    let bench = LocalStation::new(1).await;
    let (mut anna, jog) = jogging(&bench).await;
    keep(&mut anna, &jog, Duration::from_secs(2)).await;
    assert!(bench.arms[0].state().moving);
    let stood = anna.ok("jog.stop", json!({"jog": jog})).await;
    assert_eq!(stood["stood"], json!(true));
    assert!(!bench.arms[0].state().moving);
    let pose = bench.arms[0].state().pose;
    assert!((stood["pose"]["y"].as_f64().unwrap() - pose.y).abs() < 0.01);
    assert_eq!(anna.noticed("jog.ended")[0]["why"], json!("released"));
    // A second stop gives the same answer: the pose at which the arm stands.
    assert_eq!(anna.ok("jog.stop", json!({"jog": jog})).await, stood);
}

#[tokio::test(start_paused = true)]
async fn jog_without_keep_alive_ends() {
    let bench = LocalStation::new(1).await;
    let (mut anna, jog) = jogging(&bench).await;
    keep(&mut anna, &jog, Duration::from_millis(500)).await;
    assert!(bench.arms[0].state().moving);
    anna.listen(Duration::from_millis(300)).await;
    assert_eq!(anna.noticed("jog.ended")[0]["why"], json!("not-kept"));
    // The arm brakes.
    anna.listen(Duration::from_millis(500)).await;
    assert!(!bench.arms[0].state().moving);
    // Too late: the jog is over.
    anna.notify("jog.keep", json!({"jog": jog}));
    anna.listen(Duration::from_millis(300)).await;
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn closed_socket_ends_its_jog_immediately() {
    let bench = LocalStation::new(1).await;
    let mut ben = bench.join("Ben").await;
    let (mut anna, jog) = jogging(&bench).await;
    keep(&mut anna, &jog, Duration::from_millis(300)).await;
    drop(anna);
    ben.listen(Duration::from_millis(20)).await;
    assert_eq!(ben.noticed("jog.ended")[0]["why"], json!("released"));
    ben.listen(Duration::from_millis(400)).await;
    assert!(!bench.arms[0].state().moving);
    // The lease is kept so that the session can come back.
    assert_eq!(ben.code("lease.acquire", json!({})).await, -32002);
}

#[tokio::test(start_paused = true)]
async fn any_session_stops_a_jog_but_only_its_own_keeps_it() {
    let bench = LocalStation::new(1).await;
    let mut ben = bench.join("Ben").await;
    let (mut anna, jog) = jogging(&bench).await;
    for _ in 0..10 {
        ben.notify("jog.keep", json!({"jog": jog}));
        ben.listen(Duration::from_millis(50)).await;
    }
    assert_eq!(ben.noticed("jog.ended")[0]["why"], json!("not-kept"));
    let jog = anna.ok("jog.start", json!({"axis": "x-"})).await["jog"].clone();
    ben.ok("arm.stop", json!({})).await;
    anna.listen(Duration::from_millis(10)).await;
    let last = anna.noticed("jog.ended").last().copied().cloned().unwrap();
    assert_eq!((&last["why"], &last["jog"]), (&json!("stopped"), &jog));
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn second_jog_replaces_the_first_and_other_motion_is_busy() {
    let bench = LocalStation::new(1).await;
    let (mut anna, first) = jogging(&bench).await;
    let busy = anna
        .call("arm.move", json!({"to": [220, 0, 50, 0]}))
        .await
        .unwrap_err();
    assert_eq!(
        (&busy["code"], &busy["data"]["jog"]),
        (&json!(-32003), &first)
    );
    let second = anna.ok("jog.start", json!({"axis": "z+"})).await["jog"].clone();
    assert_eq!(anna.noticed("jog.ended")[0]["why"], json!("replaced"));
    keep(&mut anna, &second, Duration::from_millis(500)).await;
    let before = bench.arms[0].state().pose;
    keep(&mut anna, &second, Duration::from_millis(500)).await;
    let after = bench.arms[0].state().pose;
    assert!(
        after.z > before.z + 1.0 && (after.y - before.y).abs() < 0.5,
        "{before:?} {after:?}"
    );
    anna.ok("jog.stop", json!({"jog": second})).await;
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
}

#[tokio::test(start_paused = true)]
async fn step_in_tool_frame_is_rotated_by_r_and_checked() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 0, 50, 90]})).await;
    let state = anna
        .ok("jog.step", json!({"axis": "x", "by": 10, "frame": "tool"}))
        .await;
    assert_eq!((&state["x"], &state["y"]), (&json!(220.0), &json!(10.0)));
    let state = anna.ok("jog.step", json!({"axis": "x", "by": -10})).await;
    assert_eq!((&state["x"], &state["y"]), (&json!(210.0), &json!(10.0)));
    let refused = anna
        .call("jog.step", json!({"axis": "x", "by": 500}))
        .await
        .unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unreachable"));
    assert_eq!(
        anna.code("jog.step", json!({"axis": "j1", "by": 5, "frame": "tool"}))
            .await,
        -32602
    );
}

/// Asserts that a request was refused in favour of `jog.start`.
fn is_refused_for_jog_start(error: &serde_json::Value) {
    assert_eq!(error["code"], json!(-32602), "{error}");
    assert_eq!(error["data"]["method"], json!("jog.start"), "{error}");
    assert!(error["message"].as_str().unwrap().contains("jog.start"));
}

#[tokio::test(start_paused = true)]
async fn raw_jog_is_refused_for_every_role_and_by_post() {
    let bench = LocalStation::new(1).await;
    let jog = json!({"command": "JOGCmd", "fields": {"is_joint": 1, "cmd": 1}});
    for method in ["arm.set", "arm.enqueue"] {
        for role in [Role::Student, Role::Teacher] {
            let mut anna = bench.join_as("Anna", role).await;
            let lease = anna.lease().await;
            let error = anna.call(method, jog.clone()).await.unwrap_err();
            is_refused_for_jog_start(&error);
            // Ending a raw jog stays allowed.
            let stop = json!({"command": "JOGCmd", "fields": {"is_joint": 0, "cmd": 0}});
            anna.ok("arm.set", stop).await;
            anna.ok("lease.release", json!({"lease": lease})).await;
        }
        is_refused_for_jog_start(&bench.once(method, jog.clone()).await["error"]);
    }
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(!bench.arms[0].state().moving);
}

#[tokio::test(start_paused = true)]
async fn second_start_of_a_session_replaces_the_first_with_the_default_keep_ms() {
    let bench = LocalStation::new(1).await;
    let (mut anna, jog) = jogging(&bench).await;
    keep(&mut anna, &jog, Duration::from_secs(1)).await;
    // Braking for 0.5 s takes longer than the keep-alive period of 250 ms.
    let second = anna.ok("jog.start", json!({"axis": "z+"})).await["jog"].clone();
    assert_eq!(anna.noticed("jog.ended")[0]["why"], json!("replaced"));
    let z = bench.arms[0].state().pose.z;
    keep(&mut anna, &second, Duration::from_secs(1)).await;
    assert!(bench.arms[0].state().pose.z > z + 5.0);
    anna.ok("jog.stop", json!({"jog": second})).await;
}

#[tokio::test(start_paused = true)]
async fn jog_stopped_during_braking_does_not_start() {
    let bench = LocalStation::new(1).await;
    let (mut anna, jog) = jogging(&bench).await;
    keep(&mut anna, &jog, Duration::from_secs(1)).await;
    let second = anna.send("jog.start", json!({"axis": "z+"}));
    anna.listen(Duration::from_millis(100)).await;
    let z = bench.arms[0].state().pose.z;
    // The id is not known yet: without one the jog of the arm is meant.
    let stop = anna.send("jog.stop", json!({}));
    assert_eq!(
        anna.answer(second).await.unwrap_err()["code"],
        json!(-32007)
    );
    assert_eq!(anna.answer(stop).await.unwrap()["stood"], json!(true));
    anna.listen(Duration::from_secs(2)).await;
    let state = bench.arms[0].state();
    assert!(!state.moving);
    assert_eq!(state.pose.z, z);
}

#[tokio::test(start_paused = true)]
async fn jog_at_the_axis_limit_ends_with_reason_limit() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("arm.subscribe", json!({"rate": 20})).await;
    let params = json!({"axis": "j1+", "percent": 100});
    let jog = anna.ok("jog.start", params).await["jog"].clone();
    for _ in 0..600 {
        keep(&mut anna, &jog, Duration::from_millis(50)).await;
        if !anna.noticed("jog.ended").is_empty() {
            break;
        }
    }
    let ended = anna.noticed("jog.ended");
    assert_eq!(ended[0]["why"], json!("limit"));
    anna.listen(Duration::from_millis(300)).await;
    let state = anna.ok("arm.state", json!({})).await;
    assert_eq!(
        (&state["moving"], &state["jog"]),
        (&json!(false), &json!(null))
    );
    // The arm is not busy, and the other direction is free.
    let back = anna.ok("jog.start", json!({"axis": "j1-"})).await["jog"].clone();
    keep(&mut anna, &back, Duration::from_secs(1)).await;
    assert!(bench.arms[0].state().moving);
}
