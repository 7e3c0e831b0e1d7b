//! States for subscribers, and lists.

use std::time::Duration;

use magician_station::StateFrame;
use serde_json::{Value, json};

use crate::bench::TestHub;

#[tokio::test(start_paused = true)]
async fn subscriptions_of_several_stations_have_numbers_of_their_own() {
    let bench = TestHub::new(3, 1).await;
    let mut anna = bench.join("Anna").await;
    let mut ids = Vec::new();
    for (arm, frame) in [("arm0", "json"), ("arm1", "binary"), ("arm2", "json")] {
        let made = anna
            .ok(
                "arm.subscribe",
                json!({"arm": arm, "rate": 10, "frame": frame}),
            )
            .await;
        ids.push(made["subscription"].as_u64().unwrap());
    }
    assert_eq!(ids, [1, 2, 3]);
    anna.run_for(Duration::from_secs(1)).await;
    for (id, arm) in [(1, "arm0"), (3, "arm2")] {
        let of = anna
            .noticed("arm.state")
            .into_iter()
            .filter(|params| params["subscription"] == id);
        let of: Vec<_> = of.collect();
        assert!((9..=12).contains(&of.len()), "{arm}: {}", of.len());
        assert_eq!(of[0]["state"]["arm"], arm);
    }
    assert!((9..=12).contains(&anna.frames.len()));
    for (at, frame) in anna.frames.iter().enumerate() {
        let frame = StateFrame::read(frame).unwrap();
        assert_eq!((frame.subscription, frame.sequence), (2, at as u32));
    }
    anna.ok("arm.unsubscribe", json!({"subscription": 1})).await;
    anna.notices.clear();
    anna.run_for(Duration::from_secs(1)).await;
    assert!(
        anna.noticed("arm.state")
            .iter()
            .all(|params| params["subscription"] == 3)
    );
    let error = anna
        .fails("arm.unsubscribe", json!({"subscription": 1}))
        .await;
    assert_eq!(error["data"]["param"], "subscription");
}

#[tokio::test(start_paused = true)]
async fn slow_client_gets_all_changed_fields_with_their_newest_values() {
    let bench = TestHub::new(1, 1).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm0").await;
    anna.ok("arm.subscribe", json!({"arm": "arm0", "rate": 50}))
        .await;
    anna.run_for(Duration::from_millis(100)).await;
    anna.notices.clear();
    // Anna does not read while the arm moves and other fields than the pose change.
    anna.send("arm.move", json!({"arm": "arm0", "to": [220, 60, 20, 0]}));
    tokio::time::sleep(Duration::from_secs(1)).await;
    anna.send("arm.tool", json!({"arm": "arm0", "suction": true}));
    tokio::time::sleep(Duration::from_secs(1)).await;
    anna.run_for(Duration::from_millis(1)).await;
    let states = anna.noticed("arm.state");
    assert!(states.len() <= 2, "{} states", states.len());
    let merged = states
        .iter()
        .fold(serde_json::Map::new(), |mut all, params| {
            all.extend(params["state"].as_object().unwrap().clone());
            all
        });
    assert_eq!(merged["tool"]["suction"], true);
    assert!(
        (merged["y"].as_f64().unwrap() - 60.0).abs() < 0.1,
        "{merged:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn published_state_is_answered_without_a_request() {
    let bench = TestHub::new(3, 1).await;
    let mut anna = bench.join("Anna").await;
    bench.site.report(2, "arm1").await;
    tokio::time::sleep(Duration::from_millis(1)).await;
    let state = anna.ok("arm.state", json!({"arm": "arm1"})).await;
    assert_eq!(state["arm"], "arm1");
    assert_eq!(bench.site.opened(), 0);
    // The last report is too old, so the hub asks the station.
    tokio::time::sleep(Duration::from_secs(2)).await;
    anna.ok("arm.state", json!({"arm": "arm1"})).await;
    assert_eq!(bench.site.opened(), 1);
}

#[tokio::test(start_paused = true)]
async fn arms_come_and_go_in_the_list() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    assert_eq!(anna.row("arm1").await["link"], "up");
    bench
        .site
        .start(magician_site::StationId(7), &["late".to_owned()])
        .await;
    tokio::time::sleep(Duration::from_millis(1)).await;
    assert_eq!(anna.row("late").await["link"], "up");
    bench.site.cut(7);
    tokio::time::sleep(Duration::from_millis(1)).await;
    let expected = json!({"name": "late", "port": "sim", "virtual": true, "link": "lost", "holder": null, "waiting": [], "job": null});
    assert_eq!(anna.row("late").await, expected);
    let error = anna.fails("arm.state", json!({"arm": "late"})).await;
    assert_eq!(error["data"]["kind"], "port");
    anna.run_for(Duration::from_secs(700)).await;
    let list = anna.ok("arm.list", json!({})).await;
    assert_eq!(list["arms"].as_array().unwrap().len(), 2);
}

#[tokio::test(start_paused = true)]
async fn ambiguous_name_accepts_only_stops() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    bench
        .site
        .start(magician_site::StationId(7), &["arm0".to_owned()])
        .await;
    tokio::time::sleep(Duration::from_millis(1)).await;
    assert_eq!(anna.row("arm0").await["link"], "lost");
    let error = anna.fails("lease.take", json!({"arm": "arm0"})).await;
    assert!(
        error["message"].as_str().unwrap().contains("two stations"),
        "{error}"
    );
    let stopped = anna.ok("arm.stop", json!({"arm": "arm0"})).await;
    assert_eq!(stopped["arms"].as_array().map(Vec::len), Some(2));
    assert_eq!(stopped["arms"][0]["arm"], Value::from("arm0"));
}
