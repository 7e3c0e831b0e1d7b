//! Programs that are taught: rows of a table, the plan that they make, and points that a hand teaches.

use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::Bench;

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
async fn rows_are_steps_of_the_plan_and_make_it_again() {
    let bench = Bench::new(1).await;
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
async fn what_is_wrong_with_a_row_names_it() {
    let bench = Bench::new(1).await;
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
async fn a_hand_teaches_points_until_the_lease_ends() {
    let bench = Bench::new(1).await;
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
    // What was changed of the arm for it is restored, and it tells no more.
    anna.ok("lease.release", json!({"lease": lease})).await;
    anna.listen(Duration::from_secs(1)).await;
    assert_eq!(anna.ok("arm.get", enabled).await["is_enabled"], json!(0));
}
