//! OpenRPC document, generated from the tables.

use serde_json::{Map, Value, json};

use super::schemas::components;
use super::shape::object;
use super::{
    CLOSE_CODES, ERRORS, EVENTS, Example, FEATURES, FRAME_FLAGS, FRAME_PARTS, METHODS, Method,
    NOTIFICATIONS, Needs, Notice, Notification, NotificationExample,
};
use crate::frame::FRAME_SIZE;

/// Returns the document: all methods and notifications with their schemas, and an example of each.
#[must_use]
pub fn openrpc() -> Value {
    let methods: Vec<_> = METHODS.iter().map(method).collect();
    let notifications: Vec<_> = NOTIFICATIONS.iter().map(notification).collect();
    let errors: Map<_, _> = { ERRORS.iter() }
        .map(|row| (row.name().to_owned(), row.to_value()))
        .collect();
    let close_codes = CLOSE_CODES.iter();
    let close_codes = close_codes.map(|(code, about)| json!({"code": code, "about": about}));
    let features = FEATURES.iter();
    let features = features.map(|row| json!({"name": row.name, "about": row.about}));
    json!({
        "openrpc": "1.3.2",
        "info": {
            "title": "Station of Dobot Magician arms",
            "version": "1",
            "license": {"name": "MIT OR Apache-2.0"},
        },
        "servers": [
            {
                "name": "socket",
                "url": "ws://127.0.0.1:8910/api/v1/ws",
                "description": "A session: one message of JSON-RPC in each text message, subprotocol magician.v1",
            },
            {
                "name": "request",
                "url": "http://127.0.0.1:8910/api/v1/rpc",
                "description": "One request by POST, for methods with x-session false; no notifications",
            },
        ],
        "methods": methods,
        "components": {"schemas": components(), "errors": errors},
        "x-notifications": notifications,
        "x-events": EVENTS.iter().map(|row| json!({
            "event": row.name,
            "summary": row.when,
            "x-instead": row.instead,
            "examples": NotificationExample::of(row.name).iter().map(notification_example).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "x-frame": frame(),
        "x-close-codes": close_codes.collect::<Vec<_>>(),
        "x-features": features.collect::<Vec<_>>(),
    })
}

fn notification(row: &Notification) -> Value {
    let params = if row.name == Notice::ArmEvent.name() {
        json!({"$ref": "#/components/schemas/Event"})
    } else {
        object(row.params)
    };
    json!({
        "name": row.name,
        "summary": row.when,
        "x-to": row.to,
        "x-channel": row.channel,
        "params": params,
        "examples": NotificationExample::of(row.name).iter().map(notification_example).collect::<Vec<_>>(),
    })
}

/// Returns the example of a notification: the calls that cause it, and its parameters.
fn notification_example(example: &NotificationExample) -> Value {
    let after = example
        .after
        .iter()
        .map(|said| json!({"client": said.client, "method": said.method, "params": said.params}));
    json!({
        "x-after": after.collect::<Vec<_>>(), "x-heard-by": example.recipient, "params": example.params,
    })
}

/// Returns the layout of the binary frame.
fn frame() -> Value {
    let parts = FRAME_PARTS.iter().map(|part| {
        json!({
            "offset": part.offset, "type": part.kind, "name": part.name, "unit": part.unit,
            "about": part.about,
        })
    });
    let flags = FRAME_FLAGS.iter();
    let flags = flags.map(|(bit, name, about)| json!({"bit": bit, "name": name, "about": about}));
    json!({
        "bytes": FRAME_SIZE,
        "order": "little endian",
        "parts": parts.collect::<Vec<_>>(),
        "flags": flags.collect::<Vec<_>>(),
    })
}

fn method(method: &Method) -> Value {
    let params = method.params.iter().map(|param| {
        json!({
            "name": param.name,
            "description": param.about,
            "required": param.required,
            "schema": param.kind.schema(),
        })
    });
    let example = Example::of(method.name);
    let schema = example.as_ref().map_or_else(|| json!({}), Example::shape);
    let examples: Vec<_> = example.iter().map(method_example).collect();
    let errors = ERRORS.iter().filter(|row| row.is_of(method));
    let errors = errors.map(|row| json!({"$ref": format!("#/components/errors/{}", row.name())}));
    json!({
        "name": method.name,
        "summary": method.about,
        "paramStructure": "by-name",
        "params": params.collect::<Vec<_>>(),
        "result": {"name": "result", "description": method.result, "schema": schema},
        "errors": errors.collect::<Vec<_>>(),
        "examples": examples,
        "x-role": method.role.name(),
        "x-lease": method.needs != Needs::Nothing,
        "x-session": method.session,
        "x-notification": method.name == "jog.keep",
    })
}

/// Returns the example of a method. `x-after` names the call whose result has its ids.
fn method_example(example: &Example) -> Value {
    let params = example
        .params
        .iter()
        .map(|(name, value)| json!({"name": name, "value": value}));
    let mut pairing = json!({
        "name": "example",
        "params": params.collect::<Vec<_>>(),
        "result": {"name": "result", "value": example.result},
    });
    if let Some(after) = &example.after {
        pairing["x-after"] = json!(after);
    }
    pairing
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Requirements of OpenRPC 1.3 that the functions above do not guarantee by themselves.
    #[test]
    fn every_example_satisfies_its_method() {
        let document = openrpc();
        let methods = document["methods"].as_array().unwrap();
        let known = |name: &Value| methods.iter().any(|method| method["name"] == *name);
        for method in methods {
            let name = &method["name"];
            let [example] = method["examples"].as_array().unwrap().as_slice() else {
                panic!("{name} has no example in src/api/examples.json");
            };
            let given = example["params"].as_array().unwrap();
            let params = method["params"].as_array().unwrap();
            let is_of = |given: &Value| params.iter().any(|param| param["name"] == given["name"]);
            assert!(given.iter().all(is_of), "{name}");
            for param in params.iter().filter(|param| param["required"] == true) {
                let has = given.iter().any(|given| given["name"] == param["name"]);
                assert!(has, "{name}: {}", param["name"]);
            }
            assert!(example.get("x-after").is_none_or(known), "{name}");
            if let Some(reference) = method["result"]["schema"]["$ref"].as_str() {
                let there = document.pointer(reference.trim_start_matches('#'));
                assert!(there.is_some(), "{name}: {reference}");
            }
        }
    }

    /// Finds objects without members, lists without items and schemas without a type: no types can
    /// be generated from them.
    fn bare(schema: &Value, place: &str, found: &mut Vec<String>) {
        let Value::Object(members) = schema else {
            return;
        };
        let one_of = ["anyOf", "oneOf"].iter().find_map(|key| members.get(*key));
        let kinds = match &members.get("type") {
            Some(Value::String(kind)) => vec![kind.as_str()],
            Some(Value::Array(kinds)) => kinds.iter().filter_map(Value::as_str).collect(),
            _ => Vec::new(),
        };
        let has = |name: &str| members.contains_key(name);
        let is_bare = match kinds.as_slice() {
            [] => one_of.is_none() && !has("$ref") && !has("enum") && !has("const"),
            kinds => {
                kinds.contains(&"object") && !has("properties") && !has("additionalProperties")
                    || kinds.contains(&"array") && !has("items")
            }
        };
        if is_bare {
            found.push(place.to_owned());
        }
        let of_names = members.get("properties").and_then(Value::as_object);
        for (name, schema) in of_names.into_iter().flatten() {
            bare(schema, &format!("{place}.{name}"), found);
        }
        for schema in one_of.and_then(Value::as_array).into_iter().flatten() {
            bare(schema, place, found);
        }
        for key in ["items", "additionalProperties"] {
            match members.get(key) {
                Some(Value::Array(items)) => {
                    for schema in items {
                        bare(schema, &format!("{place}[]"), found);
                    }
                }
                Some(schema) => bare(schema, &format!("{place}[]"), found),
                None => {}
            }
        }
    }

    #[test]
    fn every_schema_has_a_type() {
        let document = openrpc();
        let mut found = Vec::new();
        for method in document["methods"].as_array().unwrap() {
            let name = method["name"].as_str().unwrap();
            for param in method["params"].as_array().unwrap() {
                let place = format!("{name} {}", param["name"]);
                bare(&param["schema"], &place, &mut found);
            }
            // A notification has no result.
            if method["x-notification"] == false {
                bare(&method["result"]["schema"], name, &mut found);
            }
        }
        for (name, schema) in document["components"]["schemas"].as_object().unwrap() {
            bare(schema, name, &mut found);
        }
        for (name, error) in document["components"]["errors"].as_object().unwrap() {
            bare(&error["x-data"], name, &mut found);
        }
        for row in document["x-notifications"].as_array().unwrap() {
            bare(&row["params"], &row["name"].to_string(), &mut found);
        }
        assert!(found.is_empty(), "{found:#?}");
    }

    /// Every reference must resolve.
    #[test]
    fn every_reference_resolves() {
        fn look(value: &Value, document: &Value) {
            match value {
                Value::Object(members) => {
                    if let Some(reference) = members.get("$ref").and_then(Value::as_str) {
                        let there = document.pointer(reference.trim_start_matches('#'));
                        assert!(there.is_some(), "{reference}");
                    }
                    members.values().for_each(|value| look(value, document));
                }
                Value::Array(items) => items.iter().for_each(|value| look(value, document)),
                _ => {}
            }
        }
        let document = openrpc();
        look(&document, &document);
    }

    #[test]
    fn every_notification_and_event_has_an_example() {
        for row in NOTIFICATIONS {
            assert!(NotificationExample::of(row.name).is_some(), "{}", row.name);
        }
        for row in EVENTS {
            assert!(NotificationExample::of(row.name).is_some(), "{}", row.name);
        }
    }
}
