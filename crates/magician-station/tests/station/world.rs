//! The world of a virtual arm, and what the arm is made of.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{Bench, Tester};

const CUBES: &str = r#"
tool = { kind = "suction" }
table = { height = -60 }
object = [
    { name = "red cube", size = [20, 20, 20], at = [220, 0] },
    { name = "blue cube", size = [20, 20, 20], at = [220, 60] },
]
"#;

fn object<'a>(look: &'a Value, name: &str) -> &'a Value {
    let mut objects = look["objects"].as_array().unwrap().iter();
    objects
        .find(|object| object["name"] == json!(name))
        .unwrap()
}

#[tokio::test(start_paused = true)]
async fn a_world_is_changed_by_the_holder_alone_and_by_teachers_as_a_whole() {
    let bench = Bench::new(1).await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    let empty = viewer.ok("world.look", json!({})).await;
    assert_eq!(
        (&empty["objects"], &empty["unlocked"], &empty["plugged"]),
        (&json!([]), &json!(false), &json!(true))
    );
    assert!(empty["drawing"].as_str().unwrap().starts_with("<svg"));
    let held = json!({"held": true});
    assert_eq!(viewer.code("world.unlock", held.clone()).await, -32001);
    let mut anna = bench.join("Anna").await;
    assert_eq!(anna.code("world.unlock", held.clone()).await, -32002);
    anna.lease().await;
    let text = json!({"text": CUBES});
    assert_eq!(anna.code("world.scenario", text.clone()).await, -32001);
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    assert_eq!(teacher.code("world.scenario", text).await, -32002);
    assert!(!bench.arms[0].state().unlocked);
    anna.ok("world.unlock", held).await;
    assert!(bench.arms[0].state().unlocked);
    // A real arm has none.
    let real = Bench::real(1).await;
    let mut anna = real.join("Anna").await;
    for (method, params) in [
        ("world.look", json!({})),
        ("world.press", json!({})),
        ("world.guide", json!({"joints": [0, 45, 45, 0]})),
    ] {
        let refused = anna.call(method, params).await.unwrap_err();
        assert_eq!(refused["data"]["kind"], json!("unsupported"), "{method}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_scenario_puts_objects_there_that_are_placed_and_picked() {
    let bench = Bench::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.ok("arm.subscribe", json!({"rate": 10})).await;
    anna.lease().await;
    anna.ok("arm.speed", json!({"percent": 90})).await;
    anna.ok("arm.move", json!({"to": [200, 0, 50, 0]})).await;
    let bad = json!({"text": "[table]\nheigth = -70"});
    let refused = anna.call("world.scenario", bad).await.unwrap_err();
    assert_eq!(refused["data"]["param"], json!("text"), "{refused}");
    assert!(
        refused["message"].as_str().unwrap().contains("line 2"),
        "{refused}"
    );
    let placed = anna.ok("world.scenario", json!({"text": CUBES})).await;
    assert_eq!(placed, json!({"objects": ["red cube", "blue cube"]}));
    // The arm was switched off and on: its settings are those of power-up, and the events tell.
    let read = anna
        .ok("arm.get", json!({"command": "PTPCommonParams"}))
        .await;
    assert_eq!(read["velocity_ratio"], json!(50.0));
    let events = anna.noticed("arm.event");
    assert!(events.iter().any(|event| event["event"] == json!("reset")));
    anna.listen(Duration::from_millis(300)).await;
    let state = anna.ok("arm.state", json!({})).await;
    assert_eq!(
        (&state["speed"], &state["j2"]),
        (&json!(50.0), &json!(45.0))
    );
    let place = json!({"name": "red cube", "at": [230, -40, 0]});
    anna.ok("world.place", place).await;
    let look = anna.ok("world.look", json!({})).await;
    assert_eq!(
        object(&look, "red cube"),
        &json!({"name": "red cube", "at": [230.0, -40.0, -60.0], "size": [20.0, 20.0, 20.0], "held": false})
    );
    // Onto the other one.
    let place = json!({"name": "red cube", "at": [220, 60, 100]});
    anna.ok("world.place", place).await;
    let look = anna.ok("world.look", json!({})).await;
    assert_eq!(object(&look, "red cube")["at"], json!([220.0, 60.0, -40.0]));
    let place = json!({"name": "ball", "at": [220, 60, 100]});
    let refused = anna.call("world.place", place).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["param"]),
        (&json!(-32602), &json!("name"))
    );
    anna.ok("arm.move", json!({"to": [220, 60, -20, 0], "by": "jump"}))
        .await;
    anna.ok("arm.tool", json!({"suction": true})).await;
    anna.listen(Duration::from_millis(600)).await;
    anna.ok("arm.move", json!({"to": [220, 0, 20, 0]})).await;
    let look = anna.ok("world.look", json!({})).await;
    let cube = object(&look, "red cube");
    assert_eq!(
        (&cube["held"], &cube["at"]),
        (&json!(true), &json!([220.0, 0.0, 0.0])),
        "{cube}"
    );
    // By hand out of the cup.
    let place = json!({"name": "red cube", "at": [220, -60, 0]});
    anna.ok("world.place", place).await;
    let look = anna.ok("world.look", json!({})).await;
    assert_eq!(object(&look, "red cube")["held"], json!(false));
}

#[tokio::test(start_paused = true)]
async fn an_arm_is_guided_while_its_key_is_held_and_homed_by_the_key_at_its_base() {
    let bench = Bench::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let joints = json!({"joints": [20, 30, 40, 10]});
    let refused = anna.call("world.guide", joints.clone()).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("invalid-input"), "{refused}");
    anna.ok("world.unlock", json!({"held": true})).await;
    let state = anna.ok("world.guide", joints).await;
    assert_eq!(
        [&state["j1"], &state["j2"], &state["j3"], &state["j4"]],
        [&json!(20.0), &json!(30.0), &json!(40.0), &json!(10.0)]
    );
    assert_eq!(
        bench.arms[0].state().joints.to_array(),
        [20.0, 30.0, 40.0, 10.0]
    );
    anna.ok("world.unlock", json!({"held": false})).await;
    assert!(!bench.arms[0].state().homed);
    anna.ok("world.press", json!({"long": true})).await;
    for _ in 0..30 {
        anna.listen(Duration::from_secs(1)).await;
        anna.ok("session.list", json!({})).await;
    }
    assert!(bench.arms[0].state().homed);
    // A job has the arm: no hand is at it.
    let steps: Vec<_> = (0..20)
        .map(|at| json!({"move": [220, at, 20, 0]}))
        .collect();
    let plan = json!({"format": "magician-plan", "version": 1, "steps": steps});
    anna.ok("job.start", json!({"text": plan.to_string()}))
        .await;
    assert_eq!(
        anna.code("world.unlock", json!({"held": true})).await,
        -32003
    );
    anna.ok("world.look", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn a_pulled_cable_is_a_lost_line_until_it_is_plugged_in_again() {
    let bench = Bench::new(1).await;
    let (mut anna, mut ben) = (bench.join("Anna").await, bench.join("Ben").await);
    let links = |viewer: &Tester| {
        let states = viewer.noticed("arm.state").into_iter();
        let links = states.filter_map(|seen| seen["state"]["link"].as_str());
        links.map(str::to_owned).collect::<Vec<_>>()
    };
    anna.lease().await;
    ben.ok("arm.subscribe", json!({"rate": 20})).await;
    anna.send("arm.move", json!({"to": [220, 60, 20, 0]}));
    ben.listen(Duration::from_millis(200)).await;
    anna.ok("world.unplug", json!({"plugged": false})).await;
    ben.listen(Duration::from_secs(1)).await;
    assert_eq!(links(&ben), ["up", "lost"]);
    for refused in ["arm.state", "arm.info"] {
        let refused = ben.call(refused, json!({})).await.unwrap_err();
        assert_eq!(refused["data"]["kind"], json!("port"), "{refused}");
    }
    let look = ben.ok("world.look", json!({})).await;
    assert_eq!(look["plugged"], json!(false));
    anna.ok("world.unplug", json!({"plugged": true})).await;
    ben.listen(Duration::from_secs(3)).await;
    assert_eq!(links(&ben).last().map(String::as_str), Some("up"));
    anna.ok("arm.move", json!({"to": [220, 0, 20, 0]})).await;
    assert!((bench.arms[0].state().pose.x - 220.0).abs() < 1e-3);
}

#[tokio::test(start_paused = true)]
async fn a_page_can_draw_the_arm_by_its_links() {
    let bench = Bench::new(1).await;
    let mut anna = bench.join("Anna").await;
    let model = anna.ok("arm.model", json!({})).await;
    assert_eq!(model["frame"], json!("shoulder"));
    let limits = json!({
        "j1": [-135.0, 135.0], "j2": [-5.0, 90.0], "j3": [-15.0, 90.0], "j4": [-150.0, 150.0],
        "j2_minus_j3": [-70.0, 55.0], "l": null,
    });
    assert_eq!(model["limits"], limits);
    assert_eq!(
        model["tool"],
        json!({"name": "suction", "bias": [59.7, 0.0, 0.0]})
    );
    let links = model["links"].as_array().unwrap();
    let rear = links.iter().find(|link| link["name"] == json!("rear_arm"));
    let rear = rear.unwrap();
    assert_eq!(
        (&rear["joint"], &rear["parent"], &rear["axis"]),
        (&json!("j2"), &json!("turret"), &json!([0.0, 1.0, 0.0]))
    );
    let tool = links.last().unwrap();
    assert_eq!(
        (&tool["joint"], &tool["at"]),
        (&json!("j4"), &json!([59.7, 0.0, 0.0]))
    );
    anna.lease().await;
    let rail = json!({"command": "DeviceWithL", "fields": {"with_l": true, "version": 1}});
    anna.ok("arm.set", rail).await;
    let model = anna.ok("arm.model", json!({})).await;
    assert_eq!(model["limits"]["l"], json!([0.0, 1000.0]));
    assert_eq!(model["links"][0]["joint"], json!("l"));
}
