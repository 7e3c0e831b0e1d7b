//! Checks that the page's sources contain no commands of the protocol and no figures of the arm:
//! these come from the station. `api.ts` is generated and exempt.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use magician_protocol::{Alarm, Row};
use magician_sim::Scenario;
use magician_station::api::RpcError;

use super::page::files;

/// Units behind a number of the arm.
const UNITS: [&str; 7] = ["mm", "deg", "°", "V", "Hz", "毫米", "度"];
/// Names of commands that are also words of the page.
const PAGE_WORDS: [&str; 2] = ["Pose", "Home"];

/// Returns the problems of a source, by line.
fn findings(source: &str) -> Vec<String> {
    let lines = (1..).zip(source.lines());
    lines
        .filter_map(|(at, line)| {
            let named = names().find(|name| is_quoted(line, name));
            let named = named.map(|name| format!("{at}: the command {name}"));
            named.or_else(|| number_with_unit(line).map(|number| format!("{at}: {number}")))
        })
        .collect()
}

fn names() -> impl Iterator<Item = &'static str> {
    (0..=u8::MAX)
        .filter_map(Row::with_id)
        .map(|row| row.name)
        .filter(|name| !PAGE_WORDS.contains(name))
}

fn is_quoted(line: &str, name: &str) -> bool {
    ['"', '\'', '`']
        .iter()
        .any(|quote| line.contains(&format!("{quote}{name}{quote}")))
}

/// Returns the first number with a unit.
fn number_with_unit(line: &str) -> Option<String> {
    // The path data of a picture contains numbers and letters.
    if line.contains("<path") || line.contains(" d=\"M") {
        return None;
    }
    let digits = |text: &str| text.ends_with(|sign: char| sign.is_ascii_digit());
    UNITS.iter().find_map(|unit| {
        let mut places = line.match_indices(unit);
        places.find_map(|(at, _)| {
            let (before, behind) = line.split_at(at);
            let word = behind[unit.len()..].chars().next();
            let ends = !word.is_some_and(|sign| sign.is_alphanumeric() || sign == '_');
            let number = before.strip_suffix(' ').unwrap_or(before);
            (ends && digits(number)).then(|| {
                let from = number.rfind(|sign: char| !sign.is_ascii_digit() && sign != '.');
                format!("{}{unit}", &before[from.map_or(0, |from| from + 1)..])
            })
        })
    })
}

#[test]
fn page_contains_no_command_and_no_figure_of_the_arm() {
    let studio = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studio/src");
    let mut all = files(&studio).expect("the sources");
    let ours = |name: &str| {
        [".ts", ".tsx", ".json"]
            .iter()
            .any(|end| name.ends_with(end))
    };
    // Tests may name numbers, and the gallery's programs stand for those of users.
    let is_free = |name: &str| {
        name.starts_with("said/")
            || [".test.ts", ".plan.json"]
                .iter()
                .any(|end| name.ends_with(end))
    };
    all.retain(|name, _| ours(name) && name != "api.ts" && !is_free(name));
    assert!(all.len() > 20, "the page has moved");
    let wrong: Vec<_> = { all.iter() }
        .flat_map(|(name, source)| {
            let found = findings(str::from_utf8(source).expect("text")).into_iter();
            found.map(move |found| format!("{name}:{found}"))
        })
        .collect();
    assert_eq!(wrong, [""; 0]);
}

#[test]
fn commands_and_figures_are_reported() {
    let source = "call(\"PTPCmd\");\nconst LEAST = -25; // 135 mm above\nconst POSE = \"Pose\";\nt(\"5 degrees\")\n`${z} mm`";
    assert_eq!(findings(source), ["1: the command PTPCmd", "2: 135 mm"]);
}

/// Returns the English texts of stations, by the keys under which the page translates them.
fn station_texts() -> BTreeSet<String> {
    let alarms = Alarm::TABLE
        .iter()
        .flat_map(|alarm| ["cause", "cure"].map(|what| format!("alarm.{}.{what}", alarm.code)));
    let errors = RpcError::CODES.iter().map(|code| format!("error.{code}"));
    let scenarios = Scenario::BUILT_IN
        .iter()
        .map(|(name, _)| format!("scenario.{name}"));
    alarms.chain(errors).chain(scenarios).collect()
}

#[test]
fn every_language_has_all_sentences_with_their_values() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studio/src/languages");
    let mut texts: BTreeMap<String, BTreeMap<String, String>> =
        { files(&folder).expect("the languages").into_iter() }
            .map(|(name, json)| {
                let texts =
                    serde_json::from_slice(&json).unwrap_or_else(|error| panic!("{name}: {error}"));
                (name, texts)
            })
            .collect();
    let english = texts.remove("en.json").expect("English");
    assert!(!texts.is_empty() && english.len() > 300);
    let from_stations = station_texts();
    for (name, texts) in &texts {
        let differs: Vec<_> = { english.keys().chain(texts.keys()).chain(&from_stations) }
            .filter(|key| match texts.get(*key) {
                Some(text) => !english.get(*key).map_or_else(
                    || from_stations.contains(*key),
                    |english| values(english) == values(text),
                ),
                None => true,
            })
            .collect();
        assert!(differs.is_empty(), "{name}: {differs:?}");
    }
}

/// Returns the names in braces.
fn values(text: &str) -> BTreeSet<&str> {
    let parts = text.split('{').skip(1);
    parts
        .filter_map(|part| part.split_once('}').map(|(name, _)| name))
        .collect()
}
