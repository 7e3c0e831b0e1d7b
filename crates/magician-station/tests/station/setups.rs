//! Programs with options: `setup`, previews, and G-code that starts where the arm stands.

use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};
use crate::jobs::until;

/// Square of 20 mm.
const SQUARE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm' viewBox='0 0 40 40'>\
    <rect x='10' y='10' width='20' height='20' fill='none' stroke='black'/></svg>";

/// Lines relative to the tool's position.
const RELATIVE: &str = "G21\nG91\nG1 X10 F1200\nG1 Y15\nG1 X-10\nG1 Y-15\n";

async fn checked(tester: &mut Tester, setup: Value) -> Value {
    let params = json!({"text": SQUARE, "setup": setup});
    tester.ok("job.check", params).await
}

fn middle(report: &Value) -> [f64; 2] {
    let at = |axis: &str, end: usize| report["bounds"][axis][end].as_f64().unwrap();
    ["x", "y"].map(|axis| f64::midpoint(at(axis, 0), at(axis, 1)))
}

#[tokio::test(start_paused = true)]
async fn setup_places_and_configures_a_drawing() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let plain = anna.ok("job.check", json!({"text": SQUARE})).await;
    assert_eq!(plain["ok"], json!(true), "{plain}");
    let there = checked(&mut anna, json!({"at": [220, 30], "scale": 2})).await;
    let [x, y] = middle(&there);
    assert!((x - 220.0).abs() < 0.1 && (y - 30.0).abs() < 0.1, "{there}");
    let drawn = |report: &Value| report["drawn_mm"].as_f64().unwrap();
    assert!((drawn(&there) - 2.0 * drawn(&plain)).abs() < 1.0);
    assert_eq!(there["placed"]["scale"], json!(2.0));
    // The kind of work is the given one, or follows from the tool.
    for (setup, burns) in [
        (json!({}), false),
        (json!({"tool": "laser"}), true),
        (json!({"work": "engrave"}), true),
        (json!({"work": "draw", "tool": "laser"}), false),
    ] {
        let report = checked(&mut anna, setup.clone()).await;
        assert_eq!(report.get("power").is_some(), burns, "{setup} {report}");
    }
    let powered = checked(&mut anna, json!({"work": "engrave", "power": "10..60"})).await;
    assert_eq!(powered["power"]["most"], json!(60.0), "{powered}");
    let grid = checked(&mut anna, json!({"at": [200, 0], "grid": "2x2:30x30"})).await;
    assert!((drawn(&grid) - 4.0 * drawn(&plain)).abs() < 1.0, "{grid}");
}

/// Circle in an icon of 24 pixels.
const ICON: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='24' height='24' viewBox='0 0 24 24'>\
    <circle cx='12' cy='12' r='11' fill='none' stroke='black'/></svg>";

#[tokio::test(start_paused = true)]
async fn icon_circle_is_smooth_at_its_scaled_size() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for work in ["draw", "engrave"] {
        for width in [10.0, 80.0, 120.0] {
            let params = json!({"text": ICON, "setup": {"work": work, "width": width}});
            let report = anna.ok("job.check", params).await;
            // Chords within 0.05 mm of the circle are 0.1 mm shorter in total.
            let round = std::f64::consts::PI * width;
            let drawn = report["drawn_mm"].as_f64().unwrap();
            assert!((drawn - round).abs() < 0.3, "{work} {width}: {drawn}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn pen_stays_above_the_surface_unless_depths_are_kept() {
    const TWO: &str = "G21 G90\nG0 Z5\nG0 X5 Y5\nG1 Z-0.2 F900\nX35\nY25\nG0 Z5\nG0 X0 Y0\nG1 Z-3\nX40\nY30\nX0\nY0\nG0 Z5\n";
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (setup, lowest) in [
        (json!({"place": true}), -60.0),
        (json!({"pen_z": -0.2, "surface": -55}), -55.0),
        (json!({"at": [230, 0], "move": [0, 0, -5]}), -60.0),
        (json!({"place": true, "depths": "keep"}), -62.8),
    ] {
        let report = anna
            .ok("job.check", json!({"text": TWO, "setup": setup}))
            .await;
        let least = report["bounds"]["z"][0].as_f64().unwrap();
        assert!((least - lowest).abs() < 1e-3, "{setup}: {report}");
        assert!(
            (report["drawn_mm"].as_f64().unwrap() - 190.0).abs() < 4.0,
            "{report}"
        );
    }
    let report = checked(&mut anna, json!({"move": [0, 0, -5]})).await;
    assert_eq!(report["bounds"]["z"][0], json!(-60.0), "{report}");
    let told = report["notes"].to_string();
    assert!(told.contains("5.0 mm below the surface"), "{told}");
}

#[tokio::test(start_paused = true)]
async fn frame_runs_as_a_job_and_marks_nothing() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let at = json!([220, 30]);
    for (setup, height) in [
        (json!({"tool": "laser", "at": at, "frame": "box"}), -60.0),
        (
            json!({"tool": "pen", "at": at, "frame": "hull", "lift": 5}),
            -55.0,
        ),
    ] {
        let report = checked(&mut anna, setup.clone()).await;
        assert_eq!(report["ok"], json!(true), "{report}");
        assert_eq!(
            (&report["drawn_mm"], report.get("power")),
            (&json!(0.0), None)
        );
        assert_eq!(report["travel_bounds"]["z"][0], json!(height), "{report}");
        let params = json!({"text": SQUARE, "setup": setup});
        let refused = anna.call("job.start", params.clone()).await.unwrap_err();
        assert_ne!(
            refused["code"],
            json!(-32602),
            "it wants a lease: {refused}"
        );
        let lease = anna.lease().await;
        let job = anna.ok("job.start", params).await["job"].clone();
        until(&mut anna, &job, "done").await;
        anna.ok("lease.release", json!({"lease": lease})).await;
    }
    let lit = json!({"tool": "laser", "frame": "box", "frame_power": 2});
    let report = checked(&mut anna, lit).await;
    assert_eq!(report["power"], json!({"most": 2.0, "least": 2.0}));
}

#[tokio::test(start_paused = true)]
async fn frame_uses_the_current_tool_and_refuses_an_unknown_one() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    for (bias, height, told) in [
        (70.0, -60.0, "the arm has the laser"),
        (61.0, -50.0, "the arm has the pen"),
        (0.0, -50.0, "the tool of the arm is unknown"),
    ] {
        let fields = json!({"x_bias": bias, "y_bias": 0.0, "z_bias": 0.0});
        let tool = json!({"command": "EndEffectorParams", "fields": fields});
        anna.ok("arm.set", tool).await;
        let setup = json!({"at": [220, 30], "frame": "box"});
        let report = checked(&mut anna, setup).await;
        assert_eq!(report["travel_bounds"]["z"][0], json!(height), "{report}");
        let first = report["notes"][0].to_string();
        assert!(first.contains(told), "{first}");
    }
    let there = json!({"to": [320, 0, 20, 0]});
    let refused = anna.call("arm.move", there).await.unwrap_err();
    let message = refused["message"].as_str().unwrap();
    assert!(
        message.contains("the tool is unknown to the arm"),
        "{refused}"
    );
}

/// Two layers, the second with two lines.
const LAYERS: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm' viewBox='0 0 40 40' fill='none'>\
    <g id='one' stroke='red'><path d='M5 5H35'/></g>\
    <g id='two' stroke='blue'><path d='M5 15H35'/><path d='M5 25H35'/></g></svg>";

#[tokio::test(start_paused = true)]
async fn check_lists_parts_and_assigns_lines_to_them() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let mut checked = async |setup: Value| {
        let params = json!({"text": LAYERS, "setup": setup, "preview": true});
        anna.ok("job.check", params).await
    };
    let of = |report: &Value, member: &str| {
        let all = report["parts"].as_array().unwrap().iter();
        Value::from(all.map(|part| part[member].clone()).collect::<Vec<_>>())
    };
    let lines = |report: &Value| {
        let all = report["preview"]["strokes"].as_array().unwrap().iter();
        Value::from(all.map(|line| line["part"].clone()).collect::<Vec<_>>())
    };
    // Parts are listed without `parts` as well; then lines have no part, and the time is that of
    // the whole.
    let plain = checked(json!({"at": [230, 0], "scale": 0.5})).await;
    assert_eq!(of(&plain, "name"), json!(["one", "two"]));
    assert_eq!(of(&plain, "strokes"), json!([1, 2]));
    assert_eq!(of(&plain, "color"), json!(["#ff0000", "#0000ff"]));
    assert_eq!(of(&plain, "drawn_mm"), json!([15.0, 30.0]));
    assert_eq!(of(&plain, "seconds"), json!([null, null]));
    assert_eq!(lines(&plain), json!([null, null, null]));

    let divided = json!({"at": [230, 0], "parts": "layer", "no_pause": true, "passes": 2});
    let report = checked(divided).await;
    assert_eq!(lines(&report), json!([1, 1, 2, 2, 2, 2]));
    let number = |member: &str, nth: usize| report["parts"][nth][member].as_f64().unwrap();
    assert!((number("drawn_mm", 0) - 60.0).abs() < 0.1, "{report}");
    assert!((number("drawn_mm", 1) - 120.0).abs() < 0.1, "{report}");
    // Only the travel before the first part is not in the times of the parts.
    let all = report["seconds"].as_f64().unwrap();
    let parts = number("seconds", 0) + number("seconds", 1);
    assert!(
        number("seconds", 0) > 1.0 && parts < all + 0.001,
        "{report}"
    );
    assert!(all - parts < 3.0, "{parts} of {all}");

    let only = json!({"at": [230, 0], "only": ["two"], "no_pause": true});
    let report = checked(only).await;
    assert_eq!(of(&report, "skipped"), json!([true, false]));
    assert_eq!(lines(&report), json!([2, 2]));
    assert_eq!(report["parts"][0]["seconds"], Value::Null);
}

#[tokio::test(start_paused = true)]
async fn list_of_parts_is_bounded() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let name = "ä".repeat(300);
    let layers: String = (0..400)
        .map(|nth| format!("<g id='{name}{nth}'><path d='M0 {nth}h5' stroke='red'/></g>"))
        .collect();
    let drawing = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm' viewBox='0 0 400 400'>{layers}</svg>"
    );
    let report = anna.ok("job.check", json!({"text": drawing})).await;
    let parts = report["parts"].as_array().unwrap();
    assert_eq!(parts.len(), 256);
    let longest = parts[0]["name"].as_str().unwrap().chars().count();
    assert_eq!(longest, 200);
}

#[tokio::test(start_paused = true)]
async fn test_grid_runs_as_a_program() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let grid = json!({"format": "magician-testgrid", "power": "20:60:3", "speed": "10:30:2"});
    let params = json!({"text": grid.to_string(), "setup": {"at": [240, 0]}});
    let report = anna.ok("job.check", params).await;
    assert_eq!(report["ok"], json!(true), "{report}");
    assert_eq!(report["power"], json!({"most": 60.0, "least": 20.0}));
    let [x, y] = middle(&report);
    assert!((x - 240.0).abs() < 0.1 && y.abs() < 0.1, "{report}");
}

#[tokio::test(start_paused = true)]
async fn unknown_setup_option_is_named() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (setup, param) in [
        (json!({"colour": "red"}), "setup.colour"),
        (json!({"scale": "2"}), "setup.scale"),
        (json!({"scale": -2}), "setup.scale"),
        (json!({"at": [1]}), "setup.at"),
        (json!({"at": "1,2"}), "setup.at"),
        (json!({"no_order": true}), "setup.no_order"),
        (json!({"order": 0}), "setup.order"),
        (json!({"work": "paint"}), "setup.work"),
        (json!({"frame": "circle"}), "setup.frame"),
        (json!({"frame_power": 2}), "setup.frame_power"),
        (json!({"raw": true, "fit": true}), "setup.raw"),
    ] {
        // Before the lease is required.
        for method in ["job.check", "job.start"] {
            let params = json!({"text": SQUARE, "setup": setup});
            let refused = anna.call(method, params).await.unwrap_err();
            let found = (&refused["code"], &refused["data"]["param"]);
            assert_eq!(found, (&json!(-32602), &json!(param)), "{refused}");
        }
    }
    let params = json!({"text": SQUARE, "setup": [1]});
    let refused = anna.call("job.check", params).await.unwrap_err();
    assert_eq!(refused["data"]["param"], json!("setup"));
}

#[tokio::test(start_paused = true)]
async fn preview_contains_the_remaining_lines() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let looked = |setup: Value| json!({"text": SQUARE, "setup": setup, "preview": true});
    let report = anna.ok("job.check", looked(json!({"at": [230, 0]}))).await;
    let strokes = report["preview"]["strokes"].as_array().unwrap();
    assert_eq!(strokes.len(), 1, "{strokes:?}");
    let mut members: Vec<_> = strokes[0].as_object().unwrap().keys().collect();
    members.sort();
    assert_eq!(members, ["height", "part", "points", "power", "reachable"]);
    assert_eq!(
        (&strokes[0]["part"], &strokes[0]["reachable"]),
        (&Value::Null, &json!(true))
    );
    // Travels to and from the lines, in space.
    let travels = report["preview"]["travels"].as_array().unwrap();
    let ends = travels.first().unwrap().as_array().unwrap().last().unwrap();
    assert_eq!(ends[2], strokes[0]["height"], "{travels:?}");
    let mut points = strokes[0]["points"].as_array().unwrap().clone();
    points.sort_by_key(ToString::to_string);
    points.dedup();
    let corners = [[220.0, -10.0], [220.0, 10.0], [240.0, -10.0], [240.0, 10.0]];
    assert_eq!(json!(points), json!(corners));
    let plain = anna.ok("job.check", json!({"text": SQUARE})).await;
    assert_eq!(plain.get("preview"), None);
    // Lines out of reach are shown where they would be.
    let far = anna.ok("job.check", looked(json!({"at": [320, 0]}))).await;
    assert_eq!(far["ok"], json!(false));
    let strokes = far["preview"]["strokes"].as_array().unwrap();
    assert!(
        strokes
            .iter()
            .any(|stroke| stroke["reachable"] == json!(false))
    );
}

#[tokio::test(start_paused = true)]
async fn g_code_without_start_begins_at_the_current_pose() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [210, -20, 0, 0]})).await;
    let report = anna.ok("job.check", json!({"text": RELATIVE})).await;
    assert_eq!(report["ok"], json!(true), "{report}");
    let note = report["notes"][0]["text"].as_str().unwrap();
    assert!(
        note.starts_with("it begins at the tool's position"),
        "{note}"
    );
    let job = anna.ok("job.start", json!({"text": RELATIVE})).await["job"].clone();
    let mut most = [f64::MIN; 2];
    loop {
        anna.listen(Duration::from_millis(50)).await;
        let pose = bench.arms[0].state().pose;
        most = [most[0].max(pose.x), most[1].max(pose.y)];
        if anna.ok("job.get", json!({"job": job})).await["state"] == json!("done") {
            break;
        }
    }
    assert!((most[0] - 220.0).abs() < 0.1, "{most:?}");
    assert!((most[1] - -5.0).abs() < 0.1, "{most:?}");
    let pose = bench.arms[0].state().pose;
    assert!((pose.x - 210.0).abs() < 0.1 && (pose.y - -20.0).abs() < 0.1);
    // An explicit start applies wherever the arm is.
    let there = json!({"start": [200, 10, 0], "raw": true});
    let params = json!({"text": RELATIVE, "setup": there});
    let report = anna.ok("job.check", params).await;
    let [x, y] = middle(&report);
    assert!(
        (x - 205.0).abs() < 0.1 && (y - 17.5).abs() < 0.1,
        "{report}"
    );
}

#[tokio::test(start_paused = true)]
async fn resumed_job_keeps_its_original_start_pose() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.lease().await;
    anna.ok("arm.move", json!({"to": [210, -20, 0, 0]})).await;
    let slow = RELATIVE.replace("F1200", "F300");
    let job = anna.ok("job.start", json!({"text": slow})).await["job"].clone();
    for _ in 0..200 {
        anna.listen(Duration::from_millis(50)).await;
        if bench.arms[0].state().pose.y > -12.0 {
            break;
        }
    }
    anna.ok("job.stop", json!({"job": job})).await;
    anna.ok("arm.move", json!({"to": [180, 60, 30, 0]})).await;
    anna.ok("job.resume", json!({"job": job})).await;
    let done = until(&mut anna, &job, "done").await;
    assert_eq!(done["step"], done["steps"]);
    let pose = bench.arms[0].state().pose;
    let there = (pose.x - 210.0).abs() < 0.1 && (pose.y - -20.0).abs() < 0.1;
    assert!(there, "{pose:?}");
    // A start in the middle needs the position at which the program started.
    let params = json!({"text": slow, "from": 3});
    let refused = anna.call("job.start", params).await.unwrap_err();
    assert!(
        refused["message"].as_str().unwrap().contains("setup.start"),
        "{refused}"
    );
}

/// Notes of a check: out of the arm's front, without a mark, or for another machine.
#[tokio::test(start_paused = true)]
async fn check_notes_report_placement_and_limitations() {
    const WIDE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='240mm' height='20mm' viewBox='0 0 240 20'>\
        <rect width='240' height='20' fill='none' stroke='black'/></svg>";
    const FOREIGN: &str = "G21 G90\nG0 X10 Y10 Z20\nG1 Z10 F600\nG1 X60\nG1 Y40\nG0 Z20\n";
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (text, format, setup, said) in [
        (
            WIDE,
            "svg",
            json!({}),
            "turned by 90 degrees to fit in front of the arm",
        ),
        (
            WIDE,
            "svg",
            json!({"turn": false}),
            "does not fit in front of the arm: lies at its ",
        ),
        (
            SQUARE,
            "svg",
            json!({"work": "draw", "tool": "laser"}),
            "the laser stays dark",
        ),
        (
            FOREIGN,
            "gcode",
            json!({"raw": true}),
            "its coordinates look like those of another machine",
        ),
    ] {
        let params = json!({"text": text, "format": format, "setup": setup});
        let report = anna.ok("job.check", params).await;
        let mut notes = report["notes"].as_array().unwrap().iter();
        let text = |note: &Value| note["text"].as_str().unwrap_or_default().to_owned();
        assert!(
            notes.any(|note| text(note).contains(said)),
            "{said}: {report}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn bad_setup_option_has_the_common_error_sentence() {
    let table = include_str!("../../../magician-program/tests/data/bad_options.json");
    let table: Vec<Value> = serde_json::from_str(table).unwrap();
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for entry in &table {
        let params = json!({"text": SQUARE, "setup": entry["options"]});
        let error = anna.call("job.check", params).await.unwrap_err();
        let (key, message) = (
            entry["key"].as_str().unwrap(),
            entry["message"].as_str().unwrap(),
        );
        assert_eq!(error["code"], json!(-32602), "{error}");
        assert_eq!(
            error["data"]["param"],
            json!(format!("setup.{key}")),
            "{error}"
        );
        assert_eq!(error["message"], json!(format!("`setup`: {message}")));
        // Below the limit of 200 messages per second.
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}
