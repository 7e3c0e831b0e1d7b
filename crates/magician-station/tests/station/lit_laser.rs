//! Verbs that move the arm while the laser is lit by hand.

use serde_json::{Value, json};

use crate::bench::LocalStation;

/// Verbs that move, with their parameters.
fn moves() -> Vec<(&'static str, Value)> {
    let plan = json!({"format": "magician-plan", "version": 1, "steps": [
        {"move": [220, 40, 50, 0], "by": "line"}]});
    let axes = ["x+", "y-", "z+", "r-", "j1+", "j4-"];
    let mut moves: Vec<_> = { axes.iter() }
        .map(|axis| ("jog.start", json!({"axis": axis})))
        .collect();
    moves.extend([
        ("jog.start", json!({"axis": "y+", "percent": 10})),
        ("jog.step", json!({"axis": "z", "by": 5})),
        (
            "jog.step",
            json!({"axis": "x", "by": 5, "frame": "tool", "percent": 10}),
        ),
        ("arm.move", json!({"to": [220, 10, 50, 0]})),
        ("arm.move", json!({"to": [220, 10, 50, 0], "wait": false})),
        (
            "arm.move",
            json!({"to": [0, 0, 5, 0], "relative": true, "by": "linear"}),
        ),
        ("arm.set", json!({"command": "QueuedCmdStartExec"})),
        ("job.start", json!({"text": plan.to_string()})),
        ("surface.touch", json!({})),
        ("surface.corner", json!({"corner": "lower-left"})),
    ]);
    moves
}

#[tokio::test(start_paused = true)]
async fn lit_laser_blocks_every_motion_method() {
    for by_pin in [false, true] {
        let bench = LocalStation::new(1).await;
        let mut anna = bench.join("Anna").await;
        anna.lease().await;
        if by_pin {
            for (command, fields) in [
                ("IOMultiplexing", json!({"address": 2, "multiplex": 1})),
                ("IODO", json!({"address": 2, "level": 1})),
            ] {
                let params = json!({"command": command, "fields": fields});
                anna.ok("arm.set", params).await;
            }
        } else {
            anna.ok("arm.tool", json!({"laser": {"on": true}})).await;
        }
        let before = bench.arms[0].state().pose;
        for (verb, params) in moves() {
            let refused = anna.call(verb, params.clone()).await.unwrap_err();
            let code = &refused["data"]["code"];
            assert_eq!(code, &json!("laser-on"), "{verb} {params}: {refused}");
        }
        assert_eq!(bench.arms[0].state().pose, before);
        anna.ok("arm.tool", json!({"laser": {"on": false}})).await;
        let jog = anna.ok("jog.start", json!({"axis": "y+"})).await;
        anna.ok("jog.stop", jog).await;
        anna.ok("jog.step", json!({"axis": "z", "by": 5})).await;
    }
}
