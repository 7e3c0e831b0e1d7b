//! Tools and speeds.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::LocalStation;

#[tokio::test(start_paused = true)]
async fn laser_tool_is_full_power_or_off() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let laser = |on: bool, power: Value| json!({"laser": {"on": on, "power": power}});
    let refused = anna.call("arm.tool", laser(true, json!(40))).await;
    let refused = refused.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unsupported"), "{refused}");
    for wrong in [
        laser(true, json!(101)),
        laser(true, json!("full")),
        json!({"laser": {"power": 100}}),
        json!({"laser": {"on": true, "colour": "red"}}),
    ] {
        let refused = anna.call("arm.tool", wrong).await.unwrap_err();
        assert_eq!(
            (&refused["code"], &refused["data"]["param"]),
            (&json!(-32602), &json!("laser"))
        );
    }
    assert!(!bench.arms[0].state().laser);
    let state = anna.ok("arm.tool", laser(true, json!(100))).await;
    assert_eq!(state["tool"]["laser"], json!(true));
    assert!(bench.arms[0].state().laser);
    let state = anna.ok("arm.tool", laser(false, json!(0))).await;
    assert_eq!(state["tool"]["laser"], json!(false));
    assert!(!bench.arms[0].state().laser);
}

#[tokio::test(start_paused = true)]
async fn laser_goes_off_with_its_session() {
    let bench = LocalStation::real(1).await;
    for method in ["arm.tool", "arm.set"] {
        let mut anna = bench.join_as("Anna", Role::Teacher).await;
        anna.ok("lease.take", json!({})).await;
        let lit = match method {
            "arm.tool" => json!({"laser": {"on": true}, "yes": true}),
            _ => {
                json!({"command": "SetEndEffectorLaser", "fields": {"enable_ctrl": 1, "on": 1}, "yes": true})
            }
        };
        anna.ok(method, lit).await;
        assert!(bench.arms[0].state().laser);
        drop(anna);
        let mut ben = bench.join("Ben").await;
        ben.listen(Duration::from_secs(6)).await;
        assert!(!bench.arms[0].state().laser, "{method}");
    }
}

#[tokio::test(start_paused = true)]
async fn speed_setting_is_set_by_name() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let fields = json!({"velocity": [11, 12, 13, 14], "acceleration": [21, 22, 23, 24]});
    let row = json!({"row": "PTPJointParams", "fields": fields});
    assert_eq!(anna.ok("arm.speed", row).await, json!(null));
    let read = anna
        .ok("arm.get", json!({"command": "PTPJointParams"}))
        .await;
    assert_eq!(read["velocity"], json!([11.0, 12.0, 13.0, 14.0]), "{read}");
    let pose = json!({"x": 220, "y": 0, "z": 0, "r": 0, "ptp_mode": "movl-xyz"});
    for (wrong, param) in [
        (json!({"row": "PTPCmd", "fields": pose}), "row"),
        (json!({"row": "Nonsense"}), "row"),
        (json!({"row": "CPParams", "fields": {"x": 1}}), "fields"),
        (json!({"row": "CPParams", "percent": 5}), "percent"),
        (json!({"percent": 5, "fields": {}}), "percent"),
        (json!({}), "percent"),
    ] {
        let refused = anna.call("arm.speed", wrong.clone()).await.unwrap_err();
        assert_eq!(
            (&refused["code"], &refused["data"]["param"]),
            (&json!(-32602), &json!(param)),
            "{wrong}: {refused}"
        );
    }
    // During a job only the speed as a whole can be changed.
    anna.begin_job().await;
    let row =
        json!({"row": "PTPCommonParams", "fields": {"velocity_ratio": 5, "acceleration_ratio": 5}});
    assert_eq!(anna.code("arm.speed", row).await, -32003);
    anna.ok("arm.speed", json!({"percent": 80})).await;
}
