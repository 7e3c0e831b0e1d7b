//! The manual, docs/guide/SCENARIOS.md: its tables match the schema, and its examples are valid
//! scenarios.

use std::fmt::Write as _;
use std::path::Path;

use magician_sim::scenario::Scenario;
use serde_json::{Map, Value};

use super::EXAMPLES;

const MANUAL: &str = include_str!("../../../../../docs/guide/SCENARIOS.md");
const BEGIN: &str = "<!-- tables: begin -->\n";
const END: &str = "<!-- tables: end -->\n";

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// Allowed values of a key, in short.
fn range(value: &Value) -> String {
    if let Some(forms) = value["oneOf"].as_array() {
        let forms: Vec<_> = forms.iter().map(range).collect();
        return forms.join("; or ");
    }
    if let Some(words) = value["enum"].as_array() {
        let words: Vec<_> = words.iter().map(Value::to_string).collect();
        return words.join(", ");
    }
    match (text(value, "type"), text(value, "pattern")) {
        ("boolean", _) => "`true`, `false`".into(),
        ("array", _) => format!("{} of {}", value["minItems"], range(&value["items"])),
        ("string", "") => "text".into(),
        ("string", _) => "`\"#rrggbb\"`".into(),
        _ => {
            let bound = |name: &str| value[name].as_f64();
            match (
                bound("exclusiveMinimum"),
                bound("minimum"),
                bound("maximum"),
            ) {
                (Some(least), _, Some(most)) => format!("above {least} to {most}"),
                (None, Some(least), Some(most)) => format!("{least} to {most}"),
                (None, Some(least), None) => format!("from {least}"),
                other => panic!("{other:?}: {value}"),
            }
        }
    }
}

/// Merges the keys of all forms of a section. A key whose allowed words differ, such as `kind`,
/// gets the words of all forms.
fn merged(forms: &[&Value]) -> Map<String, Value> {
    let mut keys = Map::new();
    for form in forms {
        for (key, value) in form["properties"].as_object().expect("keys") {
            let known = keys.entry(key.clone()).or_insert_with(|| value.clone());
            let more = match (value.get("const"), value["enum"].as_array()) {
                (Some(word), _) => {
                    known["description"] = "Kind.".into();
                    vec![word.clone()]
                }
                (None, Some(words)) => words.clone(),
                (None, None) => continue,
            };
            let known = known.as_object_mut().expect("an object");
            let words = known
                .entry("enum")
                .or_insert_with(|| Value::Array(Vec::new()));
            let words = words.as_array_mut().expect("a list");
            words.extend(
                more.into_iter()
                    .filter(|word| !words.contains(word))
                    .collect::<Vec<_>>(),
            );
        }
    }
    keys
}

/// Default of a key that is left out.
fn default_text(forms: &[&Value], key: &str, value: &Value) -> String {
    let needs = |form: &&Value| {
        let needed = form["required"].as_array();
        needed.is_some_and(|needed| needed.iter().any(|name| name == key))
    };
    let forms_with_key: Vec<_> = forms
        .iter()
        .filter(|form| !form["properties"][key].is_null())
        .copied()
        .collect();
    if forms_with_key.len() == forms.len() && forms_with_key.iter().all(needs) {
        return "required".into();
    }
    if forms_with_key.iter().all(needs) && forms_with_key.len() < forms.len() {
        return "in some forms".into();
    }
    match value.get("default") {
        Some(default) => default.to_string(),
        None => "see meaning".into(),
    }
}

/// One line for each form; forms that differ only in their time share one.
fn lines_of(forms: &[&Value]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for form in forms {
        let keys = form["required"].as_array().expect("a list").iter();
        let keys: Vec<_> = keys
            .filter_map(Value::as_str)
            .map(|key| format!("`{key}`"))
            .collect();
        let line = format!(
            "* {} Required keys: {}.",
            text(form, "description"),
            keys.join(", ")
        );
        match lines.last_mut() {
            Some(last) if last.replace("`at`", "`index`") == line => {
                *last = last.replace("`at`", "`at` or `index`");
            }
            _ => lines.push(line),
        }
    }
    lines
}

fn tables() -> String {
    let schema: Value = serde_json::from_str(Scenario::SCHEMA).expect("JSON");
    let mut out = String::new();
    for (name, section) in schema["properties"].as_object().expect("sections") {
        let several = text(section, "type") == "array";
        let body = if several { &section["items"] } else { section };
        let forms: Vec<&Value> = match body["oneOf"].as_array() {
            Some(forms) => forms.iter().collect(),
            None => vec![body],
        };
        let title = match text(section, "type") {
            "array" => format!("[[{name}]]"),
            "object" => format!("[{name}]"),
            _ => name.clone(),
        };
        writeln!(out, "### `{title}`\n\n{}", text(section, "description")).unwrap();
        if forms.len() > 1 {
            out.push('\n');
            lines_of(&forms)
                .iter()
                .for_each(|line| writeln!(out, "{line}").unwrap());
        }
        out.push('\n');
        if text(section, "type") == "string" {
            continue;
        }
        out.push_str("| key | meaning | values | default |\n|---|---|---|---|\n");
        for (key, value) in &merged(&forms) {
            let default = default_text(&forms, key, value);
            writeln!(
                out,
                "| `{key}` | {} | {} | {default} |",
                text(value, "description"),
                range(value)
            )
            .unwrap();
        }
        out.push('\n');
    }
    out
}

#[test]
fn tables_of_the_manual_match_the_schema() {
    let (before, rest) = MANUAL.split_once(BEGIN).expect("a place for the tables");
    let (published, after) = rest.split_once(END).expect("an end of the tables");
    let tables = format!("\n{}", tables());
    if published != tables {
        let manual = Path::new(env!("CARGO_TARGET_TMPDIR")).join("SCENARIOS.md");
        std::fs::write(&manual, [before, BEGIN, &tables, END, after].concat()).expect("written");
        panic!(
            "docs/guide/SCENARIOS.md is out of date; it ought to be as {}",
            manual.display()
        );
    }
}

#[test]
fn examples_of_the_manual_are_valid_scenarios() {
    let blocks: Vec<&str> = MANUAL
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().expect("an end"))
        .collect();
    assert!(!blocks.is_empty());
    for block in blocks {
        assert!(Scenario::from_toml(block).is_ok(), "{block}");
    }
    for (name, _) in EXAMPLES {
        assert!(MANUAL.contains(name), "{name}");
    }
}
