//! Examples of the API's documentation, each on a fresh station, and all in sequence on one.

use std::collections::BTreeMap;

use magician_station::Role;
use magician_station::api::{Example, METHODS, Needs};
use serde_json::{Value, json};

use crate::bench::{LocalStation, Tester};
use crate::schema_check;

fn example(method: &str) -> Example {
    let example = Example::of(method);
    example.unwrap_or_else(|| panic!("{method} has no example in src/api/examples.json"))
}

fn needs_lease(method: &str) -> bool {
    let row = METHODS.iter().find(|row| row.name == method);
    // The session that answers a question must be the holder.
    row.is_some_and(|row| row.needs != Needs::Nothing) || method == "lease.answer"
}

/// Opens a session with the hello of the example. Returns it with the answer.
async fn hello(bench: &LocalStation) -> (Tester, Value) {
    let mut tester = bench.socket(Some(Role::Teacher));
    let params = Value::Object(example("session.hello").params);
    let hello = tester.ok("session.hello", params).await;
    (tester, hello)
}

/// Calls a method with the parameters of its example and ids of earlier results.
async fn call(tester: &mut Tester, method: &str, earlier: &BTreeMap<String, Value>) -> Value {
    let example = example(method);
    let ids = example.after.as_ref().map(|after| &earlier[after]);
    let params = example.params_after(ids.unwrap_or(&Value::Null));
    if needs_lease(method) {
        tester.ok("lease.acquire", json!({})).await;
    }
    match &example.result {
        Some(shown) => {
            let result = tester.ok(method, params).await;
            assert!(
                alike(shown, &result),
                "{method} answers {result}, and its example {shown}"
            );
            result
        }
        None if method == "jog.keep" => {
            tester.notify(method, params);
            Value::Null
        }
        None => {
            let result = tester.ok(method, params).await;
            println!("{method} answers {result}");
            result
        }
    }
}

/// True if two results have the same members of the same types. Null and empty values match
/// anything.
pub(crate) fn alike(shown: &Value, found: &Value) -> bool {
    match (shown, found) {
        (Value::Null, _) | (_, Value::Null) => true,
        (Value::Bool(_), Value::Bool(_))
        | (Value::Number(_), Value::Number(_))
        | (Value::String(_), Value::String(_)) => true,
        (Value::Array(shown), Value::Array(found)) => {
            shown.is_empty() || found.iter().all(|item| alike(&shown[0], item))
        }
        // Members of events depend on their name.
        (Value::Object(shown), Value::Object(found)) => {
            shown.get("event") != found.get("event")
                || shown.len() == found.len()
                    && (shown.iter()).all(|(name, value)| {
                        found.get(name).is_some_and(|other| alike(value, other))
                    })
        }
        _ => false,
    }
}

#[tokio::test(start_paused = true)]
async fn every_example_succeeds_on_a_new_station() {
    for method in METHODS {
        let mut calls = vec![method.name.to_owned()];
        while let Some(after) = calls.last().and_then(|last| example(last).after) {
            calls.push(after);
        }
        let bench = LocalStation::recording(crate::recordings::Tapes::default()).await;
        let (mut tester, hello) = hello(&bench).await;
        let mut results = BTreeMap::from([("session.hello".to_owned(), hello)]);
        for name in calls.iter().rev().filter(|name| *name != "session.hello") {
            let result = call(&mut tester, name, &results).await;
            results.insert(name.clone(), result);
        }
    }
}

#[tokio::test(start_paused = true)]
async fn examples_succeed_in_sequence() {
    let bench = LocalStation::recording(crate::recordings::Tapes::default()).await;
    let (mut tester, hello) = hello(&bench).await;
    let mut results = BTreeMap::from([("session.hello".to_owned(), hello)]);
    for method in METHODS
        .iter()
        .filter(|method| method.name != "session.hello")
    {
        let result = call(&mut tester, method.name, &results).await;
        results.insert(method.name.to_owned(), result);
        if method.name == "arm.fence" {
            // The example of a check's report is of an arm without a fence.
            tester.ok("arm.fence", json!({"set": null})).await;
        }
    }
}

/// Methods and examples must match, and all but notifications have a result.
#[test]
fn examples_cover_existing_methods_completely() {
    let text = include_str!("../../src/api/examples.json");
    let examples: Value = serde_json::from_str(text).unwrap();
    for (name, example) in examples.as_object().unwrap() {
        assert!(METHODS.iter().any(|method| method.name == name), "{name}");
        assert_eq!(
            example.get("result").is_none(),
            name == "jog.keep",
            "{name}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn reports_options_and_presets_match_their_schemas() {
    let holds = |value: &Value, name: &str| {
        let checked = schema_check::check(value, schema_check::component(name));
        checked.unwrap_or_else(|why| panic!("{name}: {why} in {value}"));
    };
    let bench = LocalStation::new(1).await;
    let mut anna = bench.join_as("Anna", Role::Teacher).await;
    let svg = |size: f64| {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='{size}mm' height='{size}mm' viewBox='0 0 9 9'>\
             <g id='one'><path d='M1 1L8 8' stroke='red'/></g><text x='1' y='5'>\u{E123}</text></svg>"
        )
    };
    for (text, setup) in [
        (svg(40.0), json!({"surface": -60})),
        (svg(900.0), json!({"surface": -60, "tool": "laser"})),
        (
            svg(900.0),
            json!({"surface": -60, "fit": true, "preset": "pen"}),
        ),
        (
            "G21\nG90\nG1 X900 F600\nG1 X220 Y0 Z20\n".to_owned(),
            json!({}),
        ),
        ("G21\nG90\nG1 X220 Y0 Z20 F600\n".to_owned(), json!({})),
    ] {
        let params = json!({"text": text, "setup": setup, "preview": true});
        holds(&anna.ok("job.check", params).await, "Report");
    }
    let floor =
        json!({"set": {"floor": -50, "keep_out": [{"x": [0, 1], "y": [0, 1], "z": [0, 1]}]}});
    anna.ok("arm.fence", floor).await;
    let fenced = json!({"text": svg(40.0), "setup": {"surface": -60}});
    holds(&anna.ok("job.check", fenced).await, "Report");
    for format in magician_program::Format::ALL {
        for all in [false, true] {
            let params = json!({"format": format.name(), "all": all});
            let options = anna.ok("program.options", params).await["options"].clone();
            for option in options.as_array().unwrap() {
                holds(option, "Option");
            }
        }
    }
    anna.ok(
        "preset.save",
        json!({"name": "wrong", "setup": {"speed": 2}}),
    )
    .await;
    for preset in anna.ok("preset.list", json!({})).await["presets"]
        .as_array()
        .unwrap()
    {
        holds(preset, "Preset");
    }
    holds(
        &anna.ok("preset.show", json!({"name": "wrong"})).await,
        "Preset",
    );
}
