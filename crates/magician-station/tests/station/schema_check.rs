//! Checks of messages against the schemas of the station's OpenRPC document.

use std::sync::LazyLock;

use magician_station::api::{NOTIFICATIONS, openrpc};
use serde_json::{Value, json};

static DOCUMENT: LazyLock<Value> = LazyLock::new(openrpc);

/// Checks that a value has the members of its schema, with the right types, and no others.
pub(crate) fn check(value: &Value, schema: &Value) -> Result<(), String> {
    if let Some(reference) = schema["$ref"].as_str() {
        let there = DOCUMENT.pointer(reference.trim_start_matches('#'));
        return check(value, there.ok_or(reference)?);
    }
    if let Some(choices) = schema["enum"].as_array() {
        let known = choices.contains(value);
        return known.then_some(()).ok_or(format!("{value} in {choices:?}"));
    }
    if let Some(constant) = schema.get("const") {
        return (value == constant)
            .then_some(())
            .ok_or(format!("{value} is not {constant}"));
    }
    for key in ["anyOf", "oneOf"] {
        if let Some(kinds) = schema[key].as_array() {
            let tried = kinds.iter().map(|kind| check(value, kind));
            let failed: Result<Vec<_>, ()> = tried.map(|one| one.err().ok_or(())).collect();
            return match failed {
                Err(()) => Ok(()),
                Ok(why) => Err(format!("{value} is none of {why:?}")),
            };
        }
    }
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let is = |allowed: &Value| match allowed.as_str() {
        Some("integer") => value.is_i64() || value.is_u64(),
        allowed => allowed == Some(kind),
    };
    let allowed = match &schema["type"] {
        Value::Array(kinds) => kinds.iter().any(is),
        one => is(one),
    };
    if !allowed {
        return Err(format!("{value} is no {}", schema["type"]));
    }
    match (value, &schema["items"]) {
        (Value::Array(values), Value::Array(items)) if values.len() != items.len() => {
            return Err(format!("{value} has not {} items", items.len()));
        }
        (Value::Array(values), Value::Array(items)) => {
            for (value, item) in values.iter().zip(items) {
                check(value, item)?;
            }
        }
        (Value::Array(values), item) => {
            for value in values {
                check(value, item)?;
            }
            let count = json!(values.len());
            let right = schema
                .get("minItems")
                .is_none_or(|least| count.as_u64() >= least.as_u64());
            if !right {
                return Err(format!("{value} has too few items"));
            }
        }
        _ => {}
    }
    let Some(members) = value.as_object() else {
        return Ok(());
    };
    let more = &schema["additionalProperties"];
    for (name, value) in members {
        let schema = match schema["properties"].get(name) {
            Some(known) => known,
            None if more.is_object() => more,
            None => return Err(format!("{name} is not known")),
        };
        check(value, schema).map_err(|why| format!("{name}: {why}"))?;
    }
    for name in schema["required"].as_array().into_iter().flatten() {
        if !members.contains_key(name.as_str().unwrap_or_default()) {
            return Err(format!("{name} is missing"));
        }
    }
    Ok(())
}

/// Returns the component with this name.
pub(crate) fn component(name: &str) -> &'static Value {
    &DOCUMENT["components"]["schemas"][name]
}

/// Checks a notification.
pub(crate) fn check_notification(message: &Value) {
    let method = message["method"].as_str().unwrap_or_default();
    let rows = DOCUMENT["x-notifications"].as_array().unwrap();
    let row = rows.iter().find(|row| row["name"] == method);
    let row = row.unwrap_or_else(|| panic!("{method} is not in the table of notifications"));
    if let Err(why) = check(&message["params"], &row["params"]) {
        panic!("{method}: {why}\nin {}", message["params"]);
    }
    let members: Vec<_> = message.as_object().unwrap().keys().collect();
    assert_eq!(members, ["jsonrpc", "method", "params"], "{method}");
    assert_eq!(rows.len(), NOTIFICATIONS.len());
}

/// Checks parameters and result of a successful call.
pub(crate) fn check_call(method: &str, params: &Value, result: &Value) {
    let rows = DOCUMENT["methods"].as_array().unwrap();
    let Some(row) = rows.iter().find(|row| row["name"] == method) else {
        return;
    };
    for param in row["params"].as_array().unwrap() {
        let Some(given) = param["name"].as_str().and_then(|name| params.get(name)) else {
            continue;
        };
        if let Err(why) = check(given, &param["schema"]) {
            panic!("{method}: {}: {why}\nin {params}", param["name"]);
        }
    }
    if let Err(why) = check(result, &row["result"]["schema"]) {
        panic!("{method} answers: {why}\nin {result}");
    }
}

/// Checks an error.
pub(crate) fn check_error(method: &str, error: &Value) {
    let errors = DOCUMENT["components"]["errors"].as_object().unwrap();
    let code = &error["code"];
    let kind = &error["data"]["kind"];
    let named = |row: &&Value| match row["x-data"]["properties"].get("kind") {
        Some(known) => known["enum"][0] == *kind,
        None => kind.is_null(),
    };
    let row = errors
        .values()
        .filter(|row| row["code"] == *code)
        .find(named);
    let row = row.unwrap_or_else(|| panic!("{method}: {error} is not in the table of errors"));
    let data = match &error["data"] {
        Value::Null => json!({}),
        data => data.clone(),
    };
    if let Err(why) = check(&data, &row["x-data"]) {
        panic!("{method} fails: {why}\nin {error}");
    }
}
