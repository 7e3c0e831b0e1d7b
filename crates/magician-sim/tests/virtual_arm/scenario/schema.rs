//! The schema for editors: it accepts what the parser accepts, and knows the same names.

use std::collections::BTreeSet;

use magician_sim::scenario::{Color, Scenario};
use serde_json::Value;

use super::EXAMPLES;

fn schema() -> Value {
    serde_json::from_str(Scenario::SCHEMA).expect("the schema is JSON")
}

fn as_json(text: &str) -> Value {
    let table: toml::Table = text.parse().expect("TOML");
    serde_json::to_value(table).expect("every scenario has a JSON form")
}

/// True if a value matches, for the keywords of JSON Schema in use; any other keyword is an error.
fn fits(schema: &Value, value: &Value) -> bool {
    let schema = schema.as_object().expect("a schema is an object");
    schema.iter().all(|(word, rule)| match word.as_str() {
        "$schema" | "title" | "description" | "default" => true,
        "type" => match rule.as_str().expect("one type") {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "integer" => value.is_i64(),
            "number" => value.is_number(),
            other => panic!("type {other}"),
        },
        "const" => value == rule,
        "enum" => rule.as_array().expect("a list").contains(value),
        "minimum" => value.as_f64() >= rule.as_f64(),
        "maximum" => value.as_f64() <= rule.as_f64(),
        "exclusiveMinimum" => value.as_f64() > rule.as_f64(),
        "minItems" => value
            .as_array()
            .is_some_and(|list| list.len() as u64 >= rule.as_u64().unwrap()),
        "maxItems" => value
            .as_array()
            .is_some_and(|list| list.len() as u64 <= rule.as_u64().unwrap()),
        "minLength" => value
            .as_str()
            .is_some_and(|text| text.len() as u64 >= rule.as_u64().unwrap()),
        "pattern" => {
            assert_eq!(rule, "^#[0-9a-fA-F]{6}$");
            value
                .as_str()
                .is_some_and(|text| text.starts_with('#') && Color::parse(text).is_some())
        }
        "items" => value
            .as_array()
            .is_some_and(|list| list.iter().all(|item| fits(rule, item))),
        "oneOf" => {
            rule.as_array()
                .unwrap()
                .iter()
                .filter(|one| fits(one, value))
                .count()
                == 1
        }
        "required" => {
            let needed = rule.as_array().unwrap().iter();
            needed
                .map(|name| name.as_str().unwrap())
                .all(|name| value.get(name).is_some())
        }
        "additionalProperties" => {
            assert_eq!(rule, false);
            let known = schema["properties"].as_object().unwrap();
            value
                .as_object()
                .is_some_and(|object| object.keys().all(|name| known.contains_key(name)))
        }
        "properties" => {
            let known = rule.as_object().unwrap();
            known
                .iter()
                .all(|(name, rule)| value.get(name).is_none_or(|value| fits(rule, value)))
        }
        other => panic!("the schema uses `{other}`"),
    })
}

#[test]
fn every_example_fits_the_schema() {
    for (name, text) in EXAMPLES {
        assert!(fits(&schema(), &as_json(text)), "{name}");
    }
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    for text in [
        "[robot]",
        "[table]\nheight = 900",
        "[table]",
        "[tool]\nkind = \"hammer\"",
        "[[input]]\naddress = 21\nlevel = 1",
        "[[input]]\naddress = 5",
        "[[input]]\naddress = 5\nlevel = 1\nvalue = 1",
        "[[fault]]\nkind = \"reset\"",
        "[[fault]]\nkind = \"reset\"\nat = 1\njoint = 2",
        "[[fault]]\nkind = \"slip\"\nat = 1\njoint = 5\ndegrees = 1",
        "[[sensor]]\nkind = \"color\"\nport = \"GP1\"",
        "[[object]]\nname = \"b\"\nsize = [1, 0, 1]\nat = [0, 0]\nz = 0",
        "[[object]]\nname = \"b\"\nsize = [1, 1, 1]\nat = [0, 0]\nz = 0\ncolor = \"mauve\"",
        "[[hand]]\nkind = \"unlock\"\nat = 1\njoints = [0, 0, 0, 0]",
        "[[key]]\npress = \"hard\"\nat = 1",
    ] {
        assert!(Scenario::from_toml(text).is_err(), "{text}");
        assert!(!fits(&schema(), &as_json(text)), "{text}");
    }
}

/// Names in the schema of a section, over all its forms.
fn names(schema: &Value) -> BTreeSet<String> {
    let forms = schema["items"]["oneOf"].as_array();
    let forms = forms.map_or_else(|| vec![schema], |forms| forms.iter().collect());
    let properties = forms
        .iter()
        .filter_map(|form| form["properties"].as_object());
    properties.flat_map(|names| names.keys().cloned()).collect()
}

/// Names that the parser suggests in place of an unknown one.
fn offered(text: &str) -> BTreeSet<String> {
    let error = Scenario::from_toml(text).expect_err("no such name");
    let (_, list) = error.message.split_once("expected").expect(&error.message);
    list.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn schema_and_reader_know_the_same_names() {
    let schema = schema();
    let sections = schema["properties"].as_object().unwrap();
    assert_eq!(names(&schema), offered("zzz = 1"));
    assert_eq!(sections.len(), 11);
    for (section, described) in sections {
        let text = match described["type"].as_str() {
            Some("object") => format!("[{section}]\nzzz = 1"),
            Some("array") => format!("[[{section}]]\nzzz = 1"),
            _ => continue,
        };
        assert_eq!(names(described), offered(&text), "{section}");
    }
}

#[test]
fn schema_and_reader_know_the_same_colors() {
    let schema = schema();
    let color = &schema["properties"]["object"]["items"]["oneOf"][0]["properties"]["color"];
    let listed = color["oneOf"][0]["enum"].as_array().unwrap().iter();
    let listed: Vec<_> = listed.filter_map(Value::as_str).collect();
    assert_eq!(listed, Color::NAMED.map(|(name, _)| name));
}
