//! Limits: a client affects itself and no other.

use std::time::Duration;

use magician_station::CloseCode;
use serde_json::json;

use crate::bench::LocalStation;

#[tokio::test(start_paused = true)]
async fn messages_above_the_rate_are_refused_except_stops() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut last = 0;
    for _ in 0..250 {
        last = anna.send("server.info", json!({}));
    }
    let error = anna.answer(last).await.unwrap_err();
    assert_eq!(
        (&error["code"], &error["data"]["limit"]),
        (&json!(-32006), &json!(200))
    );
    anna.ok("arm.stop", json!({})).await;
    anna.listen(Duration::from_millis(1100)).await;
    anna.ok("server.info", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn client_above_the_rate_for_5_s_is_closed() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for _ in 0..80 {
        for _ in 0..30 {
            anna.send("server.info", json!({}));
        }
        anna.listen(Duration::from_millis(100)).await;
        if anna.closed.is_some() {
            break;
        }
    }
    assert_eq!(anna.closed, Some(CloseCode::TOO_MANY));
}

#[tokio::test(start_paused = true)]
async fn seventeenth_subscription_is_refused() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for _ in 0..16 {
        anna.ok("arm.subscribe", json!({"rate": 1})).await;
    }
    assert_eq!(anna.code("arm.subscribe", json!({"rate": 1})).await, -32006);
    anna.ok("arm.unsubscribe", json!({"subscription": 3})).await;
    anna.ok("arm.subscribe", json!({"rate": 1})).await;
}

#[tokio::test(start_paused = true)]
async fn request_65_in_flight_is_refused() {
    let bench = LocalStation::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    anna.lease().await;
    for _ in 0..64 {
        ben.send("lease.acquire", json!({"wait_s": 100}));
    }
    assert_eq!(ben.code("arm.info", json!({})).await, -32006);
    ben.ok("arm.stop", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn non_reading_client_is_closed_without_slowing_others() {
    let bench = LocalStation::new(1).await;
    let mut deaf = bench.join("Deaf").await;
    let mut anna = bench.join("Anna").await;
    deaf.ok("arm.subscribe", json!({"rate": 50})).await;
    // Notifications of jogs go to all sessions.
    anna.lease().await;
    for _ in 0..1200 {
        let jog = anna.ok("jog.start", json!({"axis": "j4+"})).await["jog"].clone();
        anna.ok("jog.stop", json!({"jog": jog})).await;
        anna.notices.clear();
    }
    assert!(deaf.message().await.is_none());
    assert_eq!(deaf.closed, Some(CloseCode::SLOW));
}
