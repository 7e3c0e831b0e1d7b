//! Fence of an arm: who reads and changes it, and that it applies to every session.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::LocalStation;

fn floor(z: f64) -> Value {
    json!({"set": {"floor": z}})
}

fn is_the_fences(refused: &Value, value: f64, limit: f64) {
    let data = &refused["data"];
    assert_eq!(
        (&refused["code"], &data["kind"], &data["fence"]),
        (&json!(-32000), &json!("unreachable"), &json!("floor")),
        "{refused}"
    );
    assert_eq!(
        (&data["value"], &data["limit"], &data["unit"]),
        (&json!(value), &json!(limit), &json!("mm")),
        "{refused}"
    );
}

#[tokio::test(start_paused = true)]
async fn fence_change_affects_named_members_and_is_visible_to_all() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    let mut ben = bench.join_as("Ben", Role::Viewer).await;
    assert_eq!(ben.ok("arm.fence", json!({})).await, json!({"fence": null}));
    assert_eq!(ben.code("arm.fence", floor(-20.0)).await, -32001);
    let mut student = bench.join("Cleo").await;
    assert_eq!(student.code("arm.fence", floor(-20.0)).await, -32001);
    anna.ok("arm.fence", floor(-20.0)).await;
    let within = json!({"x": [0.0, 300.0], "y": [-250.0, 250.0], "z": [-40.0, 200.0]});
    let keep_out = json!([{"x": [200.0, 220.0], "y": [100.0, 120.0], "z": [-40.0, 0.0]}]);
    let set = json!({"set": {"box": within, "keep_out": keep_out, "speed": 120.0, "power": 40}});
    anna.ok("arm.fence", set).await;
    let whole = json!({
        "floor": -20.0, "box": within, "keep_out": keep_out, "speed": 120.0, "power": 40.0,
    });
    let seen = ben.ok("arm.fence", json!({})).await;
    assert_eq!(seen, json!({"fence": whole}));
    // Other members stay.
    let faster = anna.ok("arm.fence", json!({"set": {"speed": 130.0}})).await;
    assert_eq!(faster["fence"]["keep_out"], keep_out);
    assert_eq!(faster["fence"]["box"], within);
    let set = json!({"set": {"box": null, "keep_out": [], "speed": null, "power": null}});
    let left = anna.ok("arm.fence", set).await;
    assert_eq!(
        left,
        json!({"fence": {"floor": -20.0, "box": null, "keep_out": [], "speed": null, "power": null}})
    );
    assert_eq!(
        anna.ok("arm.fence", json!({"set": null})).await,
        json!({"fence": null})
    );
    assert_eq!(ben.ok("arm.fence", json!({})).await, json!({"fence": null}));
    bench.station.flush().await;
    let lines = bench.lines.lock().unwrap();
    let fences = lines.iter().filter(|line| line.method == "arm.fence");
    let results: Vec<_> = fences.map(|line| line.result.as_str()).collect();
    assert_eq!(
        results,
        ["forbidden", "forbidden", "ok", "ok", "ok", "ok", "ok"],
        "changes are in the journal, looks are not"
    );
}

#[tokio::test(start_paused = true)]
async fn invalid_fence_is_refused_and_the_old_one_kept() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.ok("arm.fence", floor(-20.0)).await;
    for set in [
        json!({"roof": 3}),
        json!({"floor": "low"}),
        json!({"floor": -50, "speed": 0}),
        json!({"floor": -50, "power": 101}),
        json!({"floor": -50, "box": {"x": [0, 1], "y": [0, 1]}}),
        json!({"floor": -50, "box": {"x": [1, 0], "y": [0, 1], "z": [0, 1]}}),
        json!({"floor": -50, "keep_out": {"x": [0, 1]}}),
        json!(3),
    ] {
        let refused = anna.call("arm.fence", json!({"set": set})).await;
        let refused = refused.expect_err("a fence");
        assert_eq!(
            (&refused["code"], &refused["data"]["param"]),
            (&json!(-32602), &json!("set")),
            "{refused}"
        );
    }
    let fence = anna.ok("arm.fence", json!({})).await["fence"].clone();
    assert_eq!(fence["floor"], json!(-20.0));
}

#[tokio::test(start_paused = true)]
async fn fence_applies_to_moves_raw_commands_steps_and_jobs() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    let mut ben = bench.join("Ben").await;
    ben.lease().await;
    ben.ok("arm.move", json!({"to": [220, 0, 0, 0]})).await;
    anna.ok("arm.fence", floor(-20.0)).await;
    let to = json!({"to": [220, 0, -30, 0]});
    is_the_fences(&ben.call("arm.move", to).await.unwrap_err(), -30.0, -20.0);
    let fields = json!({"ptpMode": "MOVL_XYZ", "x": 220, "y": 0, "z": -30, "r": 0});
    let raw = json!({"command": "ptp_cmd", "fields": fields});
    for method in ["arm.set", "arm.enqueue"] {
        let refused = ben.call(method, raw.clone()).await.unwrap_err();
        is_the_fences(&refused, -30.0, -20.0);
    }
    let step = json!({"axis": "z", "by": -30});
    is_the_fences(&ben.call("jog.step", step).await.unwrap_err(), -30.0, -20.0);
    let plan =
        json!({"format": "magician-plan", "version": 1, "steps": [{"move": [220, 0, -30, 0]}]});
    let job = ben
        .call("job.start", json!({"text": plan.to_string()}))
        .await;
    assert_eq!(job.unwrap_err()["code"], json!(-32004));
    let pose = bench.arms[0].state().pose;
    assert!((pose.z).abs() < 1e-3, "{pose:?}");
    // Removed again.
    anna.ok("arm.fence", json!({"set": null})).await;
    ben.ok("arm.move", json!({"to": [220, 0, -30, 0]})).await;
}

#[tokio::test(start_paused = true)]
async fn jog_stops_before_the_fence() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 0, 0, 0]})).await;
    anna.ok("arm.fence", floor(-20.0)).await;
    let jog = json!({"axis": "z-", "keep_ms": 1000});
    let jog = anna.ok("jog.start", jog).await["jog"].clone();
    // The fence cannot be changed during a jog.
    let busy = anna.call("arm.fence", floor(-60.0)).await.unwrap_err();
    assert_eq!(
        (&busy["code"], &busy["data"]["jog"]),
        (&json!(-32003), &jog)
    );
    let mut lowest = f64::INFINITY;
    for _ in 0..40 {
        anna.notify("jog.keep", json!({"jog": jog}));
        anna.listen(Duration::from_millis(100)).await;
        lowest = lowest.min(bench.arms[0].state().pose.z);
    }
    assert!((-20.01..-5.0).contains(&lowest), "{lowest}");
}

#[tokio::test(start_paused = true)]
async fn setting_a_fence_ends_unchecked_motion() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    let mut ben = bench.join("Ben").await;
    ben.lease().await;
    ben.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
    let queued = json!({"to": [220, 0, -40, 0], "by": "linear", "wait": false});
    ben.ok("arm.move", queued).await;
    let moving = ben.send("arm.move", json!({"to": [220, 0, -50, 0]}));
    ben.listen(Duration::from_millis(200)).await;
    assert!(bench.arms[0].state().moving);
    anna.ok("arm.fence", floor(0.0)).await;
    let ended = ben.answer(moving).await.unwrap_err();
    assert_eq!(ended["code"], json!(-32007), "{ended}");
    ben.listen(Duration::from_secs(4)).await;
    let pose = bench.arms[0].state().pose;
    assert!(pose.z > 0.0 && !bench.arms[0].state().moving, "{pose:?}");
    // A job has to be stopped first.
    let job = ben.begin_job().await;
    let busy = anna
        .call("arm.fence", json!({"set": null}))
        .await
        .unwrap_err();
    assert_eq!(
        (&busy["code"], &busy["data"]["job"]),
        (&json!(-32003), &job)
    );
}
