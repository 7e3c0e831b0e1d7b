//! Methods that need the lease: moves, settings, tools; and the roles for them.

use magician_program::{Action, Plan, Travel};
use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::LocalStation;

#[tokio::test(start_paused = true)]
async fn move_needs_the_lease_and_is_answered_on_arrival() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let to = json!({"to": [220, 0, 50, 0]});
    let refused = anna.call("arm.move", to.clone()).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["holder"]),
        (&json!(-32002), &json!(null))
    );
    assert!(!bench.arms[0].state().moving);
    anna.lease().await;
    let state = anna.ok("arm.move", to).await;
    assert_eq!((&state["x"], &state["z"]), (&json!(220.0), &json!(50.0)));
    assert_eq!(state["holder"]["name"], json!("Anna"));
    assert_eq!(state["moving"], json!(false));
    bench.station.flush().await;
    let lines = bench.lines.lock().unwrap();
    let told: Vec<_> = lines
        .iter()
        .map(|line| (line.method.as_str(), line.result.as_str()))
        .collect();
    assert_eq!(
        told,
        [
            ("session.hello", "ok"),
            ("arm.move", "lease"),
            ("lease.acquire", "ok"),
            ("arm.move", "ok")
        ]
    );
}

#[tokio::test(start_paused = true)]
async fn unreachable_move_is_refused_before_sending() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let before = bench.arms[0].state().pose;
    let refused = anna
        .call("arm.move", json!({"to": [600, 0, 50, 0]}))
        .await
        .unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["kind"]),
        (&json!(-32000), &json!("unreachable"))
    );
    let refused = anna
        .call("arm.move", json!({"to": [600, 0, 50, 0], "wait": false}))
        .await
        .unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unreachable"));
    assert_eq!(bench.arms[0].state().pose, before);
}

#[tokio::test(start_paused = true)]
async fn commands_and_readings_match_the_protocol_table() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let fields = json!({"velocity_ratio": 80, "acceleration_ratio": 60.5});
    let set = json!({"command": "PTPCommonParams", "fields": fields});
    assert_eq!(anna.ok("arm.set", set).await, json!(null));
    let read = anna
        .ok("arm.get", json!({"command": "PTPCommonParams"}))
        .await;
    assert_eq!(
        read,
        json!({"velocity_ratio": 80.0, "acceleration_ratio": 60.5})
    );
    let read = anna
        .ok(
            "arm.get",
            json!({"command": "IODO", "query": {"address": 4}}),
        )
        .await;
    assert_eq!(read["address"], json!(4));
    let fields = json!({"ptp_mode": "movl-xyz", "x": 220, "y": 40, "z": 30, "r": 0});
    let queued = anna
        .ok(
            "arm.enqueue",
            json!({"command": "PTPCmd", "fields": fields}),
        )
        .await;
    assert_eq!(queued, json!({"index": 2}));
    for (params, param) in [
        (json!({"command": "Nonsense"}), "command"),
        (json!({"command": "PTPCmd", "fields": {"x": 1}}), "fields"),
        (
            json!({"command": "PTPCmd", "fields": {"weight": 1}}),
            "fields",
        ),
        (json!({"command": "GetPose", "fields": 3}), "fields"),
    ] {
        let refused = anna.call("arm.enqueue", params.clone()).await.unwrap_err();
        assert_eq!(
            (&refused["code"], &refused["data"]["param"]),
            (&json!(-32602), &json!(param)),
            "{params}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn real_laser_needs_a_teacher_and_confirmation() {
    let bench = LocalStation::real(1).await;
    let laser = json!({"laser": {"on": true}});
    let mut pupil = bench.join("Pupil").await;
    let lease = pupil.lease().await;
    assert_eq!(pupil.code("arm.tool", laser.clone()).await, -32001);
    let yes = json!({"laser": {"on": true}, "yes": true});
    assert_eq!(pupil.code("arm.tool", yes.clone()).await, -32001);
    pupil.ok("lease.release", json!({"lease": lease})).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let refused = teacher.call("arm.tool", laser).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["command"]),
        (&json!(-32005), &json!("SetEndEffectorLaser"))
    );
    assert_eq!(refused["data"]["danger"], json!("laser"));
    let burn = json!({"command": "CPLECmd", "fields": {"cp_mode": 1, "x": 230, "y": 0, "z": 0, "velocity_or_power": 40}});
    assert_eq!(teacher.code("arm.enqueue", burn).await, -32005);
    assert!(!bench.arms[0].state().laser);
    let state = teacher.ok("arm.tool", yes).await;
    assert_eq!(state["tool"]["laser"], json!(true));
    let state = teacher
        .ok("arm.tool", json!({"laser": {"on": false}}))
        .await;
    assert_eq!(state["tool"]["laser"], json!(false));
}

#[tokio::test(start_paused = true)]
async fn dangerous_command_needs_a_teacher_and_confirmation() {
    let bench = LocalStation::new(1).await;
    let reset = json!({"command": "ResetPose", "fields": {"manual": 0, "rear_arm_angle": 0, "front_arm_angle": 0}});
    let mut pupil = bench.join("Pupil").await;
    let refused = pupil.call("arm.set", reset.clone()).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["needs"]),
        (&json!(-32001), &json!("teacher"))
    );
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    let refused = teacher.call("arm.set", reset).await.unwrap_err();
    assert_eq!(
        (&refused["code"], &refused["data"]["danger"]),
        (&json!(-32005), &json!("arm"))
    );
}

#[tokio::test(start_paused = true)]
async fn storing_in_flash_needs_a_teacher_and_confirmation() {
    let bench = LocalStation::new(1).await;
    let store = json!({"command": "QueuedCmdStartDownload", "fields": {"total_loop": 1, "line_per_loop": 1}});
    let mut pupil = bench.join("Pupil").await;
    assert_eq!(pupil.code("arm.set", store.clone()).await, -32001);
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    let refused = teacher.call("arm.set", store.clone()).await.unwrap_err();
    assert_eq!(refused["code"], json!(-32005));
    let said = refused["message"].as_str().unwrap();
    assert!(said.contains("to the arm's flash"), "{said}");
    teacher.lease().await;
    let mut meant = store;
    meant["yes"] = json!(true);
    teacher.ok("arm.set", meant).await;
}

#[tokio::test(start_paused = true)]
async fn power_out_of_range_is_refused_with_value_and_range() {
    let bench = LocalStation::new(1).await;
    let mut teacher = bench.join_as("Teacher", Role::Teacher).await;
    teacher.lease().await;
    let burn = json!({"cp_mode": 1, "x": 220, "y": 0, "z": 20, "velocity_or_power": -1});
    let pulses = json!({"address": 4, "frequency": 100, "duty_cycle": 101});
    for (method, command, fields, said) in [
        (
            "arm.enqueue",
            "CPLECmd",
            &burn,
            "velocity_or_power -1 % is out of range: 0 to 100 %",
        ),
        (
            "arm.set",
            "IOPWM",
            &pulses,
            "duty_cycle 101 % is out of range: 0 to 100 %",
        ),
        (
            "arm.enqueue",
            "IOPWM",
            &pulses,
            "duty_cycle 101 % is out of range: 0 to 100 %",
        ),
    ] {
        let params = json!({"command": command, "fields": fields, "yes": true});
        let refused = teacher.call(method, params).await.unwrap_err();
        assert_eq!(refused["data"]["kind"], json!("invalid-input"), "{refused}");
        assert!(
            refused["message"].as_str().unwrap().contains(said),
            "{refused}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn viewer_may_read_and_stop_only() {
    let bench = LocalStation::new(1).await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    for method in [
        "arm.state",
        "arm.info",
        "arm.alarms",
        "arm.list",
        "session.list",
        "server.info",
    ] {
        viewer.ok(method, json!({})).await;
    }
    assert_eq!(viewer.code("lease.acquire", json!({})).await, -32001);
    assert_eq!(viewer.code("arm.home", json!({})).await, -32001);
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    let moving = anna.send("arm.move", json!({"to": [200, 150, 50, 0], "by": "linear"}));
    viewer.listen(std::time::Duration::from_millis(300)).await;
    let stood = viewer.ok("arm.stop", json!({})).await;
    assert_eq!(stood["arms"][0]["stood"], json!(true));
    assert_eq!(stood["arms"][0]["arm"], json!("arm"));
    let ended = anna.answer(moving).await.unwrap_err();
    assert_eq!(ended["code"], json!(-32007));
    let by = ended["data"]["by"].as_str().unwrap().to_owned();
    let sessions = viewer.ok("session.list", json!({})).await;
    assert_eq!(sessions["sessions"][0]["session"], json!(by));
    assert!(!bench.arms[0].state().moving);
    // The lease is kept, and the arm moves again.
    anna.ok("arm.move", json!({"to": [220, 0, 50, 0]})).await;
}

#[tokio::test(start_paused = true)]
async fn capture_returns_the_pose_as_a_step() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [220, 10, 50, 0]})).await;
    for (by, travel) in [
        (json!({}), Travel::Joints),
        (json!({"by": "linear"}), Travel::Line),
        (json!({"by": "jump"}), Travel::Jump),
    ] {
        let step = anna.ok("teach.capture", by).await["step"].clone();
        let file = json!({"format": "magician-plan", "version": 1, "steps": [step]});
        let plan = Plan::from_json(file.to_string().as_bytes()).unwrap();
        let Action::Move { to, by } = &plan.steps[0].action else {
            panic!("{:?}", plan.steps[0].action);
        };
        assert_eq!((&to[..3], *by), (&[220.0, 10.0, 50.0][..], travel));
    }
}

#[tokio::test(start_paused = true)]
async fn kinematics_work_without_an_arm() {
    let bench = LocalStation::new(2).await;
    let mut viewer = bench.join_as("Viewer", Role::Viewer).await;
    let pose = json!({"pose": [220, 10, 50, 5], "tool": "pen"});
    let joints = viewer.ok("motion.inverse", pose).await;
    let joints: Vec<_> = joints.as_object().unwrap().values().collect();
    let pose = json!({"joints": joints, "tool": "pen"});
    let back = viewer.ok("motion.forward", pose).await;
    for (name, value) in [("x", 220.0), ("y", 10.0), ("z", 50.0), ("r", 5.0)] {
        let apart = back[name].as_f64().unwrap() - value;
        assert!(apart.abs() < 1e-9, "{name}: {back}");
    }
    let far = json!({"pose": [600, 0, 0, 0]});
    let refused = viewer.call("motion.inverse", far).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("unreachable"));
    let reach = viewer.ok("motion.reach", json!({"z": 0})).await;
    let outline = reach["outlines"][0].as_array().unwrap();
    assert!(outline.len() > 100);
    let far = |point: &Value| point[0].as_f64().unwrap().hypot(point[1].as_f64().unwrap());
    assert!(outline.iter().all(|point| far(point) < 400.0));
}
