//! Subscriptions.

use std::time::Duration;

use magician::sim::ExternalEvent;
use serde_json::{Value, json};

use crate::bench::LocalStation;

fn states(notices: &[(String, Value)], subscription: &Value) -> Vec<Value> {
    let of = notices
        .iter()
        .filter(|(name, params)| name == "arm.state" && params["subscription"] == *subscription);
    of.map(|(_, params)| params["state"].clone()).collect()
}

#[tokio::test(start_paused = true)]
async fn each_subscription_gets_its_rate() {
    let bench = LocalStation::new(1).await;
    let mut rates = Vec::new();
    for rate in [1, 3, 7, 20, 30, 50] {
        let mut viewer = bench.join("Viewer").await;
        let made = viewer.ok("arm.subscribe", json!({"rate": rate})).await;
        assert_eq!(made["rate"], json!(rate));
        rates.push((rate, made["subscription"].clone(), viewer));
    }
    for (rate, subscription, mut viewer) in rates {
        viewer.listen(Duration::from_millis(500)).await;
        viewer.notices.clear();
        let seconds = 20;
        viewer.listen(Duration::from_secs(seconds)).await;
        let got = states(&viewer.notices, &subscription).len() as f64;
        let wanted = (rate * seconds) as f64;
        assert!(
            (got - wanted).abs() <= 0.1 * wanted,
            "{rate} a second: {got} of {wanted}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn first_state_is_complete_and_later_ones_are_changes() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let made = anna.ok("arm.subscribe", json!({"rate": 10})).await;
    anna.listen(Duration::from_secs(1)).await;
    let all = states(&anna.notices, &made["subscription"]);
    for field in made["fields"].as_array().unwrap() {
        assert!(all[0].get(field.as_str().unwrap()).is_some(), "{field}");
    }
    assert_eq!(
        all[0].as_object().unwrap().len(),
        made["fields"].as_array().unwrap().len()
    );
    assert_eq!(all[5].as_object().unwrap().len(), 1, "{}", all[5]);
    anna.notices.clear();
    anna.lease().await;
    anna.listen(Duration::from_millis(50)).await;
    let told = states(&anna.notices, &made["subscription"]);
    assert_eq!(
        told[0]["holder"]["name"],
        json!("Anna"),
        "what is beside the reading is told at once"
    );
    assert!(told[0].get("x").is_none());
}

#[tokio::test(start_paused = true)]
async fn frame_has_112_bytes_and_other_changes_come_as_text() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let made = anna
        .ok("arm.subscribe", json!({"rate": 10, "frame": "binary"}))
        .await;
    anna.listen(Duration::from_secs(1)).await;
    let frame = &anna.frames[0];
    assert_eq!((frame.len(), frame[0], frame[1]), (112, 0x4D, 1));
    let value = |frame: &[u8], at: usize| {
        let from = 8 + 8 * at;
        f64::from_le_bytes(frame[from..from + 8].try_into().unwrap())
    };
    let pose = bench.arms[0].state().pose;
    assert_eq!(value(frame, 1), f64::from(pose.x as f32));
    assert!(value(frame, 9).is_nan(), "no rail");
    assert_eq!(value(frame, 12), 1.0, "the link is up, and nothing else");
    let numbers: Vec<_> = anna
        .frames
        .iter()
        .map(|frame| u32::from_le_bytes(frame[4..8].try_into().unwrap()))
        .collect();
    assert_eq!(numbers, (0..numbers.len() as u32).collect::<Vec<_>>());
    // The first state is whole. More may follow while settings are read; then nothing changes.
    assert!(!states(&anna.notices, &made["subscription"]).is_empty());
    anna.notices.clear();
    anna.listen(Duration::from_secs(1)).await;
    assert_eq!(states(&anna.notices, &made["subscription"]).len(), 0);
    anna.lease().await;
    anna.listen(Duration::from_millis(300)).await;
    assert_eq!(states(&anna.notices, &made["subscription"]).len(), 1);
    assert_eq!(value(anna.frames.last().unwrap(), 12), 65.0);
}

#[tokio::test(start_paused = true)]
async fn slow_reader_gets_the_newest_state_only() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.subscribe", json!({"rate": 50, "frame": "binary"}))
        .await;
    anna.listen(Duration::from_millis(200)).await;
    let before = anna.frames.len();
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 60, 50, 0]})).await;
    anna.frames.clear();
    // The client does not read for ten seconds.
    tokio::time::advance(Duration::from_millis(1)).await;
    let mut other = bench.join("Other").await;
    other.listen(Duration::from_secs(4)).await;
    assert!(before > 5);
    anna.client.pong();
    let mut frames = Vec::new();
    while let Some(outgoing) = anna.client.try_receive() {
        if let magician_station::Outgoing::Frame(frame) = outgoing {
            frames.push(frame);
        }
    }
    assert_eq!(frames.len(), 1, "one state waits, the newest");
    let y = f64::from_le_bytes(frames[0][24..32].try_into().unwrap());
    assert!((y - 60.0).abs() < 0.01, "{y}");
}

#[tokio::test(start_paused = true)]
async fn pins_are_read_for_their_subscribers() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let pins = json!([{"kind": "output", "address": 2}]);
    let made = anna
        .ok("arm.subscribe", json!({"rate": 10, "pins": pins}))
        .await;
    anna.listen(Duration::from_secs(1)).await;
    let all = states(&anna.notices, &made["subscription"]);
    let known = json!({"kind": "output", "address": 2, "value": 0});
    assert_eq!(all[0]["pins"][0], known, "the first state has them");
    assert!(all.len() > 8, "{}", all.len());
    // A state read for an answer leaves the pins unchanged.
    anna.notices.clear();
    anna.ok("lease.acquire", json!({})).await;
    anna.ok("arm.move", json!({"to": [220, 0, 40, 0]})).await;
    anna.listen(Duration::from_secs(1)).await;
    for state in states(&anna.notices, &made["subscription"]) {
        assert!(
            state.get("pins").is_none_or(|pins| pins[0] == known),
            "{state}"
        );
    }
    // A second subscription with its own pins starts while the arm is being read.
    let pins = json!([{"kind": "input", "address": 4}, {"kind": "output", "address": 2}]);
    let subscribed = json!({"rate": 1, "frame": "binary", "pins": pins});
    let mut ben = bench.join("Ben").await;
    let made = ben.ok("arm.subscribe", subscribed).await;
    ben.listen(Duration::from_millis(500)).await;
    let all = states(&ben.notices, &made["subscription"]);
    assert_eq!(
        all[0]["pins"].as_array().map(Vec::len),
        Some(2),
        "{:?}",
        all[0]
    );
    for pins in [
        json!([{"kind": "output"}]),
        json!([{"kind": "tail", "address": 2}]),
        json!([{"kind": "input", "address": 21}]),
    ] {
        assert_eq!(
            anna.code("arm.subscribe", json!({"rate": 10, "pins": pins}))
                .await,
            -32602
        );
    }
}

#[tokio::test(start_paused = true)]
async fn events_are_numbered_and_can_be_fetched_later() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.subscribe", json!({"rate": 10})).await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 60, 50, 0]})).await;
    anna.ok("arm.stop", json!({})).await;
    anna.listen(Duration::from_millis(300)).await;
    let told: Vec<_> = anna.noticed("arm.event").into_iter().cloned().collect();
    let names: Vec<_> = told
        .iter()
        .map(|event| event["event"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"lease") && names.contains(&"command-finished") && names.contains(&"stop"),
        "{names:?}"
    );
    let later = anna.ok("events.since", json!({"seq": 0})).await;
    assert_eq!(later["seq"], told.last().unwrap()["seq"]);
    let rest = anna
        .ok("events.since", json!({"seq": told[0]["seq"]}))
        .await;
    let earlier =
        later["events"].as_array().unwrap().len() - rest["events"].as_array().unwrap().len();
    assert_eq!(Some(earlier as u64), told[0]["seq"].as_u64());
}

#[tokio::test(start_paused = true)]
async fn homed_is_true_from_homing_to_the_next_reset() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let made = anna.ok("arm.subscribe", json!({"rate": 10})).await;
    anna.lease().await;
    let mut asked = Vec::new();
    for step in ["", "arm.clear_alarms", "arm.home", "reset"] {
        match step {
            "" => {}
            "reset" => bench.arms[0].with(|arm| arm.inject(ExternalEvent::Reset)),
            method => drop(anna.ok(method, json!({})).await),
        }
        anna.listen(Duration::from_secs(1)).await;
        let state = anna.ok("arm.state", json!({})).await;
        asked.push(state["homed"].clone());
    }
    let course = [json!(false), Value::Null, json!(true), json!(false)];
    assert_eq!(asked, course);
    let states = states(&anna.notices, &made["subscription"]);
    let mut told: Vec<_> = { states.iter() }
        .filter_map(|state| state.get("homed"))
        .collect();
    // A whole state repeats values.
    told.dedup();
    assert_eq!(told, course.iter().collect::<Vec<_>>(), "{told:?}");
}
