//! Presets: stored, shown, used by checks and jobs.

use magician_station::Role;
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};

const SQUARE: &str = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm' viewBox='0 0 40 40'>\
    <rect x='10' y='10' width='20' height='20' fill='none' stroke='black'/></svg>";

async fn checked(tester: &mut Tester, setup: Value) -> Value {
    let params = json!({"text": SQUARE, "setup": setup});
    tester.ok("job.check", params).await
}

fn told(report: &Value) -> Vec<&str> {
    let notes = report["notes"].as_array().map(Vec::as_slice);
    let notes = notes.unwrap_or_default().iter();
    notes.filter_map(|note| note["text"].as_str()).collect()
}

#[tokio::test(start_paused = true)]
async fn preset_is_saved_shown_and_removed() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let list = anna.ok("preset.list", json!({})).await;
    let names = |list: &Value| {
        let all = list["presets"].as_array().unwrap().iter();
        all.map(|preset| preset["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let shipped = [
        "pen",
        "marker",
        "paper-cut",
        "wood-engrave",
        "leather-engrave",
    ];
    assert_eq!(names(&list), shipped);
    let pen = anna.ok("preset.show", json!({"name": "pen"})).await;
    assert_eq!(
        (&pen["shipped"], &pen["note"]),
        (&json!(true), &json!("not tried on a real arm"))
    );
    assert_eq!(pen["options"]["tool"], json!("pen"));

    let setup = json!({"speed": 12, "power": "5..60", "order": false});
    let saved = json!({"name": "birch", "note": "3 mm", "setup": setup});
    let saved = anna.ok("preset.save", saved).await;
    assert_eq!(saved["options"]["power"], json!("5..60"));
    assert_eq!(
        anna.ok("preset.show", json!({"name": "birch"})).await,
        saved
    );
    // The text of a preset is the content of a file and can be saved again.
    let again = json!({"name": "oak", "text": saved["text"]});
    let again = anna.ok("preset.save", again).await;
    assert_eq!(again["options"], saved["options"]);
    assert_eq!(again["note"], json!("3 mm"));
    let list = anna.ok("preset.list", json!({})).await;
    assert_eq!(names(&list)[5..], ["birch", "oak"]);

    let own = json!({"name": "pen", "setup": {"speed": 7}});
    anna.ok("preset.save", own).await;
    assert_eq!(
        anna.ok("preset.show", json!({"name": "pen"})).await["shipped"],
        json!(false)
    );
    let pen = json!({"name": "pen"});
    assert_eq!(anna.ok("preset.remove", pen.clone()).await, Value::Null);
    assert_eq!(
        anna.ok("preset.show", pen.clone()).await["shipped"],
        json!(true)
    );
    let stays = anna.call("preset.remove", pen).await.unwrap_err();
    assert_eq!(stays["data"]["kind"], json!("invalid-input"), "{stays}");
}

#[tokio::test(start_paused = true)]
async fn invalid_preset_is_refused_and_not_saved() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    for (method, params, param) in [
        ("preset.show", json!({"name": "oak"}), "name"),
        ("preset.show", json!({"name": "../x"}), "name"),
        ("preset.remove", json!({"name": "oak"}), "name"),
        ("preset.save", json!({"name": "oak"}), "setup"),
        ("preset.save", json!({"name": "oak", "setup": {}}), "setup"),
        (
            "preset.save",
            json!({"name": "oak", "setup": {"work": "draw"}}),
            "setup",
        ),
        (
            "preset.save",
            json!({"name": "oak", "setup": {"preset": "pen"}}),
            "setup.preset",
        ),
        (
            "preset.save",
            json!({"name": "oak", "setup": {"sped": 2}}),
            "setup.sped",
        ),
        (
            "preset.save",
            json!({"name": "a b", "setup": {"speed": 2}}),
            "name",
        ),
        (
            "preset.save",
            json!({"name": "oak", "text": "sped = 2"}),
            "text",
        ),
        (
            "preset.save",
            json!({"name": "oak", "text": "speed = 2", "note": "x"}),
            "setup",
        ),
    ] {
        let error = anna.call(method, params.clone()).await.unwrap_err();
        assert_eq!(error["code"], json!(-32602), "{params} {error}");
        assert_eq!(error["data"]["param"], json!(param), "{params} {error}");
    }
    let mut viewer = bench.join_as("Vera", Role::Viewer).await;
    viewer.ok("preset.list", json!({})).await;
    for (method, params) in [
        ("preset.save", json!({"name": "oak", "setup": {"speed": 2}})),
        ("preset.remove", json!({"name": "oak"})),
    ] {
        let error = viewer.call(method, params).await.unwrap_err();
        assert_eq!(error["code"], json!(-32001), "{error}");
    }
    let list = anna.ok("preset.list", json!({})).await;
    assert_eq!(list["presets"].as_array().map(Vec::len), Some(5));
}

#[tokio::test(start_paused = true)]
async fn explicit_options_override_the_preset_and_its_note_is_sent() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    let report = checked(&mut anna, json!({"preset": "wood-engrave", "surface": -60})).await;
    assert_eq!(report["power"]["most"], json!(70.0), "{report}");
    assert_eq!(
        told(&report)[0],
        "preset wood-engrave: not tried on a real arm"
    );
    let weaker = json!({"preset": "wood-engrave", "surface": -60, "power": 20});
    let weaker = checked(&mut anna, weaker).await;
    assert_eq!(weaker["power"]["most"], json!(20.0), "{weaker}");

    // An option that requires another one may get it from the preset.
    let filled = json!({"name": "filled", "setup": {"fill": "hatch", "surface": -60}});
    anna.ok("preset.save", filled).await;
    let spaced = json!({"preset": "filled", "fill_spacing": 2});
    let spaced = checked(&mut anna, spaced).await;
    assert_eq!(spaced["ok"], json!(true), "{spaced}");
    // A test grid has its own powers and speeds, regardless of the preset.
    let grid = json!({"format": "magician-testgrid", "power": "20:60:3", "speed": "10:30:2"});
    let setup = json!({"at": [240, 0], "preset": "wood-engrave"});
    let params = json!({"text": grid.to_string(), "setup": setup});
    let grid = anna.ok("job.check", params).await;
    assert_eq!(
        grid["power"],
        json!({"most": 60.0, "least": 20.0}),
        "{grid}"
    );
}

#[tokio::test(start_paused = true)]
async fn unknown_preset_is_reported_first() {
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join("Anna").await;
    anna.ok("program.put", json!({"name": "square.svg", "text": SQUARE}))
        .await;
    for (setup, why) in [
        (json!({"preset": "oak"}), "there is no preset oak"),
        (json!({"preset": "../x"}), "cannot be called"),
        (json!({"preset": 3}), "name of a preset"),
        (
            json!({"preset": "paper-cut", "raw": true, "at": [1, 2]}),
            "contradict",
        ),
    ] {
        for params in [
            json!({"text": SQUARE, "setup": setup}),
            json!({"program": "square.svg", "setup": setup}),
        ] {
            let check = anna.call("job.check", params.clone()).await.unwrap_err();
            assert_eq!(check["data"]["param"], json!("setup.preset"), "{check}");
            assert!(check["message"].as_str().unwrap().contains(why), "{check}");
            // Without the lease, whose error would come next.
            let start = anna.call("job.start", params).await.unwrap_err();
            assert!(
                why == "contradict" || start["data"]["param"] == json!("setup.preset"),
                "{start}"
            );
        }
    }
    let lease = anna.lease().await;
    let params = json!({"program": "square.svg", "setup": {"preset": "pen", "surface": -60}});
    let job = anna.ok("job.start", params).await["job"].clone();
    crate::jobs::until(&mut anna, &job, "done").await;
    anna.ok("lease.release", json!({"lease": lease})).await;
}
