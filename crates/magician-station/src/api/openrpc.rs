//! The methods as an OpenRPC document.

use serde_json::{Value, json};

use super::examples::components;
use super::{Example, METHODS, Method, Needs};

/// The document: every method with its parameters, from the table, and its example.
#[must_use]
pub fn openrpc() -> Value {
    let methods: Vec<_> = METHODS.iter().map(method).collect();
    json!({
        "openrpc": "1.3.2",
        "info": {
            "title": "Station of Dobot Magician arms",
            "version": "1",
            "license": {"name": "MIT OR Apache-2.0"},
        },
        "methods": methods,
        "components": {"schemas": components()},
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
    let examples: Vec<_> = example.iter().map(pairing).collect();
    json!({
        "name": method.name,
        "summary": method.about,
        "paramStructure": "by-name",
        "params": params.collect::<Vec<_>>(),
        "result": {"name": "result", "description": method.result, "schema": schema},
        "examples": examples,
        "x-role": method.role.name(),
        "x-lease": method.needs != Needs::Nothing,
        "x-session": method.session,
        "x-notification": method.name == "jog.keep",
    })
}

/// An example as the document has it: `x-after` names the call whose result has its ids.
fn pairing(example: &Example) -> Value {
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

    /// What OpenRPC 1.3 asks of a document beyond its members' names, which the functions above write.
    #[test]
    fn every_example_is_one_of_its_method() {
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
}
