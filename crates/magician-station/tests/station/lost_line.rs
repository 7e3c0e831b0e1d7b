//! After a lost line nothing counts that was read before.

use std::time::Duration;

use magician_station::{ArmOrder, ArmReport, Outcome, Outgoing};
use serde_json::{Value, json};

use crate::bare::BareStation;

#[test]
fn stale_state_is_neither_sent_nor_returned_after_a_lost_line() {
    let mut station = BareStation::new();
    station.subscribe("json");
    station.read(1.0, Duration::ZERO);
    assert_eq!(station.states()[0]["x"], json!(1.0));
    station.line(false);
    station.now += Duration::from_millis(10);
    station.line(true);
    assert_eq!(station.states(), [json!({"link": "lost", "t": 1.0})]);
    // A change outside the reading triggers a state, if there is a reading.
    station.send("lease.acquire", &json!({}));
    // Readings that were on their way when the line broke.
    station.now += Duration::from_millis(5);
    station.read(1.0, Duration::from_millis(6));
    station.read(1.0, Duration::from_millis(60));
    assert_eq!(station.states(), [] as [Value; 0]);
    // Less than 100 ms old, but from before.
    while station.station.poll_order().is_some() {}
    station.send("arm.state", &json!({}));
    let order = station.station.poll_order();
    assert!(
        matches!(order, Some((_, ArmOrder::Read { .. }))),
        "{order:?}"
    );
    station.now += Duration::from_millis(20);
    station.read(2.0, Duration::from_millis(20));
    let states = station.states();
    assert_eq!(
        (&states[0]["x"], &states[0]["link"]),
        (&json!(2.0), &json!("up"))
    );
}

#[test]
fn pending_state_is_dropped_when_the_line_breaks() {
    for frame in ["json", "binary"] {
        let mut station = BareStation::new();
        station.subscribe(frame);
        station.read(1.0, Duration::ZERO);
        station.states();
        station.frames = 0;
        station.now += Duration::from_millis(100);
        station.read(2.0, Duration::ZERO);
        station.line(false);
        station.line(true);
        station.now += Duration::from_millis(100);
        station.read(3.0, Duration::ZERO);
        // Nothing was sent in between: first the loss, then the new state with the line up.
        let states = station.states();
        assert_eq!(states[0]["link"], json!("lost"), "{frame}");
        let x = states[1].get("x");
        assert!(frame == "binary" || x == Some(&json!(3.0)), "{states:?}");
        assert_eq!(station.frames, usize::from(frame == "binary"));
        assert!(frame == "binary" || states[1]["link"] == json!("up"));
    }
}

#[test]
fn request_with_a_reading_before_a_lost_line_fails() {
    let mut station = BareStation::new();
    station.send("arm.state", &json!({}));
    let Some((_, ArmOrder::Read { request, .. })) = station.station.poll_order() else {
        panic!("it is read");
    };
    station.read(1.0, Duration::ZERO);
    station.line(false);
    station.line(true);
    let outcome = Ok(Outcome::State);
    station.report(ArmReport::Done { request, outcome });
    let answer = station.received().pop().unwrap();
    assert_eq!(answer["error"]["data"]["kind"], json!("port"));
}

#[test]
fn first_state_follows_the_subscription_answer() {
    let mut station = BareStation::new();
    station.read(1.0, Duration::ZERO);
    station.subscribe("json");
    let heard = station.received();
    assert!(heard[0].get("result").is_some(), "{heard:?}");
    assert_eq!(heard[1]["params"]["state"]["x"], json!(1.0));
}

#[test]
fn closing_socket_stores_nothing() {
    let mut station = BareStation::new();
    station.send("arm.state", &json!({}));
    let Some((_, ArmOrder::Read { request, .. })) = station.station.poll_order() else {
        panic!("it is read");
    };
    station.received();
    station.station.revoke(station.now, "token of Anna");
    let told = std::iter::from_fn(|| station.station.poll_send(station.socket));
    assert!(
        { told }
            .take(10)
            .any(|said| matches!(said, Outgoing::Close(_))),
        "its end"
    );
    station.read(1.0, Duration::ZERO);
    let outcome = Ok(Outcome::State);
    station.report(ArmReport::Done { request, outcome });
    assert_eq!(station.station.size().unsent, 0);
}
