//! Values that every front end refuses: `data/bad_options.json`, also read by the tests of the
//! command, the station, the page, presets and Python.

use std::path::{Path, PathBuf};

use magician_program::{OptionKind, OptionSpec, SetupOptions, WorkOption};
use serde_json::{Map, Value, json};

/// Refused options, and the expected message.
struct BadOption {
    options: Map<String, Value>,
    key: String,
    message: String,
}

impl BadOption {
    /// # Panics
    /// If the options are accepted.
    fn of(options: Map<String, Value>) -> Self {
        let shown = Value::Object(options.clone());
        let error = SetupOptions::from_fields(&options).expect_err(&shown.to_string());
        let (key, message) = (error.key, error.message.into());
        Self {
            options,
            key,
            message,
        }
    }
}

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bad_options.json")
}

/// Values that an option refuses whatever the others are.
fn bad_values(row: &OptionSpec) -> Vec<Value> {
    let long = "x".repeat(1001);
    let mut bad = vec![Value::Null, json!({})];
    match row.kind {
        OptionKind::Number | OptionKind::Integer => {
            bad.extend(["nan", "inf", "-inf", "", "abc", "1,5", "1 mm"].map(Value::from));
            bad.extend([
                json!(true),
                json!([]),
                json!([1]),
                json!(1e300),
                json!(-1e300),
            ]);
            bad.extend(row.least.map(|least| json!(least - 1.0)));
            bad.extend(row.above.map(Value::from));
            bad.extend(row.above.map(|above| json!(above - 0.001)));
            bad.extend(row.most.map(|most| json!(most + 1.0)));
            if row.kind == OptionKind::Integer {
                bad.push(json!(1.5));
            }
        }
        OptionKind::Point | OptionKind::Place => {
            let count = if row.kind == OptionKind::Point { 2 } else { 3 };
            let with = |value: Value| {
                let mut values = vec![json!(0); count];
                values[count - 1] = value;
                Value::Array(values)
            };
            bad.extend([json!(1e300), json!(-10_001), json!(10_000.5)].map(with));
            bad.extend(["nan", "inf", "", "abc"].map(|text| with(text.into())));
            bad.extend([json!(vec![0; count - 1]), json!(vec![0; count + 1])]);
            bad.extend([json!([]), json!(1), json!("abc"), json!(""), json!(false)]);
        }
        OptionKind::Area => {
            bad.extend([
                json!([0, 0, 0, 10]),
                json!([0, 0, 10, 0]),
                json!([0, -1, 10, 10]),
            ]);
            bad.extend([
                json!([0, 0, 10]),
                json!([0, 0, 1.5, 10]),
                json!([0, 0, 1e300, 10]),
            ]);
            bad.extend([json!([0, 0, "nan", 10]), json!("abc"), json!(""), json!(7)]);
        }
        OptionKind::Switch => bad.extend([json!(1), json!("true"), json!("")]),
        OptionKind::Choice => {
            bad.extend([json!("else"), json!(""), json!(long), json!(1), json!(true)]);
        }
        OptionKind::Text => {
            bad.extend([
                json!("else"),
                json!(""),
                json!(long),
                json!(true),
                json!([1]),
            ]);
        }
        OptionKind::List => bad.extend([json!("a"), json!([1]), json!([long]), json!(1)]),
        OptionKind::Pens => bad.extend([
            json!([{}]),
            json!([{"match": 0}]),
            json!([{"match": 1, "lift": 0}]),
            json!([{"match": 1}, {"match": "red", "speed": 1e300}]),
            json!([{"match": 1, "power": 101}]),
            json!([{"match": 1, "passes": 0}]),
            json!([{"match": 1, "surface_offset": 101}]),
            json!([{"match": 1, "fill": "dots"}]),
            json!([{"match": 1, "colour": "red"}]),
            json!("pens.toml"),
        ]),
    }
    let more = match row.name {
        "power" => vec![
            json!(0),
            json!(101),
            json!("80..5"),
            json!("5..120"),
            json!("nan"),
        ],
        "page" => vec![
            json!("b7"),
            json!("0x100"),
            json!("20x1e9"),
            json!("20x100"),
        ],
        "grid" => vec![json!("0x1:1x1"), json!("2x2"), json!("1x1:infx1")],
        "tool" => vec![
            json!([1, 2]),
            json!([1, 2, 1e300]),
            json!("1,2"),
            json!("1,2,inf"),
        ],
        _ => Vec::new(),
    };
    bad.extend(more);
    bad
}

/// A valid value for an option.
fn good_value(row: &OptionSpec) -> Value {
    match row.kind {
        OptionKind::Switch => json!(true),
        OptionKind::Choice => json!(row.choices[0]),
        OptionKind::Point => json!([200, 0]),
        OptionKind::Place => json!([200, 0, 10]),
        OptionKind::Integer => json!(4),
        OptionKind::Number => json!(row.most.unwrap_or(5.0).min(5.0)),
        OptionKind::Text if row.unit == "%" => json!("50"),
        other => panic!("{other:?} has no example"),
    }
}

fn generated() -> Vec<BadOption> {
    let mut all = vec![
        json!({"colour": "red"}),
        json!({"by_file": true}),
        json!({"": 1}),
        json!({"work": "by_file"}),
        json!({"page": "a4", "margin": 105}),
    ];
    let good = |name: &str| good_value(SetupOptions::option(name).expect(name));
    for row in SetupOptions::OPTIONS {
        let name = row.name;
        all.extend(
            bad_values(row)
                .into_iter()
                .map(|value| json!({name: value})),
        );
        if let Some(need) = row.needs {
            all.push(json!({name: good(name)}));
            let partner = SetupOptions::option(need.name).expect(need.name);
            let others = partner.choices.iter();
            let others =
                others.filter(|word| !need.values.is_empty() && !need.values.contains(word));
            all.extend(others.map(|word| json!({name: good(name), need.name: word})));
        }
        for other in row.contradicts {
            all.push(json!({name: good(name), *other: good(other)}));
        }
        if let Some(work) = row.work {
            let other = match work {
                WorkOption::Draw => "engrave",
                _ => "draw",
            };
            let mut options = json!({name: good(name), "work": other});
            if let Some(need) = row.needs {
                let first = need.values.first().map(|word| json!(word));
                options[need.name] = first.unwrap_or_else(|| good(need.name));
            }
            all.push(options);
        }
    }
    let objects = all.into_iter().map(|options| match options {
        Value::Object(options) => BadOption::of(options),
        other => panic!("{other}"),
    });
    objects.collect()
}

#[test]
fn every_bad_value_is_refused_with_its_message() {
    let text = std::fs::read_to_string(path()).expect("the table");
    let table: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    assert!(table.len() >= 500, "{}", table.len());
    for entry in &table {
        let options = entry["options"].as_object().expect("options");
        let found = BadOption::of(options.clone());
        assert_eq!(found.key, entry["key"], "{entry}");
        assert_eq!(found.message, entry["message"], "{entry}");
    }
}

#[test]
fn every_option_has_bad_values_in_the_table() {
    let text = std::fs::read_to_string(path()).expect("the table");
    let table: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    for row in SetupOptions::OPTIONS {
        let count = table
            .iter()
            .filter(|entry| entry["key"] == row.name)
            .count();
        assert!(count >= 4, "{} has {count}: write the table anew", row.name);
    }
}

/// Regenerates the table. Run it after adding an option:
/// `cargo test -p magician-program --test program -- --ignored bad_options`.
#[test]
#[ignore = "writes the table anew"]
fn regenerate_the_table() {
    let lines = generated().into_iter().map(|bad| {
        let BadOption {
            options,
            key,
            message,
        } = bad;
        json!({"options": options, "key": key, "message": message}).to_string()
    });
    let lines: Vec<_> = lines.collect();
    std::fs::write(path(), format!("[\n{}\n]\n", lines.join(",\n"))).expect("written");
}
