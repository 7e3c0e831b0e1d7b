//! Presets: named sets of options.

use std::path::Path;
use std::process::Command;

use crate::magician::{Run, command, sample};
use serde_json::{Value, json};

/// Runs the command with a settings file in this folder.
fn with_settings(folder: &Path, arguments: &[&str]) -> Run {
    let mut command: Command = command();
    command.env("MAGICIAN_CONFIG", folder.join("config.toml"));
    Run::of(command.args(arguments), b"")
}

fn check(folder: &Path, more: &[&str]) -> Value {
    let image = sample("engrave_gradient.png");
    let arguments = [&["engrave", &image, "--check", "--json"], more].concat();
    with_settings(folder, &arguments).object()
}

#[test]
fn flag_overrides_preset_and_preset_overrides_settings() {
    let place = tempfile::tempdir().expect("a directory");
    let folder = place.path();
    std::fs::write(
        folder.join("config.toml"),
        "[engrave]\nspeed = 5\npower = 10\n",
    )
    .expect("written");
    let most = |more: &[&str]| {
        check(folder, more)["power"]["most"]
            .as_f64()
            .expect("a number")
    };
    let seconds = |more: &[&str]| check(folder, more)["seconds"].as_f64().expect("a number");
    let saved = with_settings(
        folder,
        &[
            "preset", "save", "birch", "--power", "60", "--note", "3 mm", "--json",
        ],
    );
    assert_eq!(
        saved.object()["options"],
        json!({"power": 60.0}),
        "{saved:?}"
    );
    assert!(most(&[]) <= 10.0);
    assert!((20.0..=60.0).contains(&most(&["--preset", "birch"])));
    assert!(most(&["--preset", "birch", "--power", "90"]) > 60.0);
    // Options that the preset does not set come from the settings.
    let slow = seconds(&["--preset", "birch"]);
    assert!(seconds(&["--preset", "birch", "--speed", "10"]) < 0.7 * slow);
    let notes = check(folder, &["--preset", "birch"])["notes"].to_string();
    assert!(notes.contains("preset birch: 3 mm"), "{notes}");
}

#[test]
fn presets_are_listed_shown_saved_and_removed() {
    let place = tempfile::tempdir().expect("a directory");
    let folder = place.path();
    let on = |arguments: &[&str]| with_settings(folder, arguments);
    let list = on(&["preset", "list"]);
    assert_eq!(
        list.out.matches("not tried on a real arm").count(),
        5,
        "{list:?}"
    );
    let shown = on(&["preset", "show", "wood-engrave"]);
    assert!(
        shown.out.contains("not tried on a real arm") && shown.out.contains("tool = \"laser\"")
    );
    let image = sample("engrave_gradient.png");
    let used = on(&["engrave", &image, "--preset", "wood-engrave", "--check"]);
    assert!(used.err.contains("not tried on a real arm"), "{used:?}");
    assert_eq!(on(&["preset", "save", "pen", "--lift", "3"]).status, 0);
    let pen = on(&["preset", "show", "pen", "--json"]).object();
    assert_eq!(
        (&pen["shipped"], &pen["options"]),
        (&json!(false), &json!({"lift": 3.0}))
    );
    assert!(folder.join("presets/pen.toml").exists());
    assert_eq!(on(&["preset", "remove", "pen"]).status, 0);
    assert_eq!(
        on(&["preset", "show", "pen", "--json"]).object()["shipped"],
        json!(true)
    );
    for (arguments, status, part) in [
        (&["preset", "remove", "pen"][..], 3, "cannot be removed"),
        (&["preset", "show", "oak"], 3, "no preset oak"),
        (&["preset", "show", "../config"], 3, "cannot be called"),
        (
            &["preset", "save", "../x", "--lift", "3"],
            3,
            "cannot be called",
        ),
        (
            &["preset", "save", "", "--lift", "3"],
            3,
            "cannot be called",
        ),
        (&["preset", "save", "empty"], 2, "no option"),
        (
            &["engrave", &image, "--check", "--preset", "../x"],
            3,
            "cannot be called",
        ),
    ] {
        let refused = on(arguments);
        assert_eq!(refused.status, status, "{refused:?}");
        assert!(refused.err.contains(part), "{refused:?}");
    }
    assert!(!folder.join("x.toml").exists());
}

#[test]
fn unknown_key_is_refused_with_its_position() {
    let place = tempfile::tempdir().expect("a directory");
    let folder = place.path();
    std::fs::create_dir(folder.join("presets")).expect("a folder");
    std::fs::write(
        folder.join("presets/odd.toml"),
        "speed = 20\n\n  sped = 3\n",
    )
    .expect("written");
    let image = sample("engrave_gradient.png");
    let refused = with_settings(folder, &["engrave", &image, "--check", "--preset", "odd"]);
    assert_eq!(refused.status, 3, "{refused:?}");
    assert!(
        refused.err.contains("odd.toml:3:3") && refused.err.contains("sped"),
        "{refused:?}"
    );
    // An invalid preset does not hide the others.
    let list = with_settings(folder, &["preset", "list", "--json"]).object();
    assert_eq!(list["presets"].as_array().expect("a list").len(), 6);
    let completed = with_settings(folder, &["completions", "bash"]);
    assert!(completed.out.contains("leather-engrave odd"));
}
