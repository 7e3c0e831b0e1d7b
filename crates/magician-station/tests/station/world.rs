//! World of a virtual arm, and its geometry.

use std::time::Duration;

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

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
async fn holder_changes_the_world_and_teacher_the_scenario() {
    let bench = LocalStation::new(1).await;
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
    // A real arm has no world.
    let real = LocalStation::real(1).await;
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
async fn scenario_objects_can_be_placed_and_picked() {
    let bench = LocalStation::new(1).await;
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
    // The arm was switched off and on: settings are those of power-up, and events say so.
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
        &json!({"name": "red cube", "at": [230.0, -40.0, -60.0], "turn": 0.0, "size": [20.0, 20.0, 20.0], "color": "#808080", "held": false})
    );
    // Onto the other cube.
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
    // Taken out of the suction cup by hand.
    let place = json!({"name": "red cube", "at": [220, -60, 0]});
    anna.ok("world.place", place).await;
    let look = anna.ok("world.look", json!({})).await;
    assert_eq!(object(&look, "red cube")["held"], json!(false));
}

/// Returns the codes of the notes of a job with these steps.
async fn notes_of(tester: &mut Tester, steps: Value) -> Vec<Value> {
    let plan = json!({
        "format": "magician-plan", "version": 1, "title": "pick", "tool": "suction", "steps": steps,
    });
    let job = json!({"text": plan.to_string()});
    let id = tester.ok("job.start", job).await["job"].clone();
    loop {
        let job = tester.ok("job.get", json!({"job": id})).await;
        if job["ended"] != json!(null) {
            assert_eq!(job["state"], json!("done"), "{job}");
            let notes = job["notes"].as_array().cloned().unwrap_or_default();
            return notes.into_iter().map(|note| note["code"].clone()).collect();
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

#[tokio::test(start_paused = true)]
async fn job_that_picks_nothing_has_a_note_unless_it_waits_for_vacuum() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.lease().await;
    anna.ok("world.scenario", json!({"text": CUBES})).await;
    anna.ok("arm.home", json!({})).await;
    let (above, on) = (
        json!({"move": [220, 0, 20, 0]}),
        json!({"move": [220, 0, -40, 0]}),
    );
    let (suck, blow) = (json!({"suction": true}), json!({"suction": false}));
    let hasty = json!([above, on, suck, above, blow]);
    assert!(
        notes_of(&mut anna, hasty)
            .await
            .contains(&json!("nothing-picked"))
    );
    let beside = json!([{"move": [220, -60, -40, 0]}, suck, {"wait": 0.5}, above, blow]);
    assert!(
        notes_of(&mut anna, beside)
            .await
            .contains(&json!("nothing-picked"))
    );
    let patient = json!([above, on, suck, {"wait": 0.5}, above, on, blow, {"wait": 0.5}]);
    let notes = notes_of(&mut anna, patient).await;
    assert!(!notes.contains(&json!("nothing-picked")), "{notes:?}");
}

#[tokio::test(start_paused = true)]
async fn arm_is_guided_with_the_unlock_key_and_homed_by_the_base_key() {
    let bench = LocalStation::new(1).await;
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
    // A job has the arm, so no hand may act on it.
    anna.begin_job().await;
    assert_eq!(
        anna.code("world.unlock", json!({"held": true})).await,
        -32003
    );
    anna.ok("world.look", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn pulled_cable_is_a_lost_line_until_plugged_in() {
    let bench = LocalStation::new(1).await;
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
async fn arm_model_has_the_links_for_drawing() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let model = anna.ok("arm.model", json!({})).await;
    assert_eq!(model["frame"], json!("shoulder"));
    let limits = json!({
        "j1": [-135.0, 135.0], "j2": [-13.5, 90.0], "j3": [-15.0, 90.0], "j4": [-150.0, 150.0],
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

#[tokio::test(start_paused = true)]
async fn built_in_scenarios_are_listed_and_start() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.lease().await;
    let told = anna.ok("world.scenarios", json!({})).await;
    let told = told["scenarios"].as_array().unwrap();
    assert_eq!(told[0]["name"], json!("cubes"));
    for scenario in told {
        let text = json!({"text": scenario["text"]});
        anna.ok("world.scenario", text).await;
        let look = anna.ok("world.look", json!({})).await;
        assert_eq!(look["title"], scenario["title"]);
        assert!(look["table"]["height"].is_number());
    }
    anna.ok("world.scenario", json!({"text": told[0]["text"]}))
        .await;
    let look = anna.ok("world.look", json!({})).await;
    assert_eq!(object(&look, "red cube")["color"], json!("#ff0000"));
    assert_eq!(look["belt"], Value::Null);
}

#[tokio::test(start_paused = true)]
async fn drawing_is_resent_only_after_a_change() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    anna.lease().await;
    let paper = json!({"text": "tool = { kind = \"pen\" }\ntable = { height = -60 }"});
    anna.ok("world.scenario", paper).await;
    let blank = anna.ok("world.look", json!({})).await;
    assert_eq!(
        (&blank["strokes"], &blank["mark"]),
        (&json!([]), &json!(""))
    );
    for to in [[220.0, 0.0, -60.0, 0.0], [240.0, 10.0, -60.0, 0.0]] {
        anna.ok("arm.move", json!({"to": to, "by": "linear"})).await;
    }
    let seen = anna.ok("world.look", json!({"mark": ""})).await;
    let stroke = seen["strokes"][0]["points"].as_array().unwrap();
    let (first, last) = (&stroke[0], &stroke[stroke.len() - 1]);
    assert_eq!(
        (first, last, &seen["strokes"][0]["burnt"]),
        (&json!([220.02, 0.0]), &json!([240.0, 10.0]), &json!(false))
    );
    assert!(seen["drawing"].as_str().unwrap().contains("<path"));
    let mark = json!({"mark": seen["mark"]});
    let same = anna.ok("world.look", mark.clone()).await;
    assert_eq!(
        (&same["drawing"], &same["strokes"], &same["mark"]),
        (&Value::Null, &Value::Null, &seen["mark"])
    );
    let further = json!({"to": [240, -10, -60, 0], "by": "linear"});
    anna.ok("arm.move", further).await;
    assert!(anna.ok("world.look", mark).await["strokes"].is_array());
    anna.ok("world.paper", json!({})).await;
    let fresh = anna.ok("world.look", json!({"mark": seen["mark"]})).await;
    assert_eq!(fresh["strokes"], json!([]));
}

#[tokio::test(start_paused = true)]
async fn faults_can_be_injected_during_a_job() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let alarm = json!({"fault": "alarm", "alarm": 0x40});
    anna.ok("world.fault", alarm).await;
    let alarms = anna.ok("arm.alarms", json!({})).await;
    let mut alarms = alarms["alarms"].as_array().unwrap().iter();
    assert!(alarms.any(|alarm| alarm["code"] == json!(0x40)));
    anna.ok("arm.clear_alarms", json!({})).await;
    anna.begin_job().await;
    let slip = json!({"fault": "slip", "joint": 1, "degrees": 5});
    anna.ok("world.fault", slip).await;
    let state = bench.arms[0].state();
    let apart = state.true_joints.to_array()[0] - state.joints.to_array()[0];
    assert!((apart - 5.0).abs() < 1e-6, "{apart}");
    let press = anna.code("world.press", json!({})).await;
    assert_eq!(press, -32003);
    assert_eq!(anna.code("world.paper", json!({})).await, -32003);
}

#[tokio::test(start_paused = true)]
async fn pins_follow_the_protocol_table_and_external_inputs() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let io = anna.ok("arm.io", json!({})).await;
    let row = |role: &str| {
        let mut rows = io["rows"].as_array().unwrap().iter();
        rows.find(|row| row["role"] == json!(role)).unwrap().clone()
    };
    let function = row("function");
    assert_eq!(function["sets"][0]["most"], json!(20));
    assert_eq!(row("sensor")["tells"][0]["unit"], json!("counts"));
    let analog = io["functions"][4].clone();
    assert_eq!(
        (&analog["watch"], &analog["value"]),
        (&json!("analog"), &json!(4))
    );
    let able = |pin: usize| io["pins"][pin - 1]["can"].clone();
    assert_eq!(
        (able(1), able(5)),
        (json!([0, 1, 3, 4, 5, 6]), json!([0, 3, 5, 6]))
    );
    let fields = json!({"address": 9, "multiplex": 4});
    let set = json!({"command": function["command"], "fields": fields});
    anna.ok("arm.set", set).await;
    anna.ok("world.input", json!({"address": 9, "value": 2048}))
        .await;
    let io = anna.ok("arm.io", json!({})).await;
    assert_eq!(io["pins"][8]["function"], json!(4));
    let pins = json!([{"kind": "analog", "address": 9}]);
    anna.ok("arm.subscribe", json!({"rate": 20, "pins": pins}))
        .await;
    anna.listen(Duration::from_millis(500)).await;
    let seen = anna.noticed("arm.state");
    let mut values = seen.iter().map(|seen| &seen["state"]["pins"][0]["value"]);
    assert!(values.any(|value| *value == json!(2048)), "{seen:?}");
    let both = json!({"address": 9, "value": 1, "level": true});
    assert_eq!(anna.code("world.input", both).await, -32602);
}

#[tokio::test(start_paused = true)]
async fn world_report_names_the_drawing_tool() {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let look = teacher.ok("world.look", json!({})).await;
    assert_eq!(look["draws"], json!(null));
    let table = "[table]\nheight = -60\n";
    for (tool, around, draws) in [
        ("pen", table, json!("pen")),
        ("pen", "", json!(null)),
        ("laser", "", json!("laser")),
        ("suction", table, json!(null)),
    ] {
        let text = format!("[tool]\nkind = \"{tool}\"\n{around}");
        teacher.ok("world.scenario", json!({"text": text})).await;
        let look = teacher.ok("world.look", json!({})).await;
        assert_eq!(look["draws"], draws, "{text}");
    }
}
