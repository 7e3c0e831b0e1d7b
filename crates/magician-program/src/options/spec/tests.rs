//! Tests of the option table: every row against the options it describes.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use super::*;
use crate::{ReadOptions, Setup, SetupDefaults};

/// A valid value for an option.
fn value(option: &OptionSpec) -> Value {
    let number = option.least.or(option.most).unwrap_or(1.5);
    match option.kind {
        OptionKind::Choice => json!(option.choices[0]),
        OptionKind::Number => json!(number),
        OptionKind::Integer => json!(number as i64),
        OptionKind::Point => json!([200, 0]),
        OptionKind::Place => json!([200, 0, -10]),
        OptionKind::Area => json!([0, 0, 10, 20]),
        OptionKind::Switch => json!(true),
        OptionKind::Text if option.name == "grid" => json!("2x3:40x30"),
        OptionKind::Text => json!("50"),
        OptionKind::List => json!(["a"]),
        OptionKind::Pens => json!([{"match": 1, "lift": 3}]),
    }
}

/// The option together with the option it is bound to.
fn fields(option: &OptionSpec, value: Value, all: &[OptionSpec]) -> Map<String, Value> {
    let mut fields = Map::from_iter([(option.name.to_owned(), value)]);
    if let (Some(with @ "work"), Some(word)) = (option.with, option.when.first()) {
        fields.insert(with.to_owned(), json!(word));
    } else if let Some(with) = option.with {
        let other = all.iter().find(|other| other.name == with);
        let other = other.unwrap_or_else(|| panic!("{option:?}"));
        let needed = match option.when.first() {
            Some(word) => {
                let known = option.when.iter().all(|word| other.choices.contains(word));
                assert!(known, "{option:?}");
                json!(word)
            }
            None => json!(true),
        };
        fields.insert(with.to_owned(), needed);
    }
    fields
}

#[test]
fn options_accept_values_of_their_kind_within_their_range() {
    for format in Format::ALL {
        let all = SetupOptions::options_for(format);
        let names: BTreeSet<_> = all.iter().map(|option| option.name).collect();
        assert_eq!(names.len(), all.len(), "{format}: one is there twice");
        for option in &all {
            let takes = |value: Value| {
                let fields = fields(option, value, &all);
                SetupOptions::from_fields(&fields).is_ok()
            };
            assert!(takes(value(option)), "{option:?}");
            for choice in option.choices {
                assert!(takes(json!(choice)), "{option:?} {choice}");
            }
            assert!(option.choices.is_empty() || !takes(json!("else")));
            for (bound, taken, beyond) in [
                (option.least, true, -1.0),
                (option.above, false, -1.0),
                (option.most, true, 1.0),
            ] {
                let Some(bound) = bound else { continue };
                let number = |number: f64| match option.kind {
                    OptionKind::Integer => json!(number as i64),
                    OptionKind::Point => json!([0, number]),
                    OptionKind::Place => json!([0, 0, number]),
                    _ => json!(number),
                };
                // A margin must leave some of its page.
                let is_margin = option.name == "margin" && beyond > 0.0;
                assert!(is_margin || takes(number(bound)) == taken, "{option:?}");
                assert!(!takes(number(bound + beyond)), "{option:?}");
            }
        }
    }
}

#[test]
fn every_option_except_work_applies_to_some_format() {
    let asked = Format::ALL.into_iter().flat_map(SetupOptions::options_for);
    let mut asked: BTreeSet<String> = asked.map(|option| option.name.to_owned()).collect();
    asked.insert("work".to_owned());
    let keys: BTreeSet<String> = SetupOptions::keys().into_iter().collect();
    assert_eq!(asked, keys);
}

#[test]
fn option_refused_by_one_kind_of_work_depends_on_the_other_kind() {
    for format in Format::ALL {
        let all = SetupOptions::options_for(format);
        let named = |name: &str| all.iter().find(|option| option.name == name);
        for option in all.iter().filter(|_| format != Format::TestGrid) {
            let takes = |work: &str| {
                let mut fields = Map::from_iter([("work".to_owned(), json!(work))]);
                // With all options it is bound to, up to the work.
                let mut next = Some(option);
                while let Some(option) = next {
                    for (name, value) in self::fields(option, value(option), &all) {
                        fields.entry(name).or_insert(value);
                    }
                    next = option.with.and_then(named);
                }
                SetupOptions::from_fields(&fields).is_ok()
            };
            let mut bound = Some(option);
            let work = loop {
                match bound {
                    Some(OptionSpec {
                        work: Some(work), ..
                    }) => break work.values(),
                    Some(option) => bound = option.with.and_then(named),
                    None => break &["draw", "engrave"],
                }
            };
            for name in ["draw", "engrave"] {
                assert_eq!(takes(name), work.contains(&name), "{option:?} {name}");
            }
        }
    }
}

#[test]
fn image_styles_depend_on_the_work_draw() {
    let all = SetupOptions::options_for(Format::Image);
    let bound = |name: &str| {
        let option = all.iter().find(|option| option.name == name).unwrap();
        (option.with, option.when)
    };
    assert_eq!(bound("image"), (Some("work"), &["draw"][..]));
    assert_eq!(bound("mode"), (Some("work"), &["engrave"][..]));
    assert_eq!(bound("gamma"), (None, &[][..]));
}

/// Result of the options.
fn setup_and_reading(options: &SetupOptions) -> (Setup, ReadOptions) {
    let setup = options.setup(&SetupDefaults::default());
    let reading = options.reading(&setup);
    (setup, reading)
}

#[test]
fn omitted_option_equals_its_default() {
    for format in Format::ALL {
        let all = SetupOptions::options_for(format);
        for option in all.iter().filter(|option| option.name != "tool") {
            let Some(default) = option.default else {
                continue;
            };
            let default = match (default, option.kind) {
                (DefaultValue::Number(number), OptionKind::Integer) => json!(number as i64),
                (default, _) => json!(default),
            };
            for work in ["draw", "engrave"] {
                let mut with = fields(option, default.clone(), &all);
                let taken = |fields: &Map<String, Value>| {
                    let mut fields = fields.clone();
                    fields.insert("work".to_owned(), json!(work));
                    SetupOptions::from_fields(&fields)
                };
                let Ok(said) = taken(&with) else {
                    // The option applies only to the other kind of work.
                    continue;
                };
                with.remove(option.name);
                let Ok(open) = taken(&with) else {
                    panic!("{option:?}");
                };
                let [said, open] = [said, open].map(|options| setup_and_reading(&options));
                // Images have a separate tolerance, used only for drawing them.
                let [said, open] = [said, open].map(|(setup, reading)| match option.name {
                    "tolerance" if format == Format::Image => String::new(),
                    "tolerance" => format!("{reading:?}"),
                    _ => format!("{setup:?} {reading:?}"),
                });
                // Naming `image` means drawing it; the others record that they were given.
                let named = ["image", "passes", "fill_angle"].contains(&option.name);
                // Same value for drawings, different one for programs.
                let programs = option.name == "dedupe";
                assert!(
                    named || programs || said == open,
                    "{option:?} {work} {format}"
                );
            }
        }
    }
}

#[test]
fn kinds_and_groups_have_unique_names() {
    for format in Format::ALL {
        for option in SetupOptions::options_for(format) {
            let shown = serde_json::to_value(option).unwrap();
            let name = |member: &str| shown[member].as_str().unwrap().to_owned();
            assert!(OptionKind::NAMES.contains(&name("kind").as_str()));
            assert!(OptionGroup::NAMES.contains(&name("group").as_str()));
        }
    }
}

#[test]
fn given_option_replaces_contradicting_options_of_a_preset() {
    let of =
        |fields: Value| SetupOptions::from_partial_fields(fields.as_object().unwrap()).unwrap();
    let preset = of(json!({
        "fill": "hatch", "fill_spacing": 0.5, "width": 60, "page": "a5", "margin": 5, "speed": 30
    }));
    let cases = [
        (json!({"fill": "none"}), ["fill_spacing"].as_slice()),
        (json!({"height": 30}), &["width"]),
        (json!({"fill": "contour", "speed": 5.0}), &[]),
    ];
    for (given, gone) in cases {
        let both = of(given.clone()).or(&preset).to_fields();
        for name in gone {
            assert!(!both.contains_key(*name), "{given}: {name}");
        }
        let kept = preset.to_fields();
        for (name, value) in kept
            .iter()
            .filter(|(name, _)| !gone.contains(&name.as_str()))
        {
            let value = given.get(name).unwrap_or(value);
            assert_eq!(both.get(name), Some(value), "{given}: {name}");
        }
    }
    // Options of the other work are replaced too, and that can be reported.
    let laser = of(json!({"tool": "laser", "power": 60, "mode": "dither", "speed": 10}));
    let draw = of(json!({"work": "draw"}));
    let both = draw.or(&laser);
    assert!(both.check().is_ok());
    assert_eq!(
        (both.power, both.mode, both.speed),
        (None, None, Some(10.0))
    );
    let unused = laser.not_applicable_to(draw.work);
    let unused: Vec<_> = unused.iter().map(|row| row.name).collect();
    assert_eq!(unused, ["power", "mode"]);
    assert!(laser.not_applicable_to(None).is_empty());
    // A requirement that the preset itself misses is still refused.
    let margin = of(json!({"margin": 5}));
    assert!(of(json!({"speed": 5})).or(&margin).check().is_err());
}
