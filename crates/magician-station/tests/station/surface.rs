//! Height of the work surface, measured by touching it, and the remedies in errors.

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

const LINE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' viewBox='0 0 20 20'>\
    <path d='M2 5 L18 5' fill='none' stroke='black'/></svg>";

/// Returns the height at which a drawing is placed.
async fn height(tester: &mut Tester) -> f64 {
    let job = json!({"text": LINE, "setup": {"work": "draw"}, "preview": true});
    let report = tester.ok("job.check", job).await;
    report["preview"]["strokes"][0]["height"].as_f64().unwrap()
}

/// Returns the code of the arm's error.
fn code(error: &Value) -> &str {
    error["data"]["code"].as_str().unwrap_or_default()
}

#[tokio::test(start_paused = true)]
async fn touched_height_is_used_for_drawings_until_forgotten() {
    let bench = LocalStation::new(2).await;
    let mut anna = bench.join("Anna").await;
    let arm = |arm: &str| json!({"arm": arm});
    anna.ok("lease.acquire", arm("arm1")).await;
    let unknown = json!({
        "touches": 0, "plane": null, "residual": null, "corners": [], "sheet": null,
    });
    assert_eq!(anna.ok("surface.get", arm("arm1")).await, unknown);
    let to = json!({"arm": "arm1", "to": [220, 30, -52.5, 0]});
    anna.ok("arm.move", to).await;
    let touched = anna.ok("surface.touch", arm("arm1")).await;
    let plane = json!({"at": [220.0, 30.0], "z": -52.5, "slope_x": 0.0, "slope_y": 0.0});
    assert_eq!(
        touched,
        json!({"touches": 1, "plane": plane, "residual": 0.0, "corners": [], "sheet": null})
    );
    let known = anna.ok("surface.get", arm("arm1")).await;
    assert_eq!(known["plane"]["z"], json!(-52.5));
    // The other arm stands at another table.
    assert_eq!(anna.ok("surface.get", arm("arm2")).await, unknown);
    let laid =
        |arm: &str| json!({"arm": arm, "text": LINE, "setup": {"work": "draw"}, "preview": true});
    for (name, height) in [("arm1", -52.5), ("arm2", -60.0)] {
        let report = anna.ok("job.check", laid(name)).await;
        let laid = report["preview"]["strokes"][0]["height"].as_f64().unwrap();
        assert!((laid - height).abs() < 1e-3_f64, "{laid}");
    }
    let forget = json!({"arm": "arm1", "forget": true});
    assert_eq!(anna.ok("surface.touch", forget).await, unknown);
    let report = anna.ok("job.check", laid("arm1")).await;
    assert_eq!(report["preview"]["strokes"][0]["height"], json!(-60.0));
}

#[tokio::test(start_paused = true)]
async fn several_touches_fit_a_tilted_plane() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("lease.acquire", json!({})).await;
    let mut touch = async |[x, y, z]: [f64; 3]| {
        let to = json!({"to": [x, y, z, 0]});
        anna.ok("arm.move", to).await;
        anna.call("surface.touch", json!({"add": true})).await
    };
    // The table rises by 1 in 100 along x.
    let at = |x: f64, y: f64| [x, y, -52.0 + (x - 200.0) / 100.0];
    for (nth, place) in [at(200.0, -60.0), at(200.0, 60.0), at(260.0, 0.0)]
        .into_iter()
        .enumerate()
    {
        let known = touch(place).await.unwrap();
        assert_eq!(known["touches"], json!(nth + 1));
    }
    let known = touch(at(230.0, 0.0)).await.unwrap();
    assert_eq!(known["touches"], json!(4));
    let slope = known["plane"]["slope_x"].as_f64().unwrap();
    assert!((slope - 0.01).abs() < 1e-4, "{known}");
    assert!(known["residual"].as_f64().unwrap() < 0.01, "{known}");
    // A single touch starts a new measurement. Three in line are refused, and the surface stays.
    let alone = anna.ok("surface.touch", json!({})).await;
    assert_eq!(alone["touches"], json!(1));
    let mut touch = async |[x, y, z]: [f64; 3]| {
        let to = json!({"to": [x, y, z, 0]});
        anna.ok("arm.move", to).await;
        anna.call("surface.touch", json!({"add": true})).await
    };
    touch(at(200.0, 0.0)).await.unwrap();
    let refused = touch(at(260.0, 0.0)).await.unwrap_err();
    let why = refused["message"].as_str().unwrap();
    assert!(why.contains("nearly in line"), "{why}");
    let known = anna.ok("surface.get", json!({})).await;
    assert_eq!(known["touches"], json!(2));
}

#[tokio::test(start_paused = true)]
async fn three_corners_define_an_upright_sheet() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("lease.acquire", json!({})).await;
    anna.ok("arm.tool", json!({"tool": "pen"})).await;
    let wrong = json!({"corner": "middle"});
    assert_eq!(anna.code("surface.corner", wrong).await, -32602);
    let corners = [
        ("lower-left", [280.0, -70.0]),
        ("lower-right", [280.0, 70.0]),
        ("upper-left", [200.0, -70.0]),
    ];
    for (nth, (corner, [x, y])) in corners.into_iter().enumerate() {
        let to = json!({"to": [x, y, -52.5, 0]});
        anna.ok("arm.move", to).await;
        let known = anna.ok("surface.corner", json!({"corner": corner})).await;
        if nth == 0 {
            assert_eq!(known["corners"], json!(["lower-left"]));
            assert_eq!(known["sheet"], json!(null));
            // Touching the same place again does not give another corner.
            let again = json!({"corner": "lower-right"});
            let refused = anna.call("surface.corner", again).await.unwrap_err();
            let why = refused["message"].as_str().unwrap();
            assert!(why.contains("0.0 mm from"), "{why}");
        }
    }
    let known = anna.ok("surface.get", json!({})).await;
    assert_eq!(known["corners"], json!([]));
    let sheet = &known["sheet"];
    let near = |value: &Value, wanted: f64| {
        let value = value.as_f64().unwrap();
        assert!(
            (value - wanted).abs() < 0.05,
            "{value} is not {wanted} in {known}"
        );
    };
    near(&sheet["rotation"], 90.0);
    near(&sheet["size"][0], 140.0);
    near(&sheet["size"][1], 80.0);
    near(&known["plane"]["z"], -52.5);
    // A drawing lies on it: the top of the file points towards the arm.
    let job = json!({"text": LINE, "setup": {"work": "draw"}, "preview": true});
    let report = anna.ok("job.check", job).await;
    let stroke = &report["preview"]["strokes"][0];
    near(&stroke["height"], -52.5);
    let points = stroke["points"].as_array().unwrap();
    let [one, other] = [&points[0], &points[points.len() - 1]];
    near(
        &json!(other[1].as_f64().unwrap() - one[1].as_f64().unwrap()),
        16.0,
    );
    near(
        &json!(other[0].as_f64().unwrap() - one[0].as_f64().unwrap()),
        0.0,
    );
    // A touch is refused while a sheet is known. One request forgets both.
    let touched = anna.call("surface.touch", json!({})).await.unwrap_err();
    assert!(
        touched["message"].as_str().unwrap().contains("sheet"),
        "{touched}"
    );
    let forgotten = anna.ok("surface.touch", json!({"forget": true})).await;
    assert_eq!(
        (&forgotten["sheet"], &forgotten["touches"]),
        (&json!(null), &json!(0))
    );
}

#[tokio::test(start_paused = true)]
async fn touch_needs_lease_rest_laser_off_and_equal_tool_height() {
    let bench = LocalStation::new(1).await;
    let mut eve = bench.join_as("Eve", Role::Viewer).await;
    assert_eq!(eve.code("surface.touch", json!({})).await, -32001);
    let mut anna = bench.join("Anna").await;
    assert_eq!(anna.code("surface.touch", json!({})).await, -32002);
    anna.ok("lease.acquire", json!({})).await;
    let before = height(&mut anna).await;

    let jog = anna.ok("jog.start", json!({"axis": "z+"})).await;
    assert_eq!(anna.code("surface.touch", json!({})).await, -32003);
    anna.ok("jog.stop", json!({"jog": jog["jog"]})).await;

    let away = json!({"to": [200, 120, 40, 0], "wait": false});
    anna.ok("arm.move", away).await;
    let moving = anna.call("surface.touch", json!({})).await.unwrap_err();
    assert_eq!(code(&moving), "busy", "{moving}");
    anna.ok("arm.stop", json!({})).await;

    anna.ok("arm.tool", json!({"laser": {"on": true}})).await;
    let lit = anna.call("surface.touch", json!({})).await.unwrap_err();
    assert_eq!(code(&lit), "laser-on", "{lit}");
    let remedy = json!([{"action": "laser-off", "effect": "switches it off"}]);
    assert_eq!(lit["data"]["remedies"], remedy);
    anna.ok("arm.tool", json!({"laser": {"on": false}})).await;

    anna.ok("arm.tool", json!({"tool": [61, 0, -20]})).await;
    let longer = anna.call("surface.touch", json!({})).await.unwrap_err();
    assert_eq!(code(&longer), "invalid-value", "{longer}");
    assert_eq!(height(&mut anna).await, before);
    anna.ok("arm.tool", json!({"tool": "suction"})).await;
    anna.ok("surface.touch", json!({})).await;

    let job = json!({"text": LINE, "setup": {"work": "draw", "surface": -40}});
    anna.ok("job.start", job).await;
    assert_eq!(anna.code("surface.touch", json!({})).await, -32003);
}

#[tokio::test(start_paused = true)]
async fn touch_works_after_an_unawaited_move_and_a_jog() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("lease.acquire", json!({})).await;
    let away = json!({"to": [200, 20, 40, 0], "wait": false});
    anna.ok("arm.move", away).await;
    let enough = std::time::Duration::from_secs(4);
    tokio::time::sleep(enough).await;
    anna.ok("surface.touch", json!({})).await;
    let jog = anna.ok("jog.start", json!({"axis": "z+"})).await;
    anna.ok("jog.stop", json!({"jog": jog["jog"]})).await;
    tokio::time::sleep(enough).await;
    anna.ok("surface.touch", json!({})).await;
}

#[tokio::test(start_paused = true)]
async fn arm_error_includes_the_commands_remedy() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("lease.acquire", json!({})).await;
    anna.ok("arm.tool", json!({"laser": {"on": true}})).await;
    let away = json!({"to": [200, 20, 40, 0]});
    let refused = anna.call("arm.move", away).await.unwrap_err();
    assert_eq!(code(&refused), "laser-on");
    assert_eq!(refused["data"]["remedies"][0]["action"], json!("laser-off"));
    // The error of a job has remedies as well.
    let job = json!({"text": LINE, "setup": {"work": "draw"}, "after_check": false});
    let id = anna.ok("job.start", job).await["job"].clone();
    let job = loop {
        let job = anna.ok("job.get", json!({"job": id})).await;
        if job["state"] != "checking" {
            break job;
        }
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    };
    assert_eq!(
        job["error"]["remedies"][0]["action"],
        json!("laser-off"),
        "{job}"
    );
}

#[tokio::test(start_paused = true)]
async fn surface_change_is_notified_once_to_every_session() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut ben = bench.join_as("Ben", Role::Viewer).await;
    anna.ok("lease.acquire", json!({})).await;
    let mut told = 0;
    let at = |x: f64, y: f64| ("arm.move", json!({"to": [x, y, -52.5, 0]}));
    let corner = |name: &str| ("surface.corner", json!({"corner": name}));
    for (method, params) in [
        at(220.0, 30.0),
        ("surface.touch", json!({})),
        // The same place again changes nothing.
        ("surface.touch", json!({})),
        at(260.0, -30.0),
        ("surface.touch", json!({"add": true})),
        ("surface.touch", json!({"forget": true})),
        ("arm.tool", json!({"tool": "pen"})),
        at(280.0, -70.0),
        corner("lower-left"),
        at(280.0, 70.0),
        corner("lower-right"),
        at(200.0, -70.0),
        corner("upper-left"),
        ("surface.touch", json!({"forget": true})),
    ] {
        let before = anna.ok("surface.get", json!({})).await;
        anna.ok(method, params.clone()).await;
        let after = anna.ok("surface.get", json!({})).await;
        ben.listen(std::time::Duration::from_millis(10)).await;
        let notices = ben.noticed("surface.changed");
        let news = usize::from(before != after);
        assert_eq!(notices.len(), told + news, "{method} {params}");
        told = notices.len();
        if news > 0 {
            let shown = json!({"arm": "arm", "surface": after});
            assert_eq!(**notices.last().unwrap(), shown, "{method} {params}");
        }
    }
    assert_eq!(told, 7);
    assert_eq!(anna.noticed("surface.changed").len(), told);
}
