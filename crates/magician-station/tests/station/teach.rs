//! Teaching: rows of a table, the plan made from them, and points taught by hand.

use std::time::Duration;

use magician_station::{ArmOrder, LibraryAct};
use serde_json::{Value, json};

use crate::bare::BareStation;
use crate::bench::{LocalStation, Tester};

fn plan() -> Value {
    json!({
        "format": "magician-plan", "version": 1, "title": "pick", "tool": "suction",
        "surface": {"height": -60.0, "slope": [0, 0]},
        "steps": [
            {"command": "PTPCommonParams", "values": {"velocity_ratio": 40, "acceleration_ratio": 40}},
            {"move": [220, 0, 40, 0], "by": "line", "name": "P1"},
            {"suction": true, "name": "P1"},
            {"wait": 0.5, "name": "P1"},
            {"joints": [0, 30, 30, 0], "by": "joints", "name": "P2"},
            {"gripper": "close", "name": "P2"}
        ]
    })
}

#[tokio::test(start_paused = true)]
async fn rows_round_trip_to_a_plan() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let taught = anna.ok("teach.rows", json!({"plan": plan()})).await;
    let rows = taught["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3, "{taught}");
    assert_eq!(
        rows[1],
        json!({
            "name": "P1", "motion": {"move": [220, 0, 40, 0], "by": "line"},
            "gripper": null, "suction": true, "wait": 0.5
        })
    );
    assert_eq!(rows[2]["gripper"], json!("close"));
    assert_eq!(rows[0]["motion"]["command"], json!("PTPCommonParams"));
    let made = anna.ok("teach.plan", taught.clone()).await;
    assert_eq!(made["first"], json!([0, 1, 4]));
    let again = anna
        .ok("teach.rows", json!({"plan": made["plan"].clone()}))
        .await;
    assert_eq!(again, taught);
    assert_eq!(made["plan"]["surface"]["height"], json!(-60));
}

#[tokio::test(start_paused = true)]
async fn row_error_names_its_row() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let good = json!({"name": "P1", "motion": {"move": [220, 0, 40, 0]}, "wait": 1});
    for bad in [
        json!({"name": "P2", "motion": {"move": [220, 0, 40]}}),
        json!({"name": "P2", "motion": {"fly": true}}),
        json!({"name": "P2", "wait": -1}),
        json!({"name": "P2", "gripper": "wide"}),
        json!({"name": "P2", "colour": "red"}),
    ] {
        let rows = json!({"rows": [good.clone(), bad.clone()]});
        let refused = anna.call("teach.plan", rows).await.unwrap_err();
        assert_eq!(
            (&refused["code"], &refused["data"]["row"]),
            (&json!(-32602), &json!(2)),
            "{bad}: {refused}"
        );
    }
    let refused = anna
        .call("teach.rows", json!({"plan": {"steps": []}}))
        .await;
    assert_eq!(refused.unwrap_err()["data"]["param"], json!("plan"));
}

#[tokio::test(start_paused = true)]
async fn hand_guided_points_are_reported_until_the_lease_ends() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    assert_eq!(anna.code("teach.guide", json!({"on": true})).await, -32002);
    anna.ok("arm.subscribe", json!({"rate": 10})).await;
    let lease = anna.lease().await;
    anna.ok("teach.guide", json!({"on": true})).await;
    let enabled = json!({"command": "HHTTrigOutputEnabled"});
    assert_eq!(
        anna.ok("arm.get", enabled.clone()).await["is_enabled"],
        json!(1)
    );
    for joints in [[20, 30, 40, 10], [0, 40, 40, 0]] {
        anna.ok("world.unlock", json!({"held": true})).await;
        anna.ok("world.guide", json!({"joints": joints})).await;
        anna.ok("world.unlock", json!({"held": false})).await;
        anna.listen(Duration::from_millis(400)).await;
    }
    let events = anna.noticed("arm.event");
    let taught: Vec<_> = { events.iter() }
        .filter(|event| event["event"] == json!("hand-trigger"))
        .collect();
    assert_eq!(taught.len(), 2, "{events:?}");
    assert_eq!(taught[0]["step"]["by"], json!("joints"));
    assert_ne!(taught[0]["step"]["move"], taught[1]["step"]["move"]);
    // Settings are restored, and nothing more is reported.
    anna.ok("lease.release", json!({"lease": lease})).await;
    anna.listen(Duration::from_secs(1)).await;
    assert_eq!(anna.ok("arm.get", enabled).await["is_enabled"], json!(0));
}

/// Returns the setting for reports of the unlock key, and the number of reports, once everything
/// sent is done.
async fn tells(tester: &mut Tester) -> (Value, usize) {
    tester.listen(Duration::from_secs(1)).await;
    let enabled = json!({"command": "HHTTrigOutputEnabled"});
    let enabled = tester.ok("arm.get", enabled).await["is_enabled"].clone();
    tester.notices.clear();
    let lease = tester.lease().await;
    tester.ok("world.unlock", json!({"held": true})).await;
    let joints = json!({"joints": [20, 30, 40, 10]});
    tester.ok("world.guide", joints).await;
    tester.ok("world.unlock", json!({"held": false})).await;
    tester.listen(Duration::from_secs(1)).await;
    tester.ok("lease.release", json!({"lease": lease})).await;
    let events = tester.noticed("arm.event").into_iter();
    let told = events.filter(|event| event["event"] == json!("hand-trigger"));
    (enabled, told.count())
}

#[tokio::test(start_paused = true)]
async fn guiding_started_as_the_lease_ends_is_off() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.subscribe", json!({"rate": 10})).await;
    for behind_a_move in [false, true] {
        let lease = anna.lease().await;
        if behind_a_move {
            anna.send("arm.move", json!({"to": [220, 0, 40, 0]}));
        }
        let begins = anna.send("teach.guide", json!({"on": true}));
        anna.send("lease.release", json!({"lease": lease}));
        assert_eq!(anna.answer(begins).await, Ok(Value::Null));
        anna.listen(Duration::from_secs(5)).await;
        assert_eq!(tells(&mut anna).await, (json!(0), 0), "{behind_a_move}");
    }
}

#[tokio::test(start_paused = true)]
async fn concurrent_guiding_requests_apply_the_last_one() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("arm.subscribe", json!({"rate": 10})).await;
    for wishes in [&[true, true][..], &[true, false], &[true, false, true]] {
        let lease = anna.lease().await;
        let on = |on: &bool| anna.send("teach.guide", json!({"on": on}));
        let sent: Vec<_> = wishes.iter().map(on).collect();
        for sent in sent {
            assert_eq!(anna.answer(sent).await, Ok(Value::Null), "{wishes:?}");
        }
        let enabled = json!({"command": "HHTTrigOutputEnabled"});
        let enabled = anna.ok("arm.get", enabled).await["is_enabled"].clone();
        let wanted = u8::from(wishes.last() == Some(&true));
        assert_eq!(enabled, json!(wanted), "{wishes:?}");
        anna.ok("lease.release", json!({"lease": lease})).await;
        assert_eq!(tells(&mut anna).await, (json!(0), 0), "{wishes:?}");
    }
}

#[test]
fn lease_end_switches_guiding_off_only_at_its_arm() {
    let ended = |wishes: &[bool]| {
        let mut station = BareStation::new();
        station.send("lease.acquire", &json!({}));
        for on in wishes {
            station.send("teach.guide", &json!({"on": on}));
        }
        while station.station.poll_order().is_some() {}
        station.send("lease.take", &json!({}));
        let other = station.join("Ben");
        station.ask(other, "lease.take", &json!({}));
        let orders = std::iter::from_fn(|| station.station.poll_order());
        let ends = orders.filter(|(_, order)| matches!(order, ArmOrder::Guide { on: false, .. }));
        ends.count()
    };
    assert_eq!(ended(&[]), 0);
    assert_eq!(ended(&[true]), 1);
    assert_eq!(ended(&[true, true]), 1);
    assert_eq!(ended(&[true, false]), 0);
}

#[test]
fn conversion_of_taught_program_does_not_wait_for_checks() {
    let mut bare = BareStation::new();
    let anna = bare.join("Anna");
    bare.ask(anna, "job.check", &json!({"text": plan().to_string()}));
    for (method, params) in [
        ("teach.rows", json!({"plan": plan()})),
        ("teach.plan", json!({"rows": []})),
    ] {
        bare.ask(anna, method, &params);
        let order = bare.station.poll_library().expect(method);
        assert!(matches!(order.act, LibraryAct::Teach(_)), "{method}");
        bare.station
            .library_done(bare.now, order.request, Ok(json!({})));
    }
}
