use std::fs;

use super::*;

fn options(fields: Value) -> SetupOptions {
    SetupOptions::from_fields(fields.as_object().expect("an object")).expect("options")
}

#[test]
fn shipped_presets_are_valid_and_marked_untested() {
    let presets = Presets::default();
    let names = [
        "pen",
        "marker",
        "paper-cut",
        "wood-engrave",
        "leather-engrave",
    ];
    assert_eq!(presets.names(), names);
    for name in names {
        let preset = presets.load(name).expect(name);
        assert_eq!(preset.note.as_deref(), Some("not tried on a real arm"));
        assert!(preset.shipped && preset.path.is_none() && preset.options.tool.is_some());
    }
}

#[cfg(unix)]
#[test]
fn device_in_the_folder_is_listed_but_not_read() {
    let place = tempfile::tempdir().expect("a folder");
    let link = place.path().join("endless.toml");
    std::os::unix::fs::symlink("/dev/zero", link).expect("a link");
    let refused = Presets::at(place.path().to_owned()).load("endless");
    let told = refused.expect_err("no preset").to_string();
    assert!(told.contains("it is not a regular file"), "{told}");
}

#[test]
fn saved_preset_overrides_the_shipped_one() {
    let place = tempfile::tempdir().expect("a directory");
    let presets = Presets::at(place.path().join("presets"));
    let said = options(
        serde_json::json!({"tool": [1, 2, -3.5], "power": "5..80", "order": false, "at": [200, 0], "fill": "hatch", "speed": 20}),
    );
    let saved = presets
        .save("pen", Some("my \"own\""), &said)
        .expect("it is saved");
    let loaded = presets.load("pen").expect("it is there");
    assert_eq!(loaded, saved);
    assert_eq!(
        (&loaded.options, loaded.note.as_deref()),
        (&said, Some("my \"own\""))
    );
    presets.save("oak_2", None, &said).expect("it is saved");
    assert_eq!(presets.names().last().map(String::as_str), Some("oak_2"));
    let left: Vec<_> = fs::read_dir(place.path().join("presets"))
        .expect("a folder")
        .collect();
    assert_eq!(left.len(), 2, "nothing but the two");
    presets.remove("pen").expect("the file goes");
    assert!(presets.load("pen").expect("the shipped one").path.is_none());
    assert!(matches!(
        presets.remove("pen"),
        Err(PresetError::Shipped(_))
    ));
    assert!(matches!(
        presets.remove("oak"),
        Err(PresetError::Unknown(..))
    ));
    assert!(matches!(presets.load("oak"), Err(PresetError::Unknown(..))));
}

#[test]
fn invalid_preset_name_is_refused() {
    let place = tempfile::tempdir().expect("a directory");
    let presets = Presets::at(place.path().join("presets"));
    let said = options(serde_json::json!({"speed": 20}));
    let long = "a".repeat(65);
    for name in [
        "", ".", "..", "../x", "a/b", "a\\b", "/x", "-x", "a b", "ä", "x.toml", "NUL", "com1",
        "a\n", &long,
    ] {
        for outcome in [
            presets.load(name).map(drop),
            presets.save(name, None, &said).map(drop),
            presets.remove(name).map(drop),
        ] {
            assert!(matches!(outcome, Err(PresetError::Name(_))), "{name:?}");
        }
    }
    assert!(!place.path().join("presets").exists() && !place.path().join("x.toml").exists());
}

#[test]
fn error_in_a_preset_file_has_its_position() {
    for (text, line, column, part) in [
        ("sped = 20", 1, 1, "no sped"),
        ("# mine\nspeed = 'fast'", 2, 9, "speed is a number"),
        ("speed = 20\nwork = 'draw'", 2, 1, "no work"),
        ("frame = 'box'", 1, 1, "no frame"),
        ("note = 3", 1, 8, "quoted"),
        ("speed = -1", 1, 9, "not -1"),
        ("lift = nan", 1, 8, "not nan"),
        ("power = 120", 1, 9, "power"),
        ("width = 10\nheight = 20", 2, 10, "contradict"),
        ("fill_spacing = 1", 1, 16, "needs fill"),
        ("travel-speed = 1\ntravel_speed = 2", 2, 1, "twice"),
        ("font = 'a.ttf'", 1, 8, "font"),
        ("speed = ", 1, 9, ""),
        ("[speed]\na = 1", 1, 1, "speed"),
    ] {
        let problem = parse(text).expect_err(text);
        let place = (problem.origin.line, problem.origin.column);
        assert_eq!(place, (line, column), "{text}: {problem}");
        assert!(problem.message.contains(part), "{text}: {problem}");
    }
    let (_, options) = parse("travel-speed = 90\nlift = 5").expect("flags' names are known");
    assert_eq!(options.travel_speed, Some(90.0));
}

#[test]
fn bad_preset_option_has_the_common_error_sentence() {
    const TABLE: &str = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../magician-program/tests/data/bad_options.json"
    );
    /// Entries that no preset can contain: null, unknown keys, and options that a preset may
    /// not set.
    const INEXPRESSIBLE_ENTRIES: usize = 116;
    let table = fs::read_to_string(TABLE).expect("the table");
    let table: Vec<Value> = serde_json::from_str(&table).expect("JSON");
    let mut unsayable = 0;
    for entry in &table {
        let options = entry["options"].as_object().expect("options");
        let says = |(key, value): (&String, &Value)| {
            let is_known = SetupOptions::option(key).is_some();
            is_known && !EXCLUDED_OPTIONS.contains(&key.as_str()) && !value.is_null()
        };
        if !options.iter().all(says) {
            unsayable += 1;
            continue;
        }
        let text = toml::to_string(options).expect("TOML");
        // TOML writes NaN and infinity without quotes.
        let text = ["nan", "inf", "-inf"].iter().fold(text, |text, number| {
            text.replace(&format!("= \"{number}\""), &format!("= {number}"))
        });
        let problem = parse(&text).expect_err(&text);
        assert_eq!(entry["message"], problem.message.as_str(), "{text}");
    }
    assert_eq!(unsayable, INEXPRESSIBLE_ENTRIES, "of {}", table.len());
}

#[test]
fn options_that_cannot_be_reloaded_are_not_saved() {
    let place = tempfile::tempdir().expect("a directory");
    let presets = Presets::at(place.path());
    let mut with_font = SetupOptions::default();
    with_font.font = Some(FontChoice::file("a.ttf", vec![0]));
    for said in [
        SetupOptions::default(),
        with_font,
        options(serde_json::json!({"work": "draw"})),
    ] {
        let refused = presets.save("mine", None, &said);
        assert!(
            matches!(refused, Err(PresetError::Inexpressible(_))),
            "{refused:?}"
        );
    }
    assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 0);
}
