//! Flags and JSON keys of options have the same meaning and the same error messages.

use std::collections::BTreeSet;

use clap::{Args, Command, FromArgMatches};
use magician_program::{OptionKind, OptionSpec, SetupOptions};
use serde_json::{Map, Value, json};

use super::options::{
    Draws, Engraves, Frames, Makes, OptionFlags, OptionSubset, Plays, RunsAll, Writes,
};
use crate::failure::Failure;

const BAD_OPTIONS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../magician-program/tests/data/bad_options.json"
);
/// Entries of the table that no command line can express: null, objects, a switch with a value,
/// pens without a file, a word as a number, and `work`, which the verb decides.
const WITHOUT_FLAG: usize = 399;

fn command<V: OptionSubset>() -> Command {
    OptionFlags::<V>::augment_args(Command::new("verb").args_override_self(true))
}

fn flags<V: OptionSubset>() -> BTreeSet<String> {
    let command = command::<V>();
    let flags = command.get_arguments().filter_map(clap::Arg::get_long);
    flags.map(str::to_owned).collect()
}

fn parse_options<V: OptionSubset>(arguments: &[String]) -> Result<SetupOptions, Failure> {
    let line = std::iter::once("verb").chain(arguments.iter().map(String::as_str));
    let matches = command::<V>().try_get_matches_from(line);
    let matches = matches.map_err(|error| Failure::from(&error))?;
    let flags = OptionFlags::<V>::from_arg_matches(&matches);
    flags.map_err(|error| Failure::from(&error))?.options(false)
}

/// Returns a value as the text of a flag; `None` if it has no such text.
fn text(row: &OptionSpec, value: &Value) -> Option<String> {
    let takes_words = row.kind == OptionKind::Choice || row.kind == OptionKind::Text;
    match (row.kind, value) {
        (OptionKind::Number | OptionKind::Integer, Value::Number(number)) => {
            Some(number.to_string())
        }
        (OptionKind::Text, Value::Number(number)) if !row.unit.is_empty() => {
            Some(number.to_string())
        }
        // On the command line a quoted number is a number.
        (_, Value::String(text)) => {
            let is_number = text.parse::<f64>().is_ok_and(f64::is_finite);
            (takes_words || !is_number && !text.contains(',')).then(|| text.clone())
        }
        (OptionKind::Point | OptionKind::Place | OptionKind::Area, Value::Array(items)) => {
            let part = |item: &Value| match item {
                Value::String(text) => Some(text.clone()),
                Value::Number(number) => Some(number.to_string()),
                _ => None,
            };
            let parts: Option<Vec<_>> = items.iter().map(part).collect();
            parts
                .filter(|parts| parts.len() > 1)
                .map(|parts| parts.join(","))
        }
        _ => None,
    }
}

/// Converts options into flags; `None` if one of them has no flag.
fn arguments(options: &Map<String, Value>) -> Option<Vec<String>> {
    let mut arguments = Vec::new();
    for (key, value) in options {
        let row = SetupOptions::option(key).filter(|row| RunsAll::accepts(row))?;
        let flag = key.replace('_', "-");
        match (row.kind, value) {
            (OptionKind::Switch, Value::Bool(true)) => arguments.push(format!("--{flag}")),
            (OptionKind::Switch, Value::Bool(false)) => arguments.push(format!("--no-{flag}")),
            (OptionKind::Switch | OptionKind::Pens, _) => return None,
            (OptionKind::List, Value::Array(items)) => {
                for item in items {
                    arguments.push(format!("--{flag}={}", item.as_str()?));
                }
            }
            (OptionKind::List, _) => return None,
            _ => arguments.push(format!("--{flag}={}", text(row, value)?)),
        }
    }
    Some(arguments)
}

#[test]
fn bad_flag_value_has_the_common_message() {
    let table = std::fs::read_to_string(BAD_OPTIONS).unwrap();
    let table: Vec<Value> = serde_json::from_str(&table).unwrap();
    let mut unsayable = 0;
    for entry in &table {
        let options = entry["options"].as_object().unwrap();
        let Some(arguments) = arguments(options) else {
            unsayable += 1;
            continue;
        };
        let failure = parse_options::<RunsAll>(&arguments).expect_err(&entry.to_string());
        assert_eq!(failure.kind.status(), 2, "{entry}");
        let (key, sentence) = (
            entry["key"].as_str().unwrap(),
            entry["message"].as_str().unwrap(),
        );
        let flag = format!("--{}", key.replace('_', "-"));
        let message = &failure.message;
        match SetupOptions::option(key).and_then(|row| row.needs) {
            Some(need) if sentence == format!("{key} needs {need}") => {
                let partner = format!("`--{}`", need.name.replace('_', "-"));
                let needs = need.to_string().replacen(need.name, &partner, 1);
                assert_eq!(*message, format!("`{flag}` needs {needs}"));
            }
            // Text other than the name of a built-in font is taken for a path, which does not exist
            // here.
            _ if key == "font" => {
                assert!(
                    message.starts_with(&format!("{flag}: {sentence}")),
                    "{message}"
                );
            }
            _ => assert_eq!(*message, format!("{flag}: {sentence}"), "{entry}"),
        }
    }
    assert_eq!(unsayable, WITHOUT_FLAG, "of {}", table.len());
}

/// Returns a valid value of an option, with the options it needs.
fn example(row: &OptionSpec) -> Map<String, Value> {
    let value = match row.kind {
        OptionKind::Choice => json!(row.choices[row.choices.len() - 1]),
        OptionKind::Number => json!(row.most.unwrap_or(4.5).min(4.5)),
        OptionKind::Integer => json!(3),
        OptionKind::Point => json!([230.0, -10.5]),
        OptionKind::Place => json!([1.0, -2.0, 3.5]),
        OptionKind::Area => json!([10, 20, 300, 200]),
        OptionKind::Switch => json!(row.is_off()),
        OptionKind::Text if row.name == "power" => json!("5..80"),
        OptionKind::Text => json!("2x3:40x-30.5"),
        OptionKind::List => json!(["red", "2"]),
        OptionKind::Pens => json!([{"match": "red", "lift": 4.0, "fill": "hatch"}]),
    };
    let mut options = Map::from_iter([(row.name.to_owned(), value)]);
    if let Some(need) = row.needs {
        let partner = SetupOptions::option(need.name).unwrap();
        let word = need.values.first().unwrap_or(&partner.choices[0]);
        options.insert(need.name.to_owned(), json!(word));
    }
    options
}

#[test]
fn flag_and_key_say_the_same() {
    for row in SetupOptions::OPTIONS
        .iter()
        .filter(|row| RunsAll::accepts(row))
    {
        let options = example(row);
        let of_keys = SetupOptions::from_fields(&options).unwrap();
        let arguments = match row.kind {
            OptionKind::Pens => {
                let path = std::env::temp_dir().join(format!("pens-{}.toml", std::process::id()));
                let pens = toml::to_string(&json!({"pen": options["pens"]})).unwrap();
                std::fs::write(&path, pens).unwrap();
                vec![format!("--pens={}", path.display())]
            }
            _ => arguments(&options).unwrap(),
        };
        assert_eq!(
            parse_options::<RunsAll>(&arguments).unwrap(),
            of_keys,
            "{arguments:?}"
        );
    }
}

#[test]
fn verbs_accept_the_options_of_their_work() {
    let [draw, engrave] = [flags::<Draws>(), flags::<Engraves>()];
    for (flag, of_draw, of_engrave) in [
        ("fill-spacing", true, true),
        ("image", true, false),
        ("lift", true, false),
        ("power", false, true),
        ("frame", false, true),
        ("mode", false, true),
        ("work", false, false),
    ] {
        assert_eq!(
            (draw.contains(flag), engrave.contains(flag)),
            (of_draw, of_engrave),
            "{flag}"
        );
    }
    let mut of_frame = flags::<Frames>();
    of_frame.insert("frame".to_owned());
    assert_eq!(of_frame, &draw | &engrave);
    assert_eq!(of_frame, flags::<RunsAll>());
    of_frame.retain(|flag| !flag.starts_with("frame"));
    assert_eq!(of_frame, flags::<Makes>());
    assert!(flags::<Writes>().contains("font") && !flags::<Writes>().contains("image"));
    assert!(flags::<Plays>().contains("grid") && !flags::<Plays>().contains("fill"));
}

#[test]
fn negative_value_is_a_value_and_no_flag() {
    let error = |argument: &str, value: &str| {
        let arguments = [argument.to_owned(), value.to_owned()];
        parse_options::<Draws>(&arguments).unwrap_err().message
    };
    assert_eq!(
        error("--scale", "-1"),
        "--scale: scale is a number above 0 and at most 10000, not -1"
    );
    assert_eq!(error("--margin", "5"), "`--margin` needs `--page`");
}
