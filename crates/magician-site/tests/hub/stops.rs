//! Stops reach every arm, whatever else is pending.

use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::time::Instant;

use crate::bench::TestHub;

#[tokio::test(start_paused = true)]
async fn stop_of_all_arms_is_sent_in_parallel() {
    let bench = TestHub::new(3, 3).await;
    let mut anna = bench.join("Anna").await;
    let mut moves = Vec::new();
    for arm in 0..9 {
        let arm = format!("arm{arm}");
        anna.take_arm(&arm).await;
        moves.push(anna.send("arm.move", json!({"arm": arm, "to": [0, 220, 20, 0]})));
    }
    anna.run_for(Duration::from_millis(300)).await;
    let mut ben = bench.join("Ben").await;
    let begun = Instant::now();
    let stopped = ben.ok("arm.stop", json!({})).await;
    assert!(begun.elapsed() < Duration::from_secs(1));
    let arms = stopped["arms"].as_array().unwrap();
    assert_eq!(arms.len(), 9);
    assert!(arms.iter().all(|arm| arm["stood"] == true));
    for arm in 0..9 {
        let state = ben
            .ok("arm.state", json!({"arm": format!("arm{arm}")}))
            .await;
        assert_eq!(state["moving"], false);
        let y = state["y"].as_f64().unwrap();
        assert!(y < 200.0, "arm{arm} went on to {y}");
    }
}

#[tokio::test(start_paused = true)]
async fn silent_station_is_named_and_delays_no_other() {
    let bench = TestHub::new(3, 2).await;
    let mut anna = bench.join("Anna").await;
    anna.take_arm("arm0").await;
    bench.site.silence(2);
    let moving = anna.send("arm.move", json!({"arm": "arm0", "to": [0, 220, 20, 0]}));
    anna.run_for(Duration::from_millis(100)).await;
    let begun = Instant::now();
    let error = anna.fails("arm.stop", json!({})).await;
    let took = begun.elapsed();
    assert!((2900..3100).contains(&took.as_millis()), "{took:?}");
    let message = error["message"].as_str().unwrap();
    assert!(
        message.contains("arm2, arm3") && !message.contains("arm0"),
        "{message}"
    );
    assert_eq!(error["data"]["kind"], "timeout");
    let stood: Vec<_> = error["data"]["arms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|arm| arm["arm"].clone())
        .collect();
    assert_eq!(
        stood,
        [json!("arm0"), json!("arm1"), json!("arm4"), json!("arm5")]
    );
    // Without the stop the move would have ended long ago.
    let state = anna.ok("arm.state", json!({"arm": "arm0"})).await;
    assert!(state["y"].as_f64().unwrap() < 100.0, "{state}");
    let _ = moving;
}

#[tokio::test(start_paused = true)]
async fn requests_waiting_for_a_line_are_dropped_by_a_stop() {
    let bench = TestHub::new(2, 1).await;
    let mut anna = bench.join("Anna").await;
    // The station does not answer the hello and drops the line after a second, so that requests
    // wait in the hub.
    bench.site.silence(1);
    bench.site.fault(
        1,
        Some(Arc::new(|end| {
            tokio::spawn(async move {
                tokio::time::sleep(Duration::from_secs(1)).await;
                drop(end);
            });
        })),
    );
    let waiting = anna.send("arm.move", json!({"arm": "arm0", "to": [220, 40, 20, 0]}));
    let stop = anna.send("arm.stop", json!({"arm": "arm0"}));
    let error = anna.answer(waiting).await.unwrap_err();
    assert_eq!(
        (&error["code"], &error["data"]["by"].is_string()),
        (&json!(-32007), &true)
    );
    assert!(anna.answer(stop).await.is_err());
}

#[tokio::test(start_paused = true)]
async fn request_in_flight_is_followed_by_a_stop() {
    let bench = TestHub::new(1, 1).await;
    let mut anna = bench.join("Anna").await;
    let (sent, methods) = std::sync::mpsc::channel();
    bench.site.fault(1, Some(Arc::new(move |mut end: magician_site::StationEnd| {
        let sent = sent.clone();
        tokio::spawn(async move {
            while let Some(message) = end.from_client.recv().await {
                if let magician_site::ToStation::Text(text) = message {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if message["method"] == "session.hello" {
                        let answer = json!({"jsonrpc": "2.0", "id": message["id"], "result": {"session": "s", "resume": "r"}});
                        let answer = magician_site::FromStation::Text(answer.to_string());
                        end.to_client.send(answer).await.unwrap();
                    }
                    sent.send(message["method"].as_str().unwrap().to_owned()).unwrap();
                }
            }
        });
    })));
    anna.send("arm.move", json!({"arm": "arm0", "to": [220, 40, 20, 0]}));
    anna.run_for(Duration::from_millis(10)).await;
    anna.ok("arm.stop", json!({"arm": "arm0"})).await;
    anna.run_for(Duration::from_millis(10)).await;
    let methods: Vec<_> = methods
        .try_iter()
        .filter(|method| method != "server.info" && method != "turn.list")
        .collect();
    assert_eq!(methods, ["session.hello", "arm.move", "arm.stop"]);
    assert_eq!(*bench.site.calls.lock().unwrap(), ["arm.stop"]);
}

#[tokio::test(start_paused = true)]
async fn stop_names_only_the_arm_with_a_lost_line() {
    let bench = TestHub::new(2, 2).await;
    let mut anna = bench.join("Anna").await;
    let cable = magician::sim::ExternalEvent::Cable { plugged: false };
    bench.site.station(1).cells[0].with(|arm| arm.inject(cable));
    anna.run_for(Duration::from_millis(500)).await;
    let error = anna.fails("arm.stop", json!({})).await;
    let message = error["message"].as_str().unwrap();
    assert!(
        message.contains("arm0") && !message.contains("arm1"),
        "{message}"
    );
    let stood = error["data"]["arms"].as_array().unwrap().iter();
    let stood: Vec<_> = stood.map(|arm| arm["arm"].as_str().unwrap()).collect();
    assert_eq!(stood, ["arm1", "arm2", "arm3"]);
}
